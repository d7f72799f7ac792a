// The Kalman filter of the loop, x[k+1] = F x[k] + B u[k] + w. Matrices lie packed, row by row.
#pragma once

#include "parts.h"

namespace heave {

// The model of a step: with the drag of the unit's speed, and with a cable that may be slack.
struct Step {
    double F[STATES * STATES], B[STATES], Q[STATES * STATES];
};

// filter_model.cpp: what is not linear in a step and in a reading
double excess_damping(const UnitDrag &drag, double speed);
double kept_by(const UnitDrag &drag, double excess);
double missing_push(const CableSlack &slack, int n, const double *x);
void set_step(const Filter &filter, const double *x, Step &step);
double linearised(const Filter &filter, const Reading &reading, const double *x, double *row);

// to += weight from
inline void add(int n, double weight, const double *__restrict from, double *__restrict to) {
    for (int j = 0; j < n; j++) to[j] += weight * from[j];
}

// filter_steps.cpp: prediction and correction
double dot(int n, const double *a, const double *b);
void multiply(int n, int columns, const double *left, const double *right, double *product);
void predict(int n, const Step &step, double command, double *x, double *P);
double across(int n, const double *row, const double *P, double *product);
void take(const Filter &filter, const Reading *readings, int count, double *x, double *P);

// filter.cpp: gates, late readings, a run of ticks
void begin_filter(const Filter &filter, FilterState &state);
void run_filter(const Filter &filter, FilterState &state, const FilterTick *ticks, int count, const Reading *readings,
                Said *said);

}  // namespace heave
