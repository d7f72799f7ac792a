// The nominal drum, driven by what was sent: v' = (v_set - v)/T within the limits, or u' = K (u_0 - u).
#include "parts.h"

namespace heave {

namespace {

const Sent BRAKED{0.0, 0.0, 1.0, 0.0};

// Order of a tick; before the first one the brake is on.
const Sent &sent_at(const State &state, int tick) { return tick < 0 ? BRAKED : state.sent[tick % KEPT]; }

struct Delay {
    int whole;    // ticks
    double part;  // of a tick
};

Delay delay_of(const Design &design) {
    const double ticks = design.winch.delay / design.tick_period, nearest = std::round(ticks);
    if (std::abs(ticks - nearest) < 1e-6) return {int(nearest), 0.0};
    return {int(ticks), ticks - std::floor(ticks)};
}

double largest_speed(const Winch &winch, double load) {
    return winch.power > 0.0 && load > 0.0 ? std::min(winch.speed, winch.power / load) : winch.speed;
}

// The drum for a time under an order; on its brake it comes to rest at the deceleration of a stop.
void advance(const Design &design, Drum &drum, const Sent &sent, double time, double load) {
    const Winch &winch = design.winch;
    if (time <= 0.0) return;
    const double before = drum.rate, step = winch.acceleration * time, reached = -std::expm1(-time / winch.lag);
    if (sent.brake != 0.0) {
        const double slower = design.envelope.stop_deceleration * time;
        drum.rate = std::copysign(std::max(std::abs(before) - slower, 0.0), before);
    } else if (winch.is_first_order) {
        const double travel = largest_speed(winch, load) * time;
        const double way = clip((sent.payout - drum.payout) * reached, -travel, travel);
        drum.payout += way;
        drum.rate = way / time;
        return;
    } else {
        const double wanted = speed_of(winch, sent.payout, sent.rate, drum.payout), fastest = largest_speed(winch, load);
        drum.rate = clip(before + clip((wanted - before) * reached, -step, step), -fastest, fastest);
    }
    drum.payout += 0.5 * (before + drum.rate) * time;
}

}  // namespace

Travelled advance_drum(const Design &design, State &state, double load) {
    const Delay delay = delay_of(design);
    const Sent &first = sent_at(state, state.tick - 2 - delay.whole), &then = sent_at(state, state.tick - 1 - delay.whole);
    const double before = state.drum.payout, dt = design.tick_period;
    advance(design, state.drum, first, delay.part * dt, load);
    advance(design, state.drum, then, (1.0 - delay.part) * dt, load);
    advance(design, state.prompt, sent_at(state, state.tick - 1), dt, load);
    const double move = (delay.part * first.move + (1.0 - delay.part) * then.move) * dt;
    return {state.drum.payout - before, move, then.brake != 0.0};
}

// Payout of the drum when the order of this tick takes effect [m].
double payout_ahead(const Design &design, const State &state, double load) {
    const Delay delay = delay_of(design);
    Drum drum = state.drum;
    advance(design, drum, sent_at(state, state.tick - 1 - delay.whole), delay.part * design.tick_period, load);
    for (int back = delay.whole; back > 0; back--)
        advance(design, drum, sent_at(state, state.tick - back), design.tick_period, load);
    return drum.payout;
}

// Speed that the drum is asked for by set-points [m/s], `ahead` being its payout then.
double speed_of(const Winch &winch, double payout, double rate, double ahead) {
    if (winch.is_first_order) return (payout - ahead) / winch.lag;
    const double held = winch.position_gain > 0.0 ? winch.position_gain * (payout - ahead) : 0.0;
    const double wanted = clip(rate + held, -winch.reach, winch.reach);
    return winch.gain * (wanted < 0.0 ? winch.hauling_gain : 1.0) * wanted + winch.creep;
}

// The set-points that ask for a speed [m/s]: the rate of a speed servo, the payout of a first-order winch.
void set_speed(const Winch &winch, double speed, double ahead, double &payout, double &rate) {
    if (winch.is_first_order) {
        payout = ahead + speed * winch.lag;
        return;
    }
    const double wanted = (speed - winch.creep) / winch.gain;
    rate = wanted < 0.0 ? wanted / winch.hauling_gain : wanted;
    if (!(winch.position_gain > 0.0)) return;
    const double held = winch.position_gain * (payout - ahead);
    if (std::abs(held) > winch.reach) payout = ahead;  // a payout that no rate makes up for
    else rate -= held;
}

namespace {

// Part of a step that is motion: a large one alone is a jump of the count; motion has another one beside it.
double motion_of(double step, double large, double &alone, double &runs) {
    const bool is_large = std::abs(step) > large, goes_on = alone * step > 0.0;
    const bool counts = !is_large || runs != 0.0 || goes_on;
    const double motion = counts ? step + (is_large && goes_on ? alone : 0.0) : 0.0;
    runs = is_large && (runs != 0.0 || goes_on) ? 1.0 : 0.0;
    alone = is_large && runs == 0.0 ? step : 0.0;
    return motion;
}

// Way in one direction, S = max(S e^(-dt/T) + s, 0), and speed in it. A drum that follows late has those of the nominal one
// later, and so within f of their largest of late, as long as it is later by less than T log f. Returns what is beyond: of
// the way since it turned, and of the way at a higher speed, B = max(B + s - f v dt, 0) (Page, 1954).
double follow_stroke(const Bounds &bounds, Stroke &stroke, double step, double sent, double time) {
    const double left = std::exp(-time / bounds.stroke_time), factor = bounds.stroke_factor;
    stroke.counted = std::max(left * stroke.counted + step, 0.0);
    stroke.sent = std::max(left * stroke.sent + sent, 0.0);
    stroke.longest = stroke.counted > 0.0 ? std::max(left * stroke.longest, stroke.sent) : stroke.sent;
    stroke.fastest = std::max(left * stroke.fastest, sent / time);
    stroke.beyond = std::max(stroke.beyond + step - factor * stroke.fastest * time, 0.0);
    return std::max(stroke.counted - factor * stroke.longest, stroke.beyond);
}

}  // namespace

// A drum that goes further than what was sent, or the other way, though it may follow late.
void watch_strokes(const Design &design, State &state, double step, double time) {
    const Bounds &bounds = design.envelope;
    const double sent = state.prompt.payout - state.prompt_counted;
    const double moved = sent + motion_of(step - sent, 0.5 * bounds.stroke_margin, state.off_step, state.off_runs);
    const double out = follow_stroke(bounds, state.outward, moved, sent, time);
    const double in = follow_stroke(bounds, state.inward, -moved, -sent, time);
    state.runaway = out > in ? out : -in;
}

// A drum under its brake: how far its count has gone since it came to rest, or became quicker again without. One large
// step alone is a jump of the count; motion has another one beside it.
void watch_brake(const Design &design, State &state, const Readings &readings, bool is_braked) {
    const Bounds &bounds = design.envelope;
    HeldDrum &held = state.held;
    const double dt = design.tick_period, before = held.count, longest = design.winch.speed / bounds.stop_deceleration;
    if (count_came(bounds, readings)) held.count = readings.count;
    if (!is_braked) {
        held.time = held.rests = held.runs = held.step = held.moved = 0.0;
        return;
    }
    const double step = readings.count - before, speed = std::abs(step) / dt;
    if (!count_came(bounds, readings) || !std::isfinite(step)) return;
    if (held.time == 0.0) held.slowest = speed;
    held.time += dt;
    const bool is_late = held.time > longest, is_faster = speed > held.slowest + 2.0 * bounds.rest_speed;
    if (speed < bounds.rest_speed || is_faster || is_late) held.rests = 1.0;
    held.slowest = std::min(held.slowest, speed);
    if (held.rests == 0.0) return;
    held.moved += motion_of(step, 0.5 * bounds.brake_margin, held.step, held.runs);
}

}  // namespace heave
