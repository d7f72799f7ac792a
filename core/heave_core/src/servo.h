// A drum under the set-points it was sent, limits included: what its encoder should have read.
#pragma once

#include "parts.h"

namespace heave {

// Set-points of the ticks of a record, oldest first.
struct SetPoints {
    const double *payouts, *rates;  // [m], [m/s]
    const double *late;             // by how much later than the delay each took effect, in ticks
    const double *tensions;         // at the top at the end of each tick [N]; NaN: unknown
    int count;
};

// Rows of a table (4, count).
inline SetPoints set_points(const double *sent, int count) {
    return {sent, sent + count, sent + 2 * count, sent + 3 * count, count};
}

void servo_record(const ServoRun &run, const SetPoints &sent, const Servo &servo, const ServoStart &start, int ticks,
                  double *readings);
double servo_reading(const ServoRun &run, const SetPoints &sent, const Servo &servo, const double *readings, double *work);

}  // namespace heave
