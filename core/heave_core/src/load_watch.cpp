// A slack cable, too much tension, a rope beyond what it can bear, a winch that is at its limits too long; each is reported
// once for as long as it comes and goes.
#include "watch.h"

namespace heave {

namespace {

// Whether an episode of a cause begins with this tick; returns its bit.
int begins(const LoadWatchDesign &design, LoadWatchState &state, int bit, bool is_there) {
    int place = 0;
    while ((1 << place) < bit) place++;
    return heave::begins(state.quiet[place], design.quiet_time, design.tick_period, is_there) ? bit : 0;
}

}  // namespace

// Whether an episode of something that comes and goes begins with this tick: it was away for the quiet time.
bool begins(double &away, double quiet_time, double tick_period, bool is_there) {
    const bool was_quiet = away >= quiet_time;
    away = is_there ? 0.0 : away + tick_period;
    return is_there && was_quiet;
}

void begin_load_watch(const LoadWatchDesign &design, LoadWatchState &state) {
    state.at_limit = 0.0;
    for (double &quiet : state.quiet) quiet = design.quiet_time;
}

int watch_load(const LoadWatchDesign &design, LoadWatchState &state, double tension, double static_tension, bool is_at_limit) {
    state.at_limit += design.tick_period / design.saturation_time * (is_at_limit - state.at_limit);
    const double share = std::isfinite(tension) && static_tension > 0.0 ? tension / static_tension : 1.0;
    int found = begins(design, state, SLACK, share < design.slack_ratio);
    found |= begins(design, state, TENSION_HIGH, 0.0 < design.tension_ratio && design.tension_ratio < share);
    found |= begins(design, state, SATURATED, state.at_limit > design.saturation_share);
    if (std::isnan(design.capacity)) return found;
    const double unloaded = std::isnan(tension) ? NOT_KNOWN : std::numeric_limits<double>::infinity();
    const double factor = tension > 0.0 ? design.capacity / tension : unloaded;
    found |= begins(design, state, ROPE_SHORT, design.least <= factor && factor < design.required);
    return found | begins(design, state, ROPE_OVERLOADED, factor < design.least);
}

// Constant tension has used half of the travel that it may, or all of it.
int watch_travel(const LoadWatchDesign &design, LoadWatchState &state, bool is_half, bool is_at_end) {
    return begins(design, state, TRAVEL_HALF, is_half) | begins(design, state, TRAVEL_END, is_at_end);
}

}  // namespace heave
