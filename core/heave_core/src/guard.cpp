// Never worse than off: whether compensation does harm, as estimates and the depth sensor show live. Over some waves the
// standard deviation of the compensated unit is compared with that of the uncompensated one. An unstable loop pumps
// energy into a unit that then swings for minutes; so over seconds are checked the speed of the drum as far as it is not
// intended, the swing of the unit, z^2 + a z'^2, the heave that the depth sensor reads, and that sensor against the
// estimate.
#include "look.h"

namespace heave {

namespace {

// Squared amplitudes z^2 + a z'^2 of a unit that swings by itself [m^2].
struct Swings {
    double unit, free;
};

double swing_of(double heave, double rate, double inertia) { return square(heave) + inertia * square(rate); }

void add_to(AmplitudeCheck &check, const GuardDesign &design, const AmplitudeLimit &limit, double square, double reference) {
    add(check, square, reference, design.tick_period / limit.time, design.tick_period / design.window);
}

// Time that is left after a tick [s].
double count_down(double &left, double tick_period) { return left = std::max(left - tick_period, 0.0); }

// The unit gains speed with the mean payout once its cable is longer by a times the acceleration, and what it is behind,
// within sqrt(a), once that is longer by sqrt(a) z': on a soft cable metres. The law pays that length D out within the
// memory T of the check, and hauls it in while the unit comes along. The quickest drum speeds up over half of D and slows
// down over the other, with v = sqrt(D u'') between: its mean square over T is (2/3) v D / T. One that takes all of T for
// the mean payout's share makes the square of that over T.
void follow_mean(const GuardDesign &design, GuardState &state, const Seen &seen) {
    const double fading = design.tick_period / std::max(std::sqrt(design.inertia), design.tick_period);
    const double steady = design.inertia * std::abs(seen.mean_acceleration), time = design.drum.time;
    const double length = steady + std::sqrt(design.inertia) * std::abs(seen.unit_rate);
    const double peak = std::min(std::sqrt(length * design.acceleration), design.speed);
    const double asked = std::max(steady / time, std::sqrt(2.0 / 3.0 * peak * length / time));
    state.gain_speed = std::max(asked, (1.0 - fading) * state.gain_speed);
}

// Speed that is missing of a drum that follows an intended one within the winch's limits [m/s].
double missing_speed(const GuardDesign &design, GuardState &state, double intended) {
    const double step = design.acceleration * design.tick_period;
    const double reached = state.reachable + clip(intended - state.reachable, -step, step);
    state.reachable = clip(reached, -design.speed, design.speed);
    return intended - state.reachable;
}

// The drum. While authority A moves, the unit goes over to (1 - A) of its uncompensated motion: by thesis Eq. 6.2 that
// asks for payout = A tip + 2 a A' z_off' (b and A'' left out), with a z_off'' = tip - z_off. A law has to stop a unit
// that swings, and while authority moves to take it out of its uncompensated swing; where that is large, as at a
// resonance, the drum does no harm before it is as fast.
void check_drum(const GuardDesign &design, GuardState &state, const Seen &seen, double change, const Swings &swings) {
    const double dt = design.tick_period, largest = dt / design.fade_time;
    const double authority_rate = clip(change, -largest, largest) / dt;
    const double intended = seen.authority * seen.tip_rate + authority_rate * (3.0 * seen.tip - 2.0 * seen.free);
    const double error = seen.payout_rate - intended;
    const double allowed =
        (1.0 + design.rate_error) * std::max(seen.authority, design.least_authority) * seen.tip_rate;
    const double faded = state.exchanged_swing * (1.0 - dt / design.swing.time);
    state.exchanged_swing = change == 0.0 ? faded : swings.free;
    const double to_stop = square(design.swing_work) * (swings.unit + state.exchanged_swing) + swings.free;
    const double work = design.inertia > 0.0 ? to_stop / design.inertia : 0.0;
    follow_mean(design, state, seen);
    const double missing = missing_speed(design, state, intended);
    state.is_out_of_reach = std::abs(missing) > design.beyond * design.speed;
    const double reference =
        square(allowed) + work + square(state.gain_speed) + square(design.out_of_reach * missing);
    add_to(state.drum, design, design.drum, square(error), reference);
    if (count_down(state.catch_up, dt) > 0.0 || seen.authority <= 0.0) state.drum.square = 0.0;
}

// The swing that compensation has found is not held against it. While the winch stands, the unit less the uncompensated
// one is a free swing, and would go on for long: whoever stops the winch suddenly sets it going. So does a wrong
// parameter that has been corrected, and a wave beyond the winch's limits: of a compensated unit all motion is that.
void follow_left_over(const GuardDesign &design, GuardState &state, const Seen &seen) {
    const bool stands = seen.authority <= 0.0;
    const double heave = seen.unit - (stands ? seen.free : 0.0), rate = seen.unit_rate - (stands ? seen.free_rate : 0.0);
    const double most = design.largest_left_over * std::sqrt(reference_of(state.swing));
    const double found = std::min(std::sqrt(swing_of(heave, rate, design.inertia)), most);
    if (stands || state.is_corrected != 0.0) {
        state.left_over_swing = found;
    } else {
        state.left_over_swing *= 1.0 - design.tick_period / design.left_over_time;
        // once: what keeps growing is no swing that a wave has left
        const bool is_used_up = state.left_over_swing < design.restart * found;
        if (state.is_out_of_reach != 0.0 && is_used_up) state.left_over_swing = found;
    }
    state.is_corrected = 0.0;
    state.swing.left_over = state.left_over_swing;
    state.depth.left_over = std::sqrt(0.5) * state.left_over_swing;
}

// The unit, as estimated and as the depth sensor reads it; the mean square of a heave is half that of its swing.
void check_unit(const GuardDesign &design, GuardState &state, const Seen &seen, const Swings &swings) {
    add_to(state.swing, design, design.swing, swings.unit, swings.free);
    follow_left_over(design, state, seen);
    const double free_heave = 0.5 * swings.free;
    state.depth.noise = state.mismatch.noise = seen.noise;
    add(state.measured, design, seen.measured, seen.noise);
    add_to(state.depth, design, design.depth, square(state.measured.value), free_heave);
    add_to(state.locked, design, design.depth, 0.0, square(seen.free));
    add(state.error, design, seen.measured - seen.unit, seen.noise);
    add_to(state.mismatch, design, design.mismatch, square(state.error.value), free_heave);
    if (seen.authority > 0.0) return;
    state.swing.square = reference_of(state.swing);
    state.depth.square = 0.0;
}

int found(const GuardDesign &design, const GuardState &state) {
    const double seen = design.seen_ticks;
    int bits = 0;
    if (is_exceeded(state.mismatch, design.mismatch, seen)) bits |= DISAGREE;
    if (is_exceeded(state.depth, design.depth, seen)) bits |= DEPTH_HIGH;
    if (design.feeds_back == 0.0) return bits;
    if (is_exceeded(state.swing, design.swing, seen)) bits |= SWING_HIGH;
    if (is_exceeded(state.drum, design.drum, seen)) bits |= DRUM_OFF;
    return bits;
}

// Standard deviations over waves: under an authority A no more can be asked than that share of what the whole has to
// gain, so that harm is sigma > (1 - A (1 - ratio)) sigma_free.
int compare_waves(const GuardDesign &design, GuardState &state, const Seen &seen, Verdict &verdict) {
    const double weight = design.tick_period / design.window;
    add(state.unit, seen.unit, weight, design.slow_mean);
    add(state.free_unit, seen.free, weight, design.slow_mean);
    state.waves_time += design.tick_period;
    verdict.unit_sigma = std::sqrt(state.unit.variance);
    verdict.free_sigma = std::sqrt(state.free_unit.variance);
    verdict.least_gain = seen.authority * (1.0 - design.harm_ratio);
    if (state.waves_time < design.seen_time) return 0;
    verdict.measured = measured_residual(seen, verdict);
    return verdict.unit_sigma > design.floor && verdict.unit_sigma > (1.0 - verdict.least_gain) * verdict.free_sigma ? LITTLE_GAIN : 0;
}

}  // namespace

void begin_guard(GuardState &state) {
    const double authority = state.authority;
    state = GuardState{};
    state.authority = authority;
    state.measured.last = state.error.last = state.demand.last_rate = NOT_KNOWN;
    state.shown_left = ANY;
}

void restart_waves(GuardState &state) {
    state.unit = state.free_unit = RunningSigma{};
    state.waves_time = 0.0;
}

// The law has to catch up with what it could not see.
void allow_catch_up(const GuardDesign &design, GuardState &state) { state.catch_up = design.catch_up_time; }

// How drum and unit moved while a sensor was lost is not held against the loop.
void allow_resumption(const GuardDesign &design, GuardState &state) {
    allow_catch_up(design, state);
    state.is_corrected = 1.0;
    state.drum_share = 0.0;
    state.allowance = design.left_over_time;
    restart_waves(state);
}

// What was seen until now says nothing of depth sensor and estimate: one of them has been corrected.
void reset_mismatch(GuardState &state) {
    state.mismatch.square = 0.0;
    state.error = DetrendedHeave{};
    state.error.last = NOT_KNOWN;
}

void guard(const GuardDesign &design, GuardState &state, const Seen &seen, Verdict &verdict) {
    observe_sea(design, state.demand, seen.tip_rate);
    judge_demand(design, state.demand, verdict);
    add(state.tip, seen.tip, design.tick_period / design.window, design.slow_mean);
    verdict.tip_sigma = std::sqrt(state.tip.variance);
    const bool is_allowed = count_down(state.allowance, design.tick_period) > 0.0;
    const double change = seen.authority - state.authority;
    state.authority = seen.authority;
    const Swings swings{swing_of(seen.unit, seen.unit_rate, design.inertia),
                        swing_of(seen.free, seen.free_rate, design.inertia)};
    check_drum(design, state, seen, change, swings);
    check_unit(design, state, seen, swings);
    note_drum(design, state, seen);
    note_left(design, state, seen);
    predict_residual(design, state, seen, verdict);
    show_authority(design, seen, verdict);
    verdict.measured = -1.0;
    int bits = found(design, state);
    const bool inhibits = seen.inhibits != 0.0 || (bits & DISAGREE), is_full = seen.authority >= design.full_share * seen.target;
    if (!inhibits && seen.authority <= 0.0) restart_waves(state);
    else if (!inhibits && !(bits & ~DISAGREE) && !is_allowed && is_full) bits |= compare_waves(design, state, seen, verdict);
    verdict.bits = bits;
    verdict.drum = amplitude_of(state.drum);
    verdict.swing = amplitude_of(state.swing);
    verdict.depth = amplitude_of(state.depth);
    verdict.mismatch = amplitude_of(state.mismatch);
    verdict.waves_time = state.waves_time;
}

}  // namespace heave
