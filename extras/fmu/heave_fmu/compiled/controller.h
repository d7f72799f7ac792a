/* The fixed controller: filter, law and governor of one design. No allocation, no library but that of mathematics. */
#ifndef HEAVE_CONTROLLER_H
#define HEAVE_CONTROLLER_H

#include "filter.h"

typedef struct {
    Filter filter;
    double free_unit[2], outlet[2]; /* unit on a winch that is locked: heave and rate; the boom tip's */
    double command, authority;      /* of the last tick [m/s], [-] */
    double place;                   /* payout that belongs to what was sent [m]; NaN: none yet */
} Controller;

/* Set-points of payout [m] and its rate [m/s], positive lowers; the brake. */
typedef struct {
    double payout, payout_rate;
    bool brake;
} Order;

void controller_begin(Controller *controller);

/* Do a tick, from 1, with the readings that came since the last one. */
Order controller_step(Controller *controller, int tick, Reading *readings, int count);

/* Go on from what was sent in place of the order that a tick gave: the filter predicts by it. */
void controller_sent(Controller *controller, const Order *ordered, const Order *sent);

/* An order that asks for the speed of `sent`, by the payout that belongs to it, for a drive with a position loop. */
Order controller_placed(Controller *controller, const Order *sent);

#endif
