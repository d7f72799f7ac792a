/* The Kalman filter of the fixed controller: the C twin of winch_controller_node.model.kalman_kernel. */
#ifndef HEAVE_FILTER_H
#define HEAVE_FILTER_H

#include <stdbool.h>

#include "interface.h"

/* Most readings of one tick that are kept. */
#define MOST (2 * MEASUREMENTS)

/* A reading: the tick that it was measured at, how much later than that it was [ticks], which measurement, its value. */
typedef struct {
    int tick, which;
    double offset, value;
} Reading;

/* Estimate x and covariance P of the newest tick; model F, B, Q of a step; rings of the past, by tick % KEPT. */
typedef struct {
    double x[ORDER], P[ORDER][ORDER];
    double F[ORDER][ORDER], B[ORDER], Q[ORDER][ORDER];
    double past_x[KEPT][ORDER], past_P[KEPT][ORDER][ORDER], commands[KEPT];
    Reading used[KEPT][MOST];
    int counts[KEPT], newest, kept;
    double streams[MEASUREMENTS];
    int refusals[MEASUREMENTS];
} Filter;

void filter_begin(Filter *filter);

/* Advance to a tick after the `command` of the tick before [m/s], and take in readings, which are put in order. */
void filter_step(Filter *filter, int tick, double command, Reading *readings, int count);

/* Share of the unit's speed [m/s] that drag leaves in a time [s], beyond the linear damping. */
double kept_speed(double speed, double time);

double dot(const double *a, const double *b, int count);

#endif
