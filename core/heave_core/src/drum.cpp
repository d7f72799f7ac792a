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
    const double before = state.drum.payout, prompt = state.prompt.payout, dt = design.tick_period;
    advance(design, state.drum, first, delay.part * dt, load);
    advance(design, state.drum, then, (1.0 - delay.part) * dt, load);
    advance(design, state.prompt, sent_at(state, state.tick - 1), dt, load);
    state.stroke.sent += state.prompt.payout - prompt;
    state.stroke.off -= state.prompt.payout - prompt;
    state.stroke.nominal += state.drum.payout - before;
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

// The set-point that asks for a speed: a rate of a speed servo [m/s], a payout beyond the drum's of a first-order winch [m].
double set_point_of(const Winch &winch, double speed) {
    if (winch.is_first_order) return speed * winch.lag;
    const double wanted = (speed - winch.creep) / winch.gain;
    return wanted < 0.0 ? wanted / winch.hauling_gain : wanted;
}

// The set-points that ask for a speed [m/s], `ahead` being the drum's payout then.
void set_speed(const Winch &winch, double speed, double ahead, double &payout, double &rate) {
    const double set_point = set_point_of(winch, speed);
    if (winch.is_first_order) {
        payout = ahead + set_point;
        return;
    }
    rate = set_point;
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

// Samples of the drum's way: one every so many ticks, those by which a drum may be late, those of a span.
struct Samples {
    int every, late, soon, span;
    double time;  // of one [s]
};

Samples samples_of(const Design &design) {
    const double late = design.winch.delay + design.envelope.stroke_late, span = design.envelope.stroke_span;
    const int every = std::max(int(std::ceil((late + 2.0 * span) / (design.tick_period * (STROKES - 3)))), 1);
    const double time = every * design.tick_period;
    const auto samples = [&](double lateness) { return int(std::ceil((design.winch.delay + lateness) / time - 1e-6)); };
    const int soon = samples(std::min(design.envelope.stroke_soon, design.envelope.stroke_late));
    return {every, samples(design.envelope.stroke_late), soon, std::max(int(std::round(span / time)), 1), time};
}

// Age of a sample of the drum's way, of those before this tick [s].
double age_of_sample(const Design &design, const State &state, int every, int back) {
    return ((state.tick - 1) % every + 1 + back * every) * design.tick_period;
}

}  // namespace

// What the drum did until now says nothing.
void forget_strokes(State &state) {
    for (Stroke &stroke : state.strokes) stroke.off = state.stroke.off;
    state.unjudged = 0.0;
}

// Way of the nominal drum within an `age` until now [m]; between its samples in proportion.
double way_since(const Design &design, const State &state, double age) {
    if (!(age > 0.0)) return 0.0;
    const int every = samples_of(design).every;
    double newer = 0.0, after = state.stroke.nominal;
    for (int back = 0; back < STROKES; back++) {
        const double older = age_of_sample(design, state, every, back);
        const double before = state.strokes[(state.sample + STROKES - back) % STROKES].nominal;
        if (older >= age) return state.stroke.nominal - after + (after - before) * (age - newer) / (older - newer);
        newer = older;
        after = before;
    }
    return state.stroke.nominal - after;
}

// The drum's `way` by count in the `time` from its last reading to this one, in which the nominal drum was `sent`: samples
// between take their parts of what is beyond that. After a count that was lost they are not known.
void take_way(const Design &design, State &state, double way, double sent, double time) {
    state.stroke.off += way;
    if (time > design.envelope.count_time) return forget_strokes(state);
    const int every = samples_of(design).every;
    const Stroke &now = state.stroke;
    const double late = state.time_since_count, later = state.since_count;
    for (int back = 0; back < STROKES; back++) {
        const double age = age_of_sample(design, state, every, back) - late;
        if (age < 0.0) continue;
        if (!(age < time - 0.5 * design.tick_period)) return;
        Stroke &between = state.strokes[(state.sample + STROKES - back) % STROKES];
        const double since = now.nominal - later - between.nominal + (way - sent) * age / time;
        between.off = now.sent + now.off - since - between.sent;
    }
}

// The count's way by its `step` in a `time`, in which the nominal drum was `sent`: what of it was sent is no jump.
void count_way(const Design &design, State &state, double step, double sent, double time) {
    const double size = std::abs(step);
    if (size > 0.0) state.resolution = state.resolution > 0.0 ? std::min(state.resolution, size) : size;
    const double follows = clip(step, std::min(sent, 0.0), std::max(sent, 0.0));
    const double large = stroke_limit(design.envelope, state);
    take_way(design, state, follows + motion_of(step - follows, large, state.off_step, state.off_runs), sent, time);
}

// Step of the count, as far as it is one: what it leaves unknown of a way [m].
double step_of_count(const Bounds &bounds, const State &state) { return std::min(state.resolution, bounds.count_step); }

// Way beyond which a drum runs [m]: what the steps of the count leave unknown of two ways is theirs.
double stroke_limit(const Bounds &bounds, const State &state) {
    return bounds.stroke_margin + 2.0 * step_of_count(bounds, state);
}

