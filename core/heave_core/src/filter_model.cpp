// What is not linear in a step of the model: quadratic drag, a slack cable; and the row of a reading.
#include <cstring>

#include "filter.h"

namespace heave {

// Damping of the drag at a speed beyond the linear one [s].
double excess_damping(const UnitDrag &drag, double speed) {
    return std::max(drag.quadratic * speed - drag.damping, 0.0);
}

// Share of a speed that excess damping c leaves in half a tick: v' = -(c/a) v.
double kept_by(const UnitDrag &drag, double excess) { return std::exp(-excess / drag.inertia * (0.5 * drag.tick_period)); }

namespace {

// Exact decay of the speed by the excess damping c: half of it before the linear step and half after (Strang, SIAM J.
// Numer. Anal. 5 (1968) 506); what is not known of it is noise.
void add_drag(const Filter &filter, const double *x, Step &step) {
    const UnitDrag &drag = filter.drag;
    const int n = filter.states, r = int(drag.rate);
    const double speed = std::abs(x[r]), excess = excess_damping(drag, speed);
    if (excess == 0.0) return;
    const double half = kept_by(drag, excess);
    for (int j = 0; j < n; j++) {
        step.F[r * n + j] *= half;
        step.Q[r * n + j] *= half;
    }
    for (int i = 0; i < n; i++) {
        step.F[i * n + r] *= half;
        step.Q[i * n + r] *= half;
    }
    step.B[r] *= half;
    const double error = filter.drag_error * excess / drag.inertia * speed;
    step.Q[r * n + r] += error * error * filter.drag_error_time * drag.tick_period;
}

// A slack cable lets the unit sink by its weight: the spring gives way to that, at the pull of the tick (secant).
void add_slack(const Filter &filter, const double *x, Step &step) {
    const CableSlack &slack = filter.slack;
    const int n = filter.states, r = int(slack.rate);
    const double missing = missing_push(slack, n, x);
    if (missing == 0.0) return;
    const double share = missing / (missing + slack.largest) * slack.tick_period / slack.inertia;
    for (int j = 0; j < n; j++) step.F[r * n + j] -= share * slack.pull[j];
    const double error = filter.drag_error * missing / slack.inertia;
    step.Q[r * n + r] += error * error * filter.drag_error_time * slack.tick_period;
}

}  // namespace

// How much further down the model pushes the unit than its weight, which no slack cable does [m].
double missing_push(const CableSlack &slack, int n, const double *x) {
    return std::max(-dot(n, slack.pull, x) - slack.largest, 0.0);
}

void set_step(const Filter &filter, const double *x, Step &step) {
    const int n = filter.states;
    std::memcpy(step.F, filter.F, sizeof(double) * n * n);
    std::memcpy(step.B, filter.B, sizeof(double) * n);
    std::memcpy(step.Q, filter.Q, sizeof(double) * n * n);
    add_drag(filter, x, step);
    add_slack(filter, x, step);
}

// The row of a reading at x, and its prediction. Between ticks by Newton's formula over two ticks ahead; a relative
// scale error s is a state: z = (1 + s) h x, linearised.
double linearised(const Filter &filter, const Reading &reading, const double *x, double *row) {
    const int n = filter.states, which = int(reading.which), scale_state = filter.scale_states[which];
    const double offset = reading.offset, bend = 0.5 * offset * (offset - 1.0);
    const double *at = filter.rows + which * n, *change = filter.changes + which * n, *second = filter.bends + which * n;
    for (int j = 0; j < n; j++) row[j] = at[j] + offset * change[j] + bend * second[j];
    if (reading.first_state >= 0.0) row[int(reading.first_state)] += reading.first_weight;
    if (reading.second_state >= 0.0) row[int(reading.second_state)] += reading.second_weight;
    const double plain = dot(n, row, x);
    if (scale_state < 0) return plain;
    const double scale = 1.0 + x[scale_state];
    for (int j = 0; j < n; j++) row[j] *= scale;
    row[scale_state] += plain;
    return scale * plain;
}

}  // namespace heave
