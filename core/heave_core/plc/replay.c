/* Do the cycles of a recorded run, and write their orders: `replay RUN ORDERS`, on a machine, or in an emulator of another.

   A cycle of RUN is the number of its readings, these, and what the drive has reported; all numbers are doubles, in the
   order of controller.h. A cycle of ORDERS is payout, rate, brake, mode, authority and what
   has begun with the load. */
#include "controller.h"

#include <stdio.h>

enum { MOST = 64, PER_WINCH = 8 };

static HeaveWinch winch_of(const double *numbers)
{
    const HeaveWinch winch = {(int)numbers[0], numbers[1], numbers[2], numbers[3],
                              (int)numbers[4], (int)numbers[5], (int)numbers[6], (int)numbers[7]};
    return winch;
}

int main(int argc, char **argv)
{
    FILE *run = argc == 3 ? fopen(argv[1], "rb") : NULL, *orders = run ? fopen(argv[2], "wb") : NULL;
    void *controller = heave_controller_only();
    HeaveReading readings[MOST];
    double count, winch[PER_WINCH];
    if (!orders) return 2;
    heave_controller_begin(controller);
    while (fread(&count, sizeof count, 1, run) == 1) {
        const size_t wanted = (size_t)count;
        HeaveOrder order;
        if (wanted > MOST || fread(readings, sizeof *readings, wanted, run) != wanted) return 3;
        if (fread(winch, sizeof winch, 1, run) != 1) return 3;
        const HeaveWinch reported = winch_of(winch);
        heave_controller_step(controller, readings, (int)wanted, &reported, &order);
        const double found[] = {order.payout, order.rate, order.brake, order.mode, order.authority, order.load_news};
        if (fwrite(found, sizeof found, 1, orders) != 1) return 4;
    }
    return fclose(orders) ? 4 : 0;
}
