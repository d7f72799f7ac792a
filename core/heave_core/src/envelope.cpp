// The envelope: the last thing before an order leaves. It trusts no belief, estimate or design: it sees raw readings, what
// an operator asked for, and nominal values. Speed and travel about the asked move are bounded by what the ship did,
//
//     |v - v_move| <= R = f V + m,    v - v_move <= (D -+ e) / (delay + T),    D = f H + m,
//
// with V and H the largest rate and heave of the boom tip within the window and e the travel about the move, by the count
// and by the nominal drum that is driven by what was sent. What lies outside for long, a drum that does not do what was
// sent, a fade-out that does not end, or a load cell that shows harm, ends in the brake, latched.
#include "parts.h"

namespace heave {

bool has_load(const Design &design, const State &state) {
    return state.load_age <= design.envelope.mru_time && design.cable.stiffness > 0.0;
}

namespace {

struct Limits {
    double rate, travel;  // R [m/s], D [m]
    double in, out;       // orders, each way, with which the drum reaches R within `bound_time` [m/s]
    double lower, upper;  // of the order about the asked move, travel counted too [m/s]
};

// Order about the asked move with which the nominal drum, now at a speed v, reaches a speed V within a time t [m/s]:
// V = v + (v_set - v) (1 - exp(-t/T)). A drum with a lag needs orders ahead of its speed, and those are no harm.
double order_for(const Design &design, double reached, double now) {
    if (design.winch.is_first_order) return reached;  // its order is asked as the speed that it has at once
    return now + (reached - now) / -std::expm1(-design.envelope.bound_time / design.winch.lag);
}

// The bounds of a tick, of which an order may use a share.
Limits limits_of(const Design &design, const State &state, const Readings &readings, const Ship &ship, double share,
                 double move, double used = 1.0) {
    const Bounds &bounds = design.envelope;
    const bool has_count = state.count_age <= bounds.count_time, has_mru = state.mru_age <= bounds.mru_time;
    const double early = 1.0 + (bounds.early_factor - 1.0) * (1.0 - ship.filling);
    // a drive that was at its limit trails behind what was sent; its count goes no further than that of another one
    const double trails = 1.0 + (bounds.early_factor - 1.0) * state.limited;
    const double lost = has_count && has_mru ? 1.0 : bounds.lost_factor;
    const double swing = state.lead / std::sqrt(std::max(design.cable.inertia, 1.0));  // at the load's own frequency
    const double rate = used * (share * (bounds.rate_factor * (early * lost) * ship.rate + swing) + bounds.rate_margin);
    const double way = bounds.travel_factor * lost * ship.heave, more = bounds.travel_margin + state.allowance + state.lead;
    const double travel = used * (way * early + more), sent = used * (way * std::max(early, trails) + more);
    const double lag = design.winch.delay + design.winch.lag, now = state.drum.rate - move;
    double out = (sent - state.travel_sent) / lag, in = (sent + state.travel_sent) / lag;
    if (has_count) {
        out = std::min(out, (travel - state.travel_count) / lag);
        in = std::min(in, (travel + state.travel_count) / lag);
    }
    const bool gives_way = bounds.highest_tension > 0.0 && readings.load > bounds.highest_tension;
    if (gives_way) out = rate;
    const auto order = [&](double reached) { return order_for(design, reached, now); };
    return {rate, travel, std::max(-order(-rate), 0.0), std::max(order(rate), 0.0),
            std::min(order(-clip(in, 0.0, rate)), 0.0), std::max(order(clip(out, 0.0, rate)), 0.0)};
}

// By how much the drum leads or trails the asked move where the load follows it: of a z'' + b z' + z = -payout, and twice
// the inertia, as an operator who asks for the other way at once has the swing taken out as well [m].
double lead(const Design &design, const State &state) {
    const Move &move = state.move;
    if (int(move.kind) == NONE || int(move.kind) == STAND || !(design.cable.length > 0.0)) return 0.0;
    const double stretch = std::max(1.0 + state.position / design.cable.length, 0.01), speed = std::abs(move.rate);
    const double damping = std::max(design.cable.damping, design.cable.drag * speed);
    return stretch * (2.0 * design.cable.inertia * std::abs(move.slope) + damping * speed);
}

// Travel that constant tension may have, beyond the waves; it is forgotten as the travel is, and so is that of a move.
void follow_allowance(const Design &design, State &state, const Readings &readings) {
    const Bounds &bounds = design.envelope;
    state.lead = std::max(state.lead * (1.0 - design.tick_period / bounds.travel_time), lead(design, state));
    const bool gives_way = bounds.highest_tension > 0.0 && readings.load > bounds.highest_tension;
    if (gives_way) state.allowance += std::abs(state.drum.rate) * design.tick_period;
    if (int(readings.duty) != TENSION) {
        state.allowance *= 1.0 - design.tick_period / bounds.travel_time;
        state.held_tension = NOT_KNOWN;
        return;
    }
    const double held = readings.held_tension;
    const bool is_new = std::isfinite(held) && held != state.held_tension;
    if (is_new && std::isfinite(state.load) && design.cable.stiffness > 0.0) {
        const double change = std::abs(held - state.load) * (1.0 + state.position / design.cable.length);
        state.allowance = std::max(state.allowance, bounds.tension_travel + change / design.cable.stiffness);
        state.held_tension = held;
    }
    state.allowance = std::max(state.allowance, bounds.tension_travel);
}

void enter(State &state, Phase phase, Cause cause, double value, double limit) {
    if (state.phase == FREE || phase >= HELD) {
        state.cause = cause;
        state.value = value;
        state.limit = limit;
    }
    state.phase = phase;
    state.phase_time = 0.0;
    state.ramp = NOT_KNOWN;
}

double residual_limit(const Design &design, const State &state) {
    return design.envelope.drum_margin + design.envelope.drum_share * state.drum_travel;
}

// An emergency stop of the controller leaves the brake on, whatever it does: nothing is to move the drum.
bool is_emergency_stop(const Readings &readings) { return int(readings.duty) == STOP && readings.brake != 0.0; }

// A drum that its brake does not hold: a drive with power does, at an order of 0, as before the brake went on.
void catch_drum(State &state, const Readings &readings, double off, double limit) {
    const bool may_hold = readings.drive != DRIVE_FAILED && !is_emergency_stop(readings);
    enter(state, may_hold ? CAUGHT : HELD, BRAKE_SLIPS, off, limit);
}

// Until the order to hold has reached the drum it slips on: where it then stands it is held. Until then the drive may also
// have tripped by the same slip, which this order releases: to brake again would let the drum slip once more.
void follow_caught(const Design &design, State &state, const Readings &readings) {
    if (state.phase != CAUGHT) return;
    const bool is_taken = state.phase_time > design.winch.delay + design.envelope.count_time;
    if (is_emergency_stop(readings) || (is_taken && readings.drive == DRIVE_FAILED)) state.phase = HELD;
    if (is_taken) return;
    state.drum = state.prompt = Drum{state.count, 0.0};
    rest_drum(state);
}

// A drum that does not do what was sent: brake at once, whoever makes the order.
void watch_drum(const Design &design, State &state, const Readings &readings) {
    const Bounds &bounds = design.envelope;
    const bool is_known = state.cause == DRUM || (state.cause == BRAKE_SLIPS && state.phase != CAUGHT);
    if (is_known || state.unproved > 0.0) return;
    const double stroke = stroke_limit(bounds, state);
    const bool runs = std::abs(state.runaway) > stroke;
    const double off = runs ? state.runaway : state.residual;
    const double limit = runs ? stroke : residual_limit(design, state);
    if (!(std::abs(off) > limit)) return;
    if (state.phase == CAUGHT) state.phase = HELD;  // nor does the drive hold it: the brake goes on again
    else if (state.held.time > 0.0) catch_drum(state, readings, off, limit);
    else enter(state, HELD, DRUM, off, limit);
}

// A braked drum that moves: nothing that was ordered explains it.
void watch_held_drum(const Design &design, State &state, const Readings &readings, bool acts) {
    const bool is_braked = state.tick == 0 || state.sent[(state.tick - 1) % KEPT].brake != 0.0;
    watch_brake(design, state, readings, is_braked && (acts || readings.drive != DRIVE_FREE));
    if (state.held.rests != 0.0) rest_drum(state);
    // a count that rests between two steps goes to and fro by one
    const double limit = std::max(design.envelope.brake_margin, 1.5 * step_of_count(design.envelope, state));
    const double moved = state.held.moved;
    if (std::abs(moved) > limit && state.cause != BRAKE_SLIPS) catch_drum(state, readings, moved, limit);
}

// Fade-out and compensation without the motion reference unit end in time; harm that the load cell shows ends too.
void watch_duty(const Design &design, State &state, const Readings &readings, double harm) {
    const Bounds &bounds = design.envelope;
    const bool damps = int(readings.duty) == DAMP, moves = readings.brake == 0.0;
    const bool is_seen = state.mru_age <= bounds.mru_time && !damps;
    const bool fades = moves && (int(readings.duty) == FADE || damps), follows = moves && int(readings.duty) == FOLLOW;
    state.fade_time = !fades ? 0.0 : is_seen ? state.fade_time + design.tick_period : state.fade_time;
    state.blind_time = is_seen || !(fades || follows) ? 0.0 : state.blind_time + design.tick_period;
    const double longest = fades ? bounds.blind_time : bounds.unseen_time;
    if (state.phase != FREE) return;
    if (state.fade_time > bounds.fade_out_time) enter(state, TAKEN, FADE_LONG, state.fade_time, bounds.fade_out_time);
    else if (state.blind_time > longest) enter(state, TAKEN, UNSEEN, state.blind_time, longest);
    else if (state.harm_time >= bounds.harm_time) enter(state, TAKEN, HARM, harm, 1.0);
}

// A count that goes its own way for good: the load goes the other one, unless the depth sensor says that it does not.
void watch_drift(const Design &design, State &state, const Readings &readings) {
    watch_depth(design, state, readings);
    const double limit = drift_limit(design, state);
    if (std::abs(state.drift.off) > limit) confirm_count(design, state);
    if (std::abs(state.drift.off) > limit && state.phase == FREE) enter(state, TAKEN, DRIFT, state.drift.off, limit);
}

// Largest speed of a stop that is under way [m/s]: from the last order sent to rest.
double ramp(const Design &design, State &state) {
    const double dt = design.tick_period, fastest = std::max(std::abs(state.last_speed), std::abs(state.drum.rate));
    const bool begins = std::isnan(state.ramp);
    state.ramp = begins ? fastest : std::max(state.ramp - design.envelope.stop_deceleration * dt, 0.0);
    state.rest_time = begins || state.ramp > 0.0 ? 0.0 : state.rest_time + dt;
    return state.ramp;
}

struct Asked {
    double speed, ahead;  // [m/s], [m]
    bool is_finite;
};

// Travel about the asked move to which an order about it leads within the drum's delay and lag [m].
double travel_by(const Design &design, const State &state, double about, double move) {
    const Winch &winch = design.winch;
    const double now = state.drum.rate - move, share = -std::expm1(-design.envelope.bound_time / winch.lag);
    const double reached = winch.is_first_order ? about : now + share * (about - now), sent = state.travel_sent;
    const double counted = state.count_age <= design.envelope.count_time ? state.travel_count : sent;
    return (about > 0.0 ? std::max(sent, counted) : std::min(sent, counted)) + reached * (winch.delay + winch.lag);
}

constexpr double NEAR = 0.95;  // of what a controller uses

// Weight of an order for the time at a bound: one far outside counts for more, one that is kept just inside as the drum
// fails to follow what is sent, r^2: a loop that is lost does not stay there, one that stops a swinging load may.
double weight_of(const Design &design, const State &state, const Limits &limits, const Limits &usable, double about) {
    const double fastest = about < 0.0 ? limits.in : limits.out, off = state.residual / residual_limit(design, state);
    if (about < limits.lower || about > limits.upper) return std::max(std::abs(about) / std::max(fastest, 1e-3), 1.0);
    return about < NEAR * usable.lower || about > NEAR * usable.upper ? off * off : 0.0;
}

// Speed within the bounds [m/s], of which a controller uses a part; notes which one acts.
double bounded(const Design &design, State &state, const Limits &limits, const Limits &usable, const Asked &asked, double move,
               Order &order) {
    const Bounds &bounds = design.envelope;
    const double about = asked.speed - move, kept = clip(about, limits.lower, limits.upper), dt = design.tick_period;
    const double fastest = about < 0.0 ? limits.in : limits.out;
    const bool is_bound = kept != about;
    const bool by_rate = std::abs(about) > (is_bound ? fastest : NEAR * (about < 0.0 ? usable.in : usable.out));
    const double weight = weight_of(design, state, limits, usable, about);
    state.bound += (weight - state.bound / bounds.bound_window) * dt;
    if (is_bound) {
        order.bits += by_rate ? AT_RATE : AT_TRAVEL;
        order.value = about;
        order.limit = about > 0.0 ? limits.upper : limits.lower;
    }
    if (weight == 0.0) return asked.speed;
    if (state.bound > bounds.bound_time && by_rate) enter(state, TAKEN, RATE, about, fastest);
    else if (state.bound > bounds.bound_time) enter(state, TAKEN, TRAVEL, travel_by(design, state, about, move), limits.travel);
    return is_bound ? move + kept : asked.speed;
}

// Own order of a take-over: the asked move and the boom tip's raw rate, fading; where that did harm or must end, the
// controller's. A load that is let go swings for minutes: the drum pays out with the stretch that the load cell shows
// beyond its mean, v = c (F - mean F) / k, a dashpot in series with the cable. The order leads the drum,
// or rest, by no more than a (T + dt), which is all of its acceleration.
double own_speed(const Design &design, const State &state, const Limits &limits, const Asked &asked, double move) {
    const Bounds &bounds = design.envelope;
    const double share = std::max(1.0 - state.phase_time / bounds.takeover_time, 0.0);
    const bool has_mru = state.mru_age <= bounds.mru_time, is_wild = state.cause <= NOT_FINITE || state.cause == DRIFT;
    double about = 0.0;
    if (is_wild) about = has_mru ? state.rate : 0.0;
    else if (asked.is_finite && state.cause != UNSEEN) about = asked.speed - move;
    const double stretch = (state.load - state.mean_load) / design.cable.stiffness;
    const double damping = has_load(design, state) ? bounds.damping_rate * stretch : 0.0;
    const double wanted = share * about + clip(damping, -bounds.rate_margin, bounds.rate_margin);
    const Winch &winch = design.winch;
    const double now = state.prompt.rate - move, step = winch.acceleration * (winch.lag + design.tick_period);
    const double kept = clip(wanted, std::min(now, 0.0) - step, std::max(now, 0.0) + step);
    return move + clip(kept, limits.lower, limits.upper);
}

}  // namespace

void begin_envelope(State &state) {
    state = State{};
    for (double *unknown : {&state.ramp, &state.read_heave, &state.read_rate, &state.count, &state.load,
                            &state.held_tension, &state.drift.level, &state.mean_load, &state.measured.mean, &state.locked.mean})
        *unknown = NOT_KNOWN;
    state.mru_age = state.count_age = state.read_age = state.load_age = 1e9;
    state.move.request = -1.0;
    state.felt = 1.0;
}

void envelope(const Design &design, State &state, const Readings &readings, Order &order) {
    const Bounds &bounds = design.envelope;
    const Travelled travelled = advance_drum(design, state, state.load);
    observe_mru(design, state, readings);
    order = Order{};
    order.bits = observe_count(design, state, readings, travelled) + (state.mru_age > bounds.mru_time ? MRU_LOST : 0);
    const Ship ship = ship_of(design, state);
    take_request(design, state, readings, ship.heave);
    follow_allowance(design, state, readings);
    order.load_step = load_step(design, state, readings, ship);
    if (order.load_step != 0.0) order.bits += LOAD_JUMPED;
    if (readings.acknowledged != 0.0) state.load_known = state.load_jump;
    const double off = std::abs(state.load_jump - state.load_known);
    if (off > bounds.load_step * design.cable.static_tension) order.bits += LOAD_IS_OFF;
    order.harm = observe_load(design, state, readings);
    if (readings.acknowledged != 0.0 && state.phase >= HELD && state.drum.rate == 0.0) {
        state.phase = FREE;
        state.cause = NOTHING;
        state.bound = state.harm_time = state.follow_time = state.held.moved = 0.0;
        rest_drum(state);
    }
    watch_strokes(design, state);
    watch_held_drum(design, state, readings, travelled.is_braked);
    follow_caught(design, state, readings);
    watch_drum(design, state, readings);
    watch_duty(design, state, readings, order.harm);
    watch_drift(design, state, readings);

    const double move = state.move.rate + (std::abs(readings.lift_rate) <= bounds.largest_rate ? readings.lift_rate : 0.0);
    const bool by_payout = design.winch.is_first_order || design.winch.position_gain > 0.0;
    const double ahead = by_payout ? payout_ahead(design, state, state.load) : 0.0;
    const bool is_finite = std::isfinite(readings.payout) && std::isfinite(readings.rate);
    const Asked asked{is_finite ? speed_of(design.winch, readings.payout, readings.rate, ahead) : 0.0, ahead, is_finite};
    const bool stops = int(readings.duty) == STOP && state.phase == FREE;
    if (!is_finite && state.phase == FREE) enter(state, stops ? RAMP : TAKEN, NOT_FINITE, NOT_KNOWN, NOT_KNOWN);
    const double share = state.phase == TAKEN ? std::max(1.0 - state.phase_time / bounds.takeover_time, 0.0) : 1.0;
    const Limits limits = limits_of(design, state, readings, ship, share, move);
    const Limits usable = limits_of(design, state, readings, ship, share, move, bounds.used_share);

    double speed = asked.speed;
    bool brake = readings.brake != 0.0;
    if (brake && state.phase != FREE && state.phase != CAUGHT) state.phase = HELD;
    if (state.phase == FREE && stops) {
        const double most = ramp(design, state) + bounds.stop_margin;
        speed = clip(asked.speed, -most, most);
        if (speed != asked.speed) order.bits += AT_STOP;
        brake = brake || state.rest_time > bounds.stop_time;
    } else if (state.phase == FREE) {
        state.ramp = NOT_KNOWN;
        if (!brake) speed = bounded(design, state, limits, usable, asked, move, order);
    }
    const double damped = has_load(design, state) ? bounds.damping_time : 0.0;
    if (state.phase == TAKEN && state.phase_time > bounds.takeover_time + damped) state.phase = RAMP;
    if (state.phase == TAKEN) speed = own_speed(design, state, limits, asked, move);
    if (state.phase == RAMP) {
        speed = std::copysign(ramp(design, state), state.last_speed);
        if (state.rest_time > 0.0) state.phase = HELD;
    }
    const bool holds = state.phase == CAUGHT;
    brake = !holds && (brake || state.phase == HELD);

    order.payout = readings.payout;
    order.rate = readings.rate;
    order.brake = brake;
    if (!is_finite || holds) {
        order.payout = by_payout ? ahead : 0.0;
        order.rate = 0.0;
    }
    if (brake && readings.brake == 0.0) order.rate = 0.0;
    else if (!brake && !holds && (speed != asked.speed || !is_finite)) set_speed(design.winch, speed, ahead, order.payout, order.rate);
    state.last_speed = brake || holds ? 0.0 : speed;
    state.phase_time += design.tick_period;
    state.sent[state.tick % KEPT] = Sent{order.payout, order.rate, order.brake, move};
    state.tick += 1;
    if (readings.brake == 0.0) advance_move(state.move, design.tick_period, bounds.jerk_time);

    if (state.phase != FREE) {
        order.value = state.value;
        order.limit = state.limit;
    }
    order.phase = state.phase;
    order.cause = state.cause;
    order.rate_bound = limits.rate;
    order.travel_bound = limits.travel;
    order.move_rate = move;
    order.travel_sent = state.travel_sent;
    order.travel_count = state.travel_count;
    order.residual = state.residual;
    order.residual_limit = residual_limit(design, state);
    order.speed = state.last_speed;
    const bool is_bounded = state.phase == FREE && !stops;
    order.lowest = is_bounded ? set_point_of(design.winch, move + usable.lower) : -ANY;
    order.highest = is_bounded ? set_point_of(design.winch, move + usable.upper) : ANY;
}

}  // namespace heave
