// Whether a unit that is lowered has landed, and whether one that is lifted off hangs again. A landed unit stands still
// and its cable of stiffness k loses k v of tension each second at a speed v of lowering, until it is slack: depth sensor,
// load cell and mean payout tell, each by its trend over a window in which the winch lowers by some centimetres. What
// else does both at once is ruled out: a hanging unit that stays behind while lowering gains speed, and one at the lowest
// point of a swing, whose tension falls from above the weight. A unit that hangs would sink; the depth sensor must read a
// landed one above the estimate as well. One of the two alone shows it on average over a swing.
#include "watch.h"

namespace heave {

namespace {

double weight_share(const LandingDesign &design, double tension) {
    return (tension - design.static_tension) / design.weight + 1.0;
}

Slope slope_of(const LandingDesign &design, const Trend &trend, double window) {
    return slope_of(trend, window, design.least_readings, design.filled);
}

// Whether the winch has lowered steadily over a window, at which speed, and how fast a hanging unit would have sunk [m/s].
struct Lowering {
    bool is_steady;
    double payout, sinking;
};

Lowering lowering_of(const LandingDesign &design, const LandingState &state, double window, double rate) {
    const Slope payout = slope_of(design, state.payout, window), hanging = slope_of(design, state.hanging, window);
    const Slope before = slope_of(design, state.payout, window + design.following_time);
    const double steady = std::max(design.least_rate, design.steady_share * rate);
    const bool is_known = payout.is_known && before.is_known && hanging.is_known;
    return {is_known && std::min(payout.value, before.value) >= steady, payout.value, std::min(payout.value, hanging.value)};
}

// The depth sensor has read a unit that stands while a hanging one would have sunk.
bool has_stayed(const LandingDesign &design, const LandingState &state, double window, const Lowering &lowering) {
    const Slope depth = slope_of(design, state.depth, window);
    if (!depth.is_known || !lowering.is_steady) return false;
    if (std::abs(depth.value) > design.standing_share * lowering.sinking) return false;
    return lowering.sinking - depth.value >= design.certain * depth.error;
}

// The unit has stood for a window in which the winch lowered and the cable was relieved.
bool shows_landing(const LandingDesign &design, const LandingState &state, double window, double rate, double share) {
    const Lowering lowering = lowering_of(design, state, window, rate);
    if (!has_stayed(design, state, window, lowering)) return false;
    if (mean_of(state.innovation, window) < design.innovation_above) return false;
    const Slope tension = slope_of(design, state.tension, window);
    const double relief = design.relief_share * design.stiffness * lowering.payout;
    const bool is_relieved = tension.is_known && -tension.value > std::max(relief, design.certain * tension.error);
    const double relieved_share = 1.0 - relief * window / design.weight;
    return (is_relieved && share < relieved_share) || share < design.touchdown_ratio;
}

// The cable has lost the weight on average over a whole swing. Within one, and while lowering gains speed, that of a
// hanging unit may lose all of it.
bool is_relieved_throughout(const LandingDesign &design, const LandingState &state, double rate) {
    const double time = design.swing_time, steady = std::max(design.least_rate, design.steady_share * rate);
    const Slope payout = slope_of(design, state.payout, time), tension = slope_of(design, state.tension, time);
    if (!payout.is_known || !tension.is_known || payout.value < steady) return false;
    const double share = weight_share(design, mean_of(state.tension, time));
    return share < design.touchdown_ratio * mean_of(state.hanging_share, time);
}

// Without the load cell: a unit that stood has risen with the winch over a whole swing.
bool rises_throughout(const LandingDesign &design, const LandingState &state) {
    const double time = design.swing_time;
    const Slope payout = slope_of(design, state.payout, time), depth = slope_of(design, state.depth, time);
    if (!payout.is_known || !depth.is_known || payout.value > -design.least_rate) return false;
    return depth.value < (1.0 - design.standing_share) * payout.value;
}

// Within half a window the unit may have landed: its readings are then no check on the estimate of a hanging one. Without the
// load cell it must show for longer, and stays open for the swing that decides it: readings that are left out no longer differ
// from the estimate.
void watch_unconfirmed(const LandingDesign &design, LandingState &state, double time, double window, double rate) {
    const bool is_weighed = state.is_weighed != 0.0;
    const double looked = (is_weighed ? 0.5 : design.windows[1]) * window;
    const Slope depth = slope_of(design, state.depth, looked), tension = slope_of(design, state.tension, looked);
    const bool stands = depth.is_known && std::abs(depth.value) < design.standing_share * rate;
    const bool is_relieved = !tension.is_known || tension.value < 0.0;
    const bool differs = mean_of(state.innovation, looked) > design.innovation_above;
    const bool may_stand = (!is_weighed && state.may_stand != 0.0) || (stands && is_relieved && differs);
    const double longest = std::max(design.unconfirmed_time * window, is_weighed ? 0.0 : design.swing_time + looked);
    const double since = time - state.may_stand_since;
    if (may_stand && since > design.pause * longest) state.may_stand_since = time;
    state.may_stand = may_stand && time - state.may_stand_since < longest;
}

bool touches_down(const LandingDesign &design, LandingState &state, const LandingSeen &seen, double share) {
    const double rate = seen.compensates != 0.0 ? state.lowering_rate : 0.0;
    if (rate < design.least_rate) {
        state.may_stand = 0.0;
        return false;
    }
    if (seen.sees_landing == 0.0) return is_relieved_throughout(design, state, rate);
    if (seen.has_depths == 0.0) return false;
    const double window = std::min(std::max(design.lowered / rate, design.shortest), design.longest);
    watch_unconfirmed(design, state, seen.time, window, rate);
    // without the load cell: within less than a whole swing a hanging unit may stay behind the winch
    if (state.is_weighed == 0.0)
        return has_stayed(design, state, design.swing_time, lowering_of(design, state, design.swing_time, rate));
    for (const double factor : design.windows)
        if (shows_landing(design, state, factor * window, rate, share)) return true;
    return false;
}

bool hangs_again(const LandingDesign &design, const LandingState &state, const LandingSeen &seen, double share) {
    if (state.is_weighed != 0.0) return state.is_lifting != 0.0 && share > 1.0;
    return state.unit_stands != 0.0 && seen.sees_landing != 0.0 && rises_throughout(design, state);
}

}  // namespace

void begin_landing(LandingState &state) {
    state = LandingState{};
    state.share = 1.0;
    state.may_stand_since = -std::numeric_limits<double>::infinity();
    for (Trend *trend : {&state.depth, &state.hanging, &state.tension, &state.payout, &state.innovation, &state.hanging_share})
        trend->changed = -std::numeric_limits<double>::infinity();
}

void observe_landing(const LandingDesign &design, LandingState &state, const LandingSeen &seen) {
    // what a lost load cell read last, again and again, is no tension
    state.is_weighed = seen.is_weighed;
    if (seen.is_weighed == 0.0) state.tension.count = state.tension.next = 0;
    else if (std::isfinite(seen.tension)) add(state.tension, seen.time, seen.tension);
    add(state.payout, seen.time, seen.mean_payout);
    add(state.hanging, seen.time, seen.hanging_depth);
    const double tension = design.static_tension + design.stiffness * seen.hanging_stretch;
    add(state.hanging_share, seen.time, std::min(1.0, weight_share(design, tension)));
    if (std::isfinite(seen.innovation)) add(state.innovation, seen.time, seen.innovation);
    const bool stands = has_stood(state.payout, design.shortest);
    state.lowering_rate = stands ? 0.0 : slope_of(design, state.payout, design.shortest).value;  // 0 where not known
}

void judge_landing(const LandingDesign &design, LandingState &state, const LandingSeen &seen) {
    const double share = weight_share(design, seen.filtered_tension);
    state.event = NOT;
    if (state.unit_stands == 0.0 && touches_down(design, state, seen, share)) {
        state.unit_stands = 1.0;
        state.may_stand = state.is_lifting = 0.0;
        state.event = TOUCHDOWN;
    } else if (hangs_again(design, state, seen, share)) {
        state.unit_stands = state.is_lifting = 0.0;
        state.event = LIFTED_OFF;
    }
}

}  // namespace heave
