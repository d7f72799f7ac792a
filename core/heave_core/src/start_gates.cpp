// What must hold before compensation, or constant tension, begins: each closed gate is a bit, of which Python makes words.
#include "supervise.h"

namespace heave {

namespace {

// The range of payout does not hold the waves.
bool is_range_short(const Supervising &on) {
    const double payout = on.seen->mean_payout, amplitude = on.design->peak * on.verdict->tip_sigma;
    return std::min(payout - on.design->payout_minimum, on.design->payout_maximum - payout) < amplitude;
}

}  // namespace

int compensation_gates(const Supervising &on) {
    const SupervisionDesign &design = *on.design;
    const Tick &tick = *on.tick;
    int closed = 0;
    if (on.landing_state->is_unloaded != 0.0) closed |= LOAD_STANDS;
    if (on.state->wait > 0.0) closed |= LOAD_UNWEIGHED;
    if (tick.knows_sea == 0.0 && tick.number * design.tick_period < design.longest_wait) closed |= SEA_UNSEEN;
    if (tick.disagree_time != 0.0) closed |= READINGS_DISAGREE;
    if (on.state->is_low) closed |= TENSION_LOW;
    if (is_range_short(on)) closed |= RANGE_SHORT;
    if (on.verdict->residual > largest_residual(*on.attempt_design, *on.attempts)) closed |= RESIDUAL_HIGH;
    return on.seen->is_proved != 0.0 ? closed : closed | MRU_UNPROVED;
}

// A winch that holds a tension already may go on; else it must follow the whole boom tip, and not drop a unit that hangs.
int tension_gates(const Supervising &on, bool is_cell_lost) {
    const SupervisionDesign &design = *on.design;
    if (is_cell_lost) return LOAD_CELL_LOST;
    if (on.mode->mode == IN_CONSTANT_TENSION) return 0;
    const bool must_stand = design.hanging == 0.0 && hangs(*on.landing_state);
    if (const int closed = must_stand ? load_gates(on) : 0) return closed;
    const bool is_high = design.peak_ratio * on.verdict->demand > design.peak_use;
    return (is_range_short(on) ? RANGE_SHORT : 0) | (is_high ? PEAKS_HIGH : 0);
}

void begin_highest_tension(SupervisionState &state) {
    state.stretch = RunningSigma{};
    state.enough = INFINITE;
    state.is_kept = 1;
    state.is_low = 0;
}

// What the winch follows hardly changes the tension. What is beyond its limits it does not: of that share of a peak the
// tension is that of a locked winch. With a highest tension below it the winch would give way in every group of waves, while
// it has nothing left to bring the unit back with.
void watch_highest_tension(const Supervising &on, int &happened) {
    const SupervisionDesign &design = *on.design;
    SupervisionState &state = *on.state;
    if (std::isinf(design.highest_ratio)) return;
    const bool was_kept = state.is_kept;
    add(state.stretch, on.tick->motions.tip - on.tick->motions.free, design.stretch_weight, design.slow_mean);
    const double use = design.peak_ratio * on.verdict->demand;
    const double share = use > 0.0 ? std::max(design.tension_left, 1.0 - 1.0 / use) : design.tension_left;
    state.least_ratio = 1.0 + share * design.tension_peak * std::sqrt(state.stretch.variance) * design.tension_per_metre;
    state.is_low = state.least_ratio > design.highest_ratio;
    // under the brake compensation restarts
    const double enough = is_braked(*on.mode) ? INFINITE : state.enough + design.tick_period;
    state.enough = state.is_low ? 0.0 : enough;
    state.is_kept = state.enough > design.tension_hold;
    if (was_kept && !state.is_kept && on.mode->mode == IN_COMPENSATING) happened |= TENSION_NOT_KEPT;
}

}  // namespace heave
