// The load while the winch stands: whether the cable carries it, and whether payout and depth sensor agree on it. A landing
// that was seen is known better: the brake may since have let the sea pull at the unit.
#include "supervise.h"

namespace heave {

namespace {

// Share of the weight that the cable carries on average, and its error. The mean acceleration of a unit that goes nowhere
// is 0, so that the mean tension is the weight that the cable carries.
struct Carried {
    double share, error;
};

Carried carried(const Supervising &on) {
    const SupervisionDesign &design = *on.design;
    const Tick &tick = *on.tick;
    const double averaged = clip(tick.tension_time / design.tension_memory, design.least_averaged, 1.0);
    const double error = design.mean_error * tick.tension_sigma / (averaged * on.landing->weight);
    const double tension = tick.tension_mean - design.cable_weight * (on.seen->mean_payout + design.more);
    return {(tension - on.landing->static_tension) / on.landing->weight + 1.0, error};
}

// Takes in what the cable carries; what is known stays until the tension shows another thing. Returns for how long the
// tension must be averaged still [s]; 0 where it has not been too low so far either.
double weigh(const Supervising &on) {
    const Carried found = carried(on);
    const double ratio = on.landing->touchdown_ratio, wait = on.landing->swing_time - on.tick->tension_time;
    const bool is_low = found.share < ratio;
    if (wait > 0.0) return is_low ? wait : 0.0;
    if (std::abs(found.share - ratio) > found.error) {
        on.landing_state->is_unloaded = is_low;
        on.landing_state->share = found.share;
    }
    return 0.0;
}

// Under the brake the unit heaves about its depth at rest: L + u and its stretch below the boom tip. The stretch may be as
// assumed or none: a passive compensator is soft, and its preload takes the weight.
bool is_off(const SupervisionDesign &design, double depth, double out) {
    const double below = depth - (out - design.tip_height), limit = design.least_off + design.payout_tolerance * out;
    return design.payout_tolerance != 0.0 && !(-limit <= below && below <= design.stretch * out + limit);
}

void watch_payout(const Supervising &on, const double *depths, bool is_known) {
    SupervisionState &state = *on.state;
    const double payout = on.seen->mean_payout;
    if (!is_known || payout != state.watched) {
        state.watched = payout;
        state.watched_time = state.depths = state.depth_count = 0.0;
        return;
    }
    state.watched_time += on.design->tick_period;
    const int count = int(on.tick->depth_count);
    for (int i = 0; i < count; i++) state.depths += depths[2 * i + 1];
    state.depth_count += count;
    if (state.watched_time < on.landing->swing_time || state.depth_count == 0.0) return;
    state.mean_depth = state.depths / state.depth_count;
    state.is_off = is_off(*on.design, state.mean_depth, on.design->length + payout);
}

}  // namespace

bool hangs(const LandingState &state) { return state.unit_stands == 0.0 && state.is_unloaded == 0.0; }

// What rides on the unit says something of a hanging one.
bool shows_hanging(const LandingState &state) {
    return hangs(state) && !(state.may_stand != 0.0 && state.is_weighed == 0.0);
}

void begin_standing_load(SupervisionState &state) { state.watched = NOT_KNOWN; }

void watch_standing_load(const Supervising &on, const double *depths, bool is_cell_lost, bool is_encoder_lost, int &happened) {
    const SupervisionDesign &design = *on.design;
    SupervisionState &state = *on.state;
    LandingState &landing = *on.landing_state;
    const bool brake = is_braked(*on.mode);
    state.unweighed = is_cell_lost ? state.unweighed + design.tick_period : 0.0;
    if (state.unweighed > design.tension_memory) landing.is_unloaded = 0.0;  // what the load cell has said is old
    const bool is_weighed = brake && landing.unit_stands == 0.0 && !is_cell_lost;
    state.wait = is_weighed ? weigh(on) : 0.0;
    const bool is_unloaded = landing.is_unloaded != 0.0 && on.mode->wants;
    if (begins(state.quiet[0], design.quiet_time, design.tick_period, is_unloaded)) happened |= LOAD_NOT_HANGING;
    watch_payout(on, depths, brake && hangs(landing) && !is_encoder_lost && on.tick->sees_landing != 0.0);
    if (begins(state.quiet[1], design.quiet_time, design.tick_period, state.is_off)) happened |= DEPTH_NOT_PAYOUT;
}

// Whether the cable may carry a unit whose landing was missed; bits of Gate.
int load_gates(const Supervising &on) {
    const Carried found = carried(on);
    const bool is_carried = on.design->hangs_least - found.error < found.share && found.share < on.design->hangs_most + found.error;
    if (is_carried) return LOAD_HANGS;
    return on.design->tension_memory - on.tick->tension_time > 0.0 ? TENSION_UNSEEN : 0;
}

}  // namespace heave
