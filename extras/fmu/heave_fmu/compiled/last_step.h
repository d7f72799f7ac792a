/* The envelope as the last step of the fixed controller: heave_core's, with the numbers of bounds.h. */
#ifndef HEAVE_LAST_STEP_H
#define HEAVE_LAST_STEP_H

#include "bounds.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What is read in a tick: raw heave [m] and its rate [m/s], raw count of the drum [m]; NaN: no good reading came. */
typedef struct {
    double heave, heave_rate, count;
} Seen;

/* Set-points of payout [m] and its rate [m/s]; the brake: 0 or 1. */
typedef struct {
    double payout, payout_rate, brake;
} Within;

/* `memory` has ENVELOPE_NUMBERS numbers. */
void last_step_begin(double *memory);
Within last_step(double *memory, const Seen *seen, const Within *ordered);

#ifdef __cplusplus
}
#endif
#endif
