// What the ship, the drum and the load did, by raw readings: the window of the boom tip, the count, the load cell.
#include "parts.h"

namespace heave {

namespace {

// Put a good reading into the window; the oldest bin is left out as a new one begins.
void fill_window(const Design &design, State &state) {
    if (state.bins[state.bin].time >= design.envelope.window / BINS) {
        state.bin = (state.bin + 1) % BINS;
        state.bins[state.bin] = Bin{};
    }
    Bin &bin = state.bins[state.bin];
    const bool is_first = bin.readings == 0.0;
    bin.rate = std::max(bin.rate, std::abs(state.rate));
    bin.highest = is_first ? state.heave : std::max(bin.highest, state.heave);
    bin.lowest = is_first ? state.heave : std::min(bin.lowest, state.heave);
    bin.sum += state.heave;
    bin.readings += 1.0;
    bin.time += state.read_age;
}

}  // namespace

// A reading is good where it is plausible, and goes with the one before: a jump of the heave is taken off.
void observe_mru(const Design &design, State &state, const Readings &readings) {
    const Bounds &bounds = design.envelope;
    state.seen_time = state.mru_age > bounds.mru_time && !has_load(design, state) ? 0.0 : state.seen_time + design.tick_period;
    state.mru_age += design.tick_period;
    state.read_age += design.tick_period;
    const double heave = readings.mru_heave;
    // what no ship does is no reading: taken for a jump it would stay in the heave
    if (!(std::abs(heave) <= bounds.largest_heave) || std::abs(readings.mru_rate) > bounds.largest_rate) return;
    const double step = heave - state.read_heave, time = state.read_age;
    const bool follows = std::isfinite(state.read_heave) && time <= bounds.mru_time;
    const double rate = std::isfinite(readings.mru_rate) ? readings.mru_rate : follows ? step / time : 0.0;
    bool is_good = std::abs(rate) <= bounds.largest_rate;
    if (follows) {
        const double off = step - 0.5 * (rate + state.read_rate) * time;
        const bool is_jump = std::abs(off) > bounds.heave_step;
        if (is_jump) state.jump += off;
        is_good = is_good && !is_jump && std::abs(rate - state.read_rate) <= bounds.largest_acceleration * time;
    }
    state.equal = heave == state.read_heave && rate == state.read_rate ? state.equal + 1 : 0;
    state.read_heave = heave;
    state.read_rate = rate;
    if (is_good && state.equal < bounds.frozen_readings) {
        state.heave = heave - state.jump;
        state.rate = rate;
        state.mru_age = 0.0;
        state.read_age = std::min(state.read_age, bounds.window / BINS);
        fill_window(design, state);
    }
    state.read_age = 0.0;
}

Ship ship_of(const Design &design, const State &state) {
    double rate = 0.0, highest = 0.0, lowest = 0.0, sum = 0.0, readings = 0.0, time = 0.0;
    for (const Bin &bin : state.bins) {
        if (bin.readings == 0.0) continue;
        rate = std::max(rate, bin.rate);
        highest = readings == 0.0 ? bin.highest : std::max(highest, bin.highest);
        lowest = readings == 0.0 ? bin.lowest : std::min(lowest, bin.lowest);
        sum += bin.sum;
        readings += bin.readings;
        time += bin.time;
    }
    if (readings == 0.0) return {0.0, 0.0, 0.0};
    const double mean = sum / readings;
    const double whole = design.envelope.window * (BINS - 1) / BINS;  // a bin is being filled
    // a unit that was let go, by a stop or without a load cell while the ship was not seen, is caught up with
    const double seen = state.mru_age > design.envelope.mru_time ? time : std::min(time, state.seen_time);
    return {rate, std::max(highest - mean, mean - lowest), std::min(seen / whole, 1.0)};
}

namespace {

// Where compensation follows on constant tension or a fade-out, the unit swings as these have left it.
bool lets_unit_swing(Duty before, Duty now) {
    return now == FOLLOW && (before == TENSION || before == FADE || before == DAMP);
}

// Spread of the stretch that the load cell shows; beyond the static one the cable is slack [m].
double swing_of(const Cable &cable, const State &state) {
    if (!(cable.stiffness > 0.0)) return 0.0;
    const double stretch = std::max(1.0 + state.position / cable.length, 0.01);
    return stretch * std::min(std::sqrt(state.measured.variance), cable.static_tension) / cable.stiffness;
}

// The unit on the nominal cable, a z'' + b z' + z = `top`, for a tick by the trapezoidal rule; a goes with the length, and b is
// no less than a share of sqrt(a).
void move_unit(const Design &design, double payout, double top, double &heave, double &heave_rate, double share = 0.0) {
    const Cable &cable = design.cable;
    const double dt = design.tick_period, a = cable.inertia * std::max(1.0 + payout / cable.length, 0.01);
    const double b = std::max({cable.damping, cable.drag * std::abs(heave_rate), share * std::sqrt(a)});
    const double h = 0.5 * dt / a, heavier = 1.0 + h * (b + 0.5 * dt), lighter = 1.0 - h * (b + 0.5 * dt);
    const double rate = (lighter * heave_rate + 2.0 * h * (top - heave)) / heavier;
    heave += 0.5 * dt * (heave_rate + rate);
    heave_rate = rate;
}

void follow(Spread &spread, double value, double weight) {
    if (std::isnan(spread.mean)) spread.mean = value;
    const double off = value - spread.mean;
    spread.mean += weight * off;
    spread.variance = (1.0 - weight) * (spread.variance + weight * off * off);
}

// Whether nothing but the sea moves the drum: no move is asked for, and no brake or stop acts.
bool moves_with_sea(const State &state, const Readings &readings) {
    return readings.brake == 0.0 && state.move.rate == 0.0 && readings.lift_rate == 0.0 && state.phase == FREE;
}

}  // namespace

// Whose the drift of the count is, the depth sensor can tell: it goes as the nominal unit does, whose payout is the count,
// where the drum creeps, and the other way than the drift where the count does. Both are smoothed alike, from where they were.
// A scale of the count and a motion reference unit that wanders show in the waves as well: D (D_z - D / 2) of the drift D and
// of the way D_z that the depth goes against it is below 0 where the drum creeps, above where the count drifts, in the mean.
// That unit is damped by half of what is critical: in one that rings for minutes they would add up.
void watch_depth(const Design &design, State &state, const Readings &readings) {
    const Bounds &bounds = design.envelope;
    Drift &drift = state.drift;
    const double dt = design.tick_period, left = 1.0 - dt / bounds.travel_time;
    const bool follows = int(readings.duty) == FOLLOW && moves_with_sea(state, readings);
    drift.time = follows ? drift.time + dt : 0.0;
    drift.age += dt;
    for (double *one : {&drift.off, &drift.way, &drift.seen}) *one *= follows ? left : 0.0;
    if (!follows) drift.against = 0.0;
    move_unit(design, state.position, state.heave - state.position, drift.heave, drift.heave_rate, 1.0);
    if (!std::isfinite(readings.depth)) return;
    const double level = readings.depth + drift.heave;
    if (!std::isfinite(drift.level)) drift.level = drift.shown = level;
    const double share = -std::expm1(-drift.age / bounds.drum_time);
    drift.shown += share * (level - drift.shown);
    drift.seen += share * (drift.off - drift.seen);
    if (follows) drift.level += (1.0 - left) * drift.age / dt * (drift.shown - drift.level);
    else drift.level += -std::expm1(-drift.age / bounds.bound_window) * (drift.shown - drift.level);
    const double against = drift.seen * (drift.level - drift.shown - 0.5 * drift.seen);
    drift.against += -std::expm1(-drift.age / bounds.travel_time) * (against - drift.against);
    drift.age = 0.0;
}

// Whether the depth has gone against the drift in the mean, and so the count drifts. Of a load that swings the nominal one may
// be as far off by another inertia alone: of a wave at its own frequency a mean over T leaves sqrt(a)/T.
static bool is_against(const Design &design, const State &state) {
    const double left = swing_of(design.cable, state) * std::sqrt(2.0 * design.cable.inertia) / design.envelope.travel_time;
    return !(state.drift.against < std::abs(state.drift.seen) * left);
}

// What the depth sensor has seen of the drift is the drum's, if it has not gone along.
void confirm_count(const Design &design, State &state) {
    Drift &drift = state.drift;
    if (is_against(design, state)) return;
    drift.off -= drift.seen;
    drift.way = drift.seen = drift.against = 0.0;
}

// Drift that a drive may have: it may be late, and of another gain, as that of the last second may; one against which the
// depth sensor has gone as far, and further than the load swings by the load cell, is the encoder's [m].
double drift_limit(const Design &design, const State &state) {
    const Bounds &bounds = design.envelope;
    const Drift &drift = state.drift;
    const double against = std::copysign(1.0, drift.off) * (drift.level - drift.shown);
    const bool is_far = against > bounds.travel_margin + swing_of(design.cable, state);
    const double unlike = bounds.drum_share * (state.drum_travel + std::abs(drift.way));
    return bounds.travel_margin + (is_far && is_against(design, state) ? 0.0 : unlike);
}

// Whether a count that has jumped goes along with the drum again: on a way, or for a window, in which it strays no more than
// a drum may. Where a limit or a brake acts the drum may have gone any part of what was sent: that way proves nothing.
// Returns bits.
int prove_count(const Design &design, State &state, double sent, double off) {
    const Bounds &bounds = design.envelope;
    const double seen = 2.0 * state.resolution, way = std::abs(sent) > 2.0 * seen ? std::abs(sent) : 0.0;
    state.unproved -= way + bounds.travel_margin * design.tick_period / bounds.window;
    if (std::abs(off) > seen) state.strayed += std::abs(off);
    if (state.unproved <= 0.0 && state.strayed > bounds.drum_share * bounds.travel_margin) {
        state.unproved = bounds.travel_margin;
        state.strayed = 0.0;
    }
    state.residual = 0.0;
    forget_strokes(state);
    return state.count_age > bounds.count_time ? COUNT_LOST : 0;
}

// Age of a count that comes late, by its stamp [s]: what was sent since then is not in it. A stamp that makes it older than a
// lost one, or no newer than the last one while it goes on, is not believed.
double age_of_count(const Design &design, const State &state, const Readings &readings, double step) {
    const bool is_late = readings.count_age > 0.0 && readings.count_age <= design.envelope.count_time;
    const bool is_next = state.time_since_count - readings.count_age > 1e-6;
    return is_late && (is_next || step == 0.0) ? std::min(readings.count_age, state.time_since_count) : 0.0;
}

// The count beside the nominal drum. Returns bits.
int observe_count(const Design &design, State &state, const Readings &readings, const Travelled &travelled) {
    const Bounds &bounds = design.envelope;
    const double dt = design.tick_period;
    const bool is_held = travelled.is_braked || readings.drive != DRIVE_FREE, rests = is_held && state.drum.rate == 0.0;
    // a unit that is let go by a stop swings, and what takes that out is more than the ship does (a limit of the drive lets
    // nothing go: orders that hit it must not widen their own bounds); how far a fade-out has left it swinging, the load
    // cell shows
    const bool lets_go = travelled.is_braked || readings.drive >= DRIVE_RESTS || int(readings.duty) == STOP;
    const bool begins = lets_unit_swing(Duty(int(state.duty)), Duty(int(readings.duty)));
    if ((lets_go && state.drum.rate != 0.0) || (begins && !has_load(design, state))) state.seen_time = 0.0;
    // what swings under a locked winch as following begins is stopped by more than the ship does
    if (int(readings.duty) == FOLLOW && int(state.duty) != FOLLOW)
        state.lead = std::max(state.lead, swing_of(design.cable, state));
    // a drive at its limit trails behind its orders, and comes back to them: further, not faster, than another one
    state.limited = readings.drive == DRIVE_LIMITED ? 1.0 : state.limited * (1.0 - dt / bounds.travel_time);
    state.duty = readings.duty;
    const double left = rests ? 1.0 : 1.0 - dt / bounds.travel_time;
    state.travel_sent = left * state.travel_sent + travelled.drum - travelled.move;
    state.travel_count *= left;
    if (!rests) state.residual *= 1.0 - dt / bounds.drum_time;
    state.drum_travel *= 1.0 - dt / bounds.drum_time;
    state.since_count += travelled.drum;
    state.asked_since_count += travelled.move;
    state.time_since_count += dt;
    state.count_age += dt;
    if (!count_came(bounds, readings)) return state.count_age > bounds.count_time ? COUNT_LOST : 0;
    const double step = readings.count - state.count, age = age_of_count(design, state, readings, step);
    const double later = way_since(design, state, age), moved = travelled.move * age / dt;
    const double sent = state.since_count - later, asked = state.asked_since_count - moved;
    const bool is_first = !std::isfinite(state.count);
    // one that goes on after it froze makes in a step what the drum did meanwhile; what was sent then is not known
    const bool thaws = state.count_age > bounds.count_time && state.still_time >= bounds.frozen_time && step != 0.0;
    const double time = state.time_since_count - age + (thaws ? state.still_time : 0.0);
    const double fastest = std::min(design.winch.speed, bounds.largest_rate);  // a drive without a limit: as the boom tip
    const bool is_jump = !is_first && std::abs(step - sent) > fastest * time + bounds.count_step;
    // no drum changes its speed so: the encoder is at fault, and no witness of the drum until it has gone along again, as long
    // as the winch follows the sea, or less and less of it, and nothing else, within the bounds on what is sent
    const double change = std::min(std::abs(step - sent), std::abs(step - state.step));
    const bool is_next = !is_first && time < 1.5 * dt;
    if (is_jump || (is_next && change > std::min(bounds.count_step, stroke_limit(bounds, state)))) {
        state.unproved = bounds.travel_margin;
        state.strayed = 0.0;
    }
    const int duty = int(readings.duty);
    if (!((duty == FOLLOW || duty == FADE || duty == DAMP) && moves_with_sea(state, readings))) state.unproved = 0.0;
    state.count = readings.count;
    state.step = step;
    state.since_count = later;
    state.asked_since_count = moved;
    state.time_since_count = age;
    if (is_first) {
        state.position = state.drum.payout = state.prompt.payout = readings.count;
        state.count_age = age;
        return 0;
    }
    state.position += is_jump ? sent : step;
    state.travel_count += (is_jump ? sent : step) - asked;
    if (is_jump) {  // the position loop goes by the new count
        take_way(design, state, sent, sent, time);
        state.drum.payout += step - sent;
        state.prompt.payout += step - sent;
        return COUNT_JUMPED | (state.count_age > bounds.count_time ? COUNT_LOST : 0);
    }
    count_way(design, state, step, sent, time);
    state.still_travel = step == 0.0 ? state.still_travel + std::abs(sent) : 0.0;
    state.still_time = step == 0.0 ? state.still_time + time : 0.0;
    if (state.still_travel > bounds.frozen_travel && state.still_time >= bounds.frozen_time) {
        state.count_age = bounds.count_time + dt;
        state.residual = 0.0;
        return COUNT_LOST;
    }
    // a drum that stops by itself may be anywhere between rest and what was sent; where its count was lost meanwhile, also
    // the last order that came to it may have gone on
    const bool went_on = readings.drive >= DRIVE_RESTS && time > bounds.count_time;
    const double expected = went_on ? step : is_held ? clip(step, std::min(sent, 0.0), std::max(sent, 0.0)) : sent;
    state.drum_travel += std::abs(sent);
    // a drum that suddenly goes otherwise than sent makes steps of its own in the load
    if (std::abs(step - expected) > 0.25 * bounds.count_step) state.taut_time = 0.0;
    if (state.unproved > 0.0) return prove_count(design, state, is_held ? 0.0 : sent, step - expected);
    if (!thaws) {
        state.residual += step - expected;
        state.drift.off += step - expected;
    }
    state.drift.way += step;
    state.count_age = age;
    // a drive that creeps is ordered against it for good: what was sent drifts, the count does not
    state.travel_sent += std::min(dt / bounds.bound_window, 1.0) * (state.travel_count - state.travel_sent);
    return 0;
}

// Step of the load cell beyond a share of the static tension and the stretch that the ship's motion makes since its last
// reading, k R t: no load does that on a cable that was taut. One that is caught from slack, or a drum that goes suddenly
// otherwise than sent, makes no more than T + 2 k R sqrt(a). It is taken off: spreads go on without it. 0: none [N].
double load_step(const Design &design, State &state, const Readings &readings, const Ship &ship) {
    const Bounds &bounds = design.envelope;
    state.load_age += design.tick_period;
    state.taut_time += design.tick_period;
    const double load = readings.load - state.load_jump, step = load - state.load;
    if (!(std::abs(readings.load) <= bounds.largest_load)) {
        return std::isfinite(step) && bounds.largest_load > 0.0 ? step : 0.0;
    }
    const Cable &cable = design.cable;
    const bool is_taut = state.taut_time > bounds.harm_time;
    const double caught = is_taut ? 0.0 : 2.0 * std::sqrt(cable.inertia), share = is_taut ? bounds.load_step : 1.0;
    const double stretch = (bounds.rate_factor * ship.rate + bounds.rate_margin) * (state.load_age + caught);
    const bool jumps = std::abs(step) > share * cable.static_tension + cable.stiffness * stretch;
    if (jumps) state.load_jump += step;
    else state.load = load;
    state.load_age = 0.0;
    if (state.load < bounds.load_taut * design.cable.static_tension) state.taut_time = 0.0;
    return jumps ? step : 0.0;
}

// Spread of the load cell over the largest that is no harm; NaN: not judged. The nominal cable is a z'' + b z' + z = x_0
// with the winch locked, z the first mode: near its resonance another a would beat with the load, and be at rest where that
// swings. The tension is k p (x_0 - z); k goes with one over the length.
double observe_load(const Design &design, State &state, const Readings &readings) {
    const Bounds &bounds = design.envelope;
    const Cable &cable = design.cable;
    const double dt = design.tick_period;
    const bool has_load = state.load_age == 0.0;
    if (has_load) {
        if (std::isnan(state.mean_load)) state.mean_load = state.load;
        state.mean_load += std::min(dt / bounds.bound_window, 1.0) * (state.load - state.mean_load);
    }
    if (!(cable.static_tension > 0.0)) return NOT_KNOWN;
    const double stretch = std::max(1.0 + state.position / cable.length, 0.01), k = cable.stiffness / stretch;
    move_unit(design, state.position, state.heave, state.unit_heave, state.unit_rate);
    const double weight = std::min(dt / bounds.harm_time, 1.0);
    if (has_load) follow(state.measured, state.load, weight);
    follow(state.locked, cable.participation * k * (state.heave - state.unit_heave), weight);
    const bool follows = int(readings.duty) == FOLLOW && readings.brake == 0.0 && state.move.rate == 0.0;
    const bool is_seen = state.mru_age <= bounds.mru_time && has_load;
    state.follow_time = follows && is_seen && readings.lift_rate == 0.0 ? state.follow_time + dt : 0.0;
    // what the load cell shows beside the nominal cable under a locked winch is another cable, or a swing: no harm
    const double felt = std::sqrt(state.measured.variance / state.locked.variance);
    if (state.held.time > bounds.harm_time && felt > 0.0) state.felt = clip(felt, 1.0, bounds.harm_felt);
    // a swing from before is no harm that following does: it is allowed while it fades
    if (state.follow_time <= dt) state.left = std::max(state.measured.variance - state.locked.variance, 0.0);
    state.left *= 1.0 - 0.5 * weight;
    if (state.follow_time < bounds.harm_time) {
        state.harm_time = 0.0;
        return NOT_KNOWN;
    }
    const double locked = state.felt * state.felt * state.locked.variance;
    const double most = bounds.harm_ratio * std::sqrt(locked + state.left) + bounds.harm_margin * cable.static_tension;
    const double share = std::sqrt(state.measured.variance) / most;
    state.harm_time = share > 1.0 ? state.harm_time + dt : 0.0;
    return share;
}

}  // namespace heave
