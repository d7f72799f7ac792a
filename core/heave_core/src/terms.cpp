// The estimator's terms: a gated reading about its zero, corrected, without what the mean payout brings about.
#include "sense.h"

namespace heave {

// The tick nearest to a time, and how much later than that it is.
Stamp stamp_of(const SenseDesign &design, double time) {
    const double ticks = time / design.tick_period, tick = std::nearbyint(ticks), offset = ticks - tick;
    return {tick, std::abs(offset) > design.on_tick ? offset : 0.0};
}

void remember_share(SenseState &state, double tick, const double *mean_state, int order) {
    state.newest_share = (state.newest_share + 1) % SHARES;
    state.shares = std::min(state.shares + 1, int(SHARES));
    state.share_ticks[state.newest_share] = tick;
    std::copy_n(mean_state, order, state.share_states[state.newest_share]);
}

// The mean payout's share in a reading, at its time: of the newest state kept that is not after it, or of the oldest. By
// Newton's formula between ticks. At rest the cable's stretch by more payout takes the unit further down.
double share_of(const SenseDesign &design, const SenseState &state, const LookDesign &look, const Observed &observed) {
    const Measured &measured = design.measured[int(observed.row)];
    if (state.shares == 0 || design.sensors[measured.sensor].sees_tip) return 0.0;
    int place = state.newest_share;
    for (int i = 1; i < state.shares && state.share_ticks[place] > observed.tick; i++) place = (place + SHARES - 1) % SHARES;
    const double *x = state.share_states[place], offset = observed.offset, bend = 0.5 * offset * (offset - 1.0);
    double share = 0.0;
    for (int j = 0; j < look.order; j++)
        share += (measured.row[j] + offset * measured.change[j] + bend * measured.bend[j]) * x[j];
    return measured.stretches ? share - design.stretch_per_payout * dot(look.order, look.payout, x) : share;
}

// What a sensor counts from; the first reading of the depth is where the unit hung then.
double zero_of(const SenseDesign &design, SenseState &state, int sensor, double value) {
    const Sensor &assumed = design.sensors[sensor];
    if (assumed.zero == STATIC_TENSION) return design.static_tension;
    if (assumed.zero != FIRST_READING) return 0.0;
    double &zero = state.gates[sensor].zero;
    if (std::isnan(zero)) zero = value - assumed.sign * state.first_heave;
    return zero;
}

// A reading for the filter: (value - offset)/scale at its stamp less the delay, less the mean payout's share.
Reading in_terms(const SenseDesign &design, const Observed &observed) {
    const int row = int(observed.row);
    const Measured &measured = design.measured[row];
    const Sensor &sensor = design.sensors[measured.sensor];
    const double offset = row == sensor.measured ? sensor.offset : 0.0;
    Stamp stamp{observed.tick, observed.offset};
    if (sensor.delay != 0.0) stamp = stamp_of(design, (stamp.tick + stamp.offset) * design.tick_period - sensor.delay);
    const double sigma = observed.sigma > 0.0 ? observed.sigma : measured.sigma;
    return {std::min(stamp.tick, observed.delivered), double(measured.which), (observed.gated - offset) / sensor.scale - observed.share,
            stamp.offset, square(sigma), double(design.levers[0]), observed.lever_x, double(design.levers[1]), observed.lever_y};
}

// By the ticks they belong to; those of one tick stay in their order.
void sort_readings(Reading *readings, int count) {
    for (int i = 1; i < count; i++)
        for (int j = i; j > 0 && readings[j].tick < readings[j - 1].tick; j--) std::swap(readings[j], readings[j - 1]);
}

}  // namespace heave