namespace {

// A drum that goes further than what was sent, or the other way. Whatever its lag and delay, its speed is a mean of those
// that were sent, w = K int h(s) v(t - s) ds with h >= 0, and so lies between f times the least and the largest sent of
// late; the same holds for the way of a span less that of the span before, its acceleration. What is beyond is summed,
// B = max(B e^(-dt/T) + w dt - f v dt, 0) (Page, 1954). A drum that comes to rest sooner does no harm. Returns the way beyond
// what was sent within `latest` samples, positive out.
double way_beyond(const Design &design, const State &state, const Samples &samples, int newest, int latest, Beyond &beyond) {
    const auto at = [&](int back) { return state.strokes[(state.sample + 2 * STROKES - newest - back) % STROKES]; };
    const auto sent = [&](int back) { return at(back).sent; };
    const auto nominal = [&](int back) { return at(back).nominal; };
    const auto counted = [&](int back) { return at(back).sent + at(back).off; };
    const auto change = [&](const auto &way, int back) {
        return way(back) - 2.0 * way(back + samples.span) + way(back + 2 * samples.span);
    };
    const double as_stated = nominal(0) - nominal(1), bend = change(nominal, 0);
    double out = std::max(as_stated, 0.0), in = std::min(as_stated, 0.0);  // largest of late
    double outward = std::max(bend, 0.0), inward = std::min(bend, 0.0);
    for (int late = 0; late <= latest; late++) {
        const double step = sent(late) - sent(late + 1), more = change(sent, late);
        out = std::max(out, step);
        in = std::min(in, step);
        outward = std::max(outward, more);
        inward = std::min(inward, more);
    }
    const double left = std::exp(-samples.time / design.envelope.drum_time), factor = design.envelope.stroke_factor;
    const double step = counted(0) - counted(1), more = change(counted, 0);
    // a punctual drive that becomes weak goes on to gain speed, and to lose it: not both, beyond the speed that was sent
    const bool may_be_late = latest == samples.late, counts_out = may_be_late || more > 0.0, counts_in = may_be_late || more < 0.0;
    const double beyond_out = step - factor * out, beyond_in = factor * in - step;
    beyond.out = std::max(left * beyond.out + (counts_out ? beyond_out : std::min(beyond_out, 0.0)), 0.0);
    beyond.in = std::max(left * beyond.in + (counts_in ? beyond_in : std::min(beyond_in, 0.0)), 0.0);
    // one that stands gains nothing: the sums of its count do, by their last digits
    const double gains = may_be_late ? design.envelope.stroke_gain : 0.0, rests = design.envelope.rest_speed * samples.time;
    const double runs_out = std::max(beyond.out, step > rests ? gains * (more - factor * outward) : 0.0);
    const double runs_in = std::max(beyond.in, step < -rests ? gains * (factor * inward - more) : 0.0);
    // a drive at its limit trails behind its orders and catches up: what runs is ahead of the nominal drum as well
    const int all = samples.late + 2 * samples.span;
    const double ahead = counted(0) - counted(all) - (nominal(0) - nominal(all));
    const double way_out = runs_out - state.limited * std::max(runs_out - std::max(ahead, 0.0), 0.0);
    const double way_in = runs_in - state.limited * std::max(runs_in - std::max(-ahead, 0.0), 0.0);
    return way_out > way_in ? way_out : -way_in;
}

// A drive may be late, and then a drum that runs while its orders fall cannot be told from it. One that has turned for a
// window and was not late by more than a little is not late all at once.
void judge_sample(const Design &design, State &state, const Samples &samples, int newest) {
    const double if_late = way_beyond(design, state, samples, newest, samples.late, state.beyond);
    const double if_soon = way_beyond(design, state, samples, newest, samples.soon, state.beyond_soon);
    const double limit = stroke_limit(design.envelope, state);
    const bool is_punctual = state.punctual_time >= design.envelope.window;
    if (!is_punctual && std::abs(if_soon) > 0.5 * limit) state.punctual_time = 0.0;
    else if (std::abs(state.drum.rate) > design.envelope.rest_speed) state.punctual_time += samples.time;
    state.runaway = is_punctual && std::abs(if_soon) > std::abs(if_late) ? if_soon : if_late;
}

}  // namespace

// Samples since the last reading of the count wait for the next one: what the drum did in them is known by that.
void watch_strokes(const Design &design, State &state) {
    const Samples samples = samples_of(design);
    state.resolution *= 1.0 + design.tick_period / design.envelope.window;
    if (state.tick % samples.every != 0) return;
    state.sample = (state.sample + 1) % STROKES;
    state.strokes[state.sample] = state.stroke;
    state.unjudged = std::min(state.unjudged + 1.0, STROKES - 1.0 - samples.late - 2.0 * samples.span);
    const double waiting = std::ceil(state.time_since_count / samples.time - 1e-6);
    for (; state.unjudged > waiting; state.unjudged -= 1.0) judge_sample(design, state, samples, int(state.unjudged) - 1);
}

// A drum at rest: what it did before says nothing.
void rest_drum(State &state) {
    state.residual = state.runaway = 0.0;
    state.beyond = state.beyond_soon = Beyond{};
    forget_strokes(state);
}

// A drum under its brake: how far its count has gone since it came to rest, or became quicker again without. One large
// step alone is a jump of the count; motion has another one beside it, or is of steps of the count.
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
    // what was sent before acts for the delay of the winch, and is read a tick or two later
    if (held.time <= design.winch.delay + 2.0 * dt) held.slowest = speed;
    held.time += dt;
    const bool is_late = held.time > longest, is_faster = speed > held.slowest + 2.0 * bounds.rest_speed;
    if (speed < bounds.rest_speed || is_faster || is_late) held.rests = 1.0;
    held.slowest = std::min(held.slowest, speed);
    if (held.rests == 0.0) return;
    const double large = std::max(0.5 * bounds.brake_margin, 1.5 * step_of_count(bounds, state));
    held.moved += motion_of(step, large, held.step, held.runs);
}

}  // namespace heave
