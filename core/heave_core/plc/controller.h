/* The controller's tick without Python, as a PLC, a microcontroller or a simulator calls it once a cycle.

   Filter, gates, proofs, guard, supervision, modes, law, governor and envelope are those of the nodes; what a scenario fills
   is in image.h. Memory is fixed; nothing but the mathematical library is called. Positive payout lowers; SI units. */
#ifndef HEAVE_CONTROLLER_H
#define HEAVE_CONTROLLER_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Sensors, by the number of a reading. */
enum { HEAVE_MRU, HEAVE_DEPTH, HEAVE_ENCODER, HEAVE_VELOCITY, HEAVE_IMU, HEAVE_LOAD_CELL };

/* Modes that may be requested, and that are. */
enum {
    HEAVE_OFF,
    HEAVE_STANDBY,
    HEAVE_COMPENSATING,
    HEAVE_CONSTANT_TENSION,
    HEAVE_MANUAL,
    HEAVE_FADE_OUT,
    HEAVE_STOPPING,
    HEAVE_STOPPED,
    HEAVE_EMERGENCY_STOP
};

/* A reading that came since the last cycle. A scalar one uses the first three; NaN: not known. */
typedef struct {
    double sensor, time;      /* number; stamp [s], of the controller's clock: cycle k is at k times its period */
    double value;             /* heave of the boom tip [m], depth [m], tension [N] */
    double rate, roll, pitch; /* of the MRU: heave rate [m/s], [rad] */
    double status;            /* 0: good */
    double sigma, rate_sigma; /* that it states of its noise [m], [m/s]; NaN: none */
} HeaveReading;

/* What the drive has reported since the last cycle. */
typedef struct {
    int is_new;          /* 0: nothing came */
    double time;         /* of the count, by the drive's clock [s] */
    double payout, rate; /* count of the drum [m], and the speed that it states [m/s] */
    int brake, fault;    /* engaged; its own fault, 0: none */
    int limits_hit;      /* bits of heave_msgs/WinchState */
    int sequence;        /* number of the newest order that it has taken */
} HeaveWinch;

/* The order for the cycle that begins, and what is known. Bits and numbers: docs/core.md. */
typedef struct {
    double payout, rate; /* set-points [m], [m/s] */
    double mean_payout;  /* about which the winch works, in the drum's count [m] */
    double depth_set_point; /* the same, as the load is lowered by it [m] */
    int brake, sequence;
    int mode, gates;               /* mode; Gate: why compensation does not begin */
    double authority;              /* of compensation, 0 to 1 */
    int lost_sensors, harm, cause; /* bits of sensors; Harm; Cause: why the envelope has taken over */
    int happened, asks;            /* Happened; Asks: NEEDS_PLAN: at the limits, and no plan is made */
    int load_news;                 /* LoadNews: what has just begun with load, rope and travel */
} HeaveOrder;

/* Bytes of a controller's memory, to be aligned as a double is. */
size_t heave_controller_size(void);

/* The memory of the one controller of a program that has no other. */
void *heave_controller_only(void);

void heave_controller_begin(void *memory);

/* Do a cycle, from 1, with the readings of it: those of the MRU first, oldest first. */
void heave_controller_step(void *memory, const HeaveReading *readings, int count, const HeaveWinch *winch, HeaveOrder *order);

/* Ask for a mode, between two cycles; return 1 where it is taken. */
int heave_controller_request(void *memory, int mode);

#ifdef __cplusplus
}
#endif
#endif
