// The nominal unit under a locked drum, moved by the raw motion reference unit. No estimate, identified value or gain is in it.
// Heave is blended with the integral of its rate: on a short cable the noise of the heave alone would shake the unit.
#include "watch.h"

namespace heave {

namespace {

// Blends heave and rate of a reading with what its rate has made of the ones before.
void blend_reading(const NominalLoadDesign &design, NominalLoadState &state, double time, double heave, double rate) {
    const double before = state.base_heave, since = time - state.base_time;
    const bool has_rate = std::isfinite(rate);
    if (!has_rate) rate = 0.0;
    if (!(0.0 <= since && since < design.unread)) {
        state.read_time = 0.0;
        if (std::isnan(before)) continue_at(design.cable, state.hanging, {heave, 0.0});
    } else if (has_rate) {
        const double integral = before + 0.5 * since * (rate + state.rate);
        heave = integral + std::min(since / design.blend, 1.0) * (heave - integral);
    } else if (since > 0.0) {
        rate = (heave - before) / since;
    }
    state.time = state.base_time = time;
    state.heave = state.base_heave = heave;
    state.rate = rate;
}

// The unit goes on below the boom tip; a motion that was not read for long is not known.
void go_on(const NominalLoadDesign &design, NominalLoadState &state, bool is_read) {
    if (!(state.time - state.base_time < design.unread)) {
        state.read_time = state.rate = 0.0;
        state.base_time = state.time;
        state.base_heave = state.heave;
    }
    if (is_read || state.read_time != 0.0) state.read_time += design.tick_period;
    if (!std::isfinite(state.heave)) return;
    state.unit = motion_of(design.cable, state.hanging).heave;
    advance_unit(design.cable, state.hanging, {state.heave, state.rate});
}

}  // namespace

void begin_nominal_load(NominalLoadState &state) {
    state = NominalLoadState{};
    state.time = state.base_time = -std::numeric_limits<double>::infinity();
    state.heave = state.base_heave = NOT_KNOWN;
}

// A tick without a reading.
void advance_nominal_load(const NominalLoadDesign &design, NominalLoadState &state) {
    state.time += design.tick_period;
    state.heave = state.base_heave + state.rate * (state.time - state.base_time);
    go_on(design, state, false);
}

// A tick with one, whose rate may be unknown.
void read_nominal_load(const NominalLoadDesign &design, NominalLoadState &state, double time, double heave, double rate) {
    blend_reading(design, state, time, heave, rate);
    go_on(design, state, true);
}

}  // namespace heave
