// The unit as it moves below an outlet whose motion is known, nothing being measured of the unit:
//
//     a z'' + max(b, d |z'|) z' = max(x_0 - z, -w),
//
// with the first mode of cable and unit as z, of which the unit's heave is p z + (1 - p) x_0, and w the weight over the
// stiffness. Quadratic drag is split off the exact step of the linear model: half before and half after it (Strang, SIAM
// J. Numer. Anal. 5 (1968) 506). A cable cannot push: the unit then sinks by its weight alone, without the part of the
// cable that moves with it; when the cable takes it up again both go on with their common momentum.
#include "look.h"

namespace heave {

namespace {

// By how much more than its weight the model would push the unit down at a stretch of the mode [m].
double missing_push(const HangingCable &cable, double stretch) {
    return std::max(cable.participation * stretch - cable.largest_push, 0.0);
}

// Speed of the mode that a pull upwards, in metres of stretch, makes within a tick [m/s].
double gained_speed(const HangingCable &cable, double pull) {
    return cable.tick_period * pull / (cable.natural_inertia * cable.participation);
}

}  // namespace

Motion motion_of(const HangingCable &cable, const HangingUnit &unit) {
    const double p = cable.participation;
    return {p * unit.heave + (1.0 - p) * unit.outlet, p * unit.rate + (1.0 - p) * unit.outlet_rate};
}

void continue_at(const HangingCable &cable, HangingUnit &unit, const Motion &motion) {
    const double p = cable.participation;
    unit.heave = (motion.heave - (1.0 - p) * unit.outlet) / p;
    unit.rate = (motion.rate - (1.0 - p) * unit.outlet_rate) / p;
}

// A tick; `outlet` is at its start: boom tip less payout.
void advance_unit(const HangingCable &cable, HangingUnit &unit, const Motion &outlet) {
    const auto &A = cable.A, &B = cable.B;
    const double kept = kept_by(cable.drag, excess_damping(cable.drag, std::abs(unit.rate))), slowed = kept * unit.rate;
    const double heave = A[0][0] * unit.heave + A[0][1] * slowed + (B[0][0] * outlet.heave + B[0][1] * outlet.rate);
    double rate = kept * (A[1][0] * unit.heave + A[1][1] * slowed + (B[1][0] * outlet.heave + B[1][1] * outlet.rate));

    const double before = missing_push(cable, unit.heave - outlet.heave);
    unit.outlet = outlet.heave + cable.tick_period * outlet.rate;
    unit.outlet_rate = outlet.rate;
    const double after = missing_push(cable, heave - unit.outlet);
    rate += gained_speed(cable, 0.5 * (before + after));
    if (after > 0.0) rate -= gained_speed(cable, cable.cable_share * cable.largest_push);
    else if (unit.is_slack != 0.0) rate += cable.cable_share * (outlet.rate - rate);
    unit.is_slack = after > 0.0;
    unit.heave = heave;
    unit.rate = rate;
}

}  // namespace heave
