/* Authority, law and governor about the filter: the C twin of FixedControllerPart.step. */
#include "controller.h"

#include <math.h>
#include <string.h>

#include "design.h"

static double clip(double value, double lower, double upper)
{
    return fmin(fmax(value, lower), upper);
}

void controller_begin(Controller *controller)
{
    memset(controller, 0, sizeof *controller);
    filter_begin(&controller->filter);
    controller->place = NAN;
}

/* Move the unit below a locked winch by a tick, its outlet at `tip`; heave and rate in `state`. See SimulatedUnit. */
static void step_free_unit(Controller *controller, const double tip[2], double state[2])
{
    double *mode = controller->free_unit, moved[2];
    const double half = kept_speed(mode[1], 0.5 * TICK_PERIOD);
    const double slowed[2] = {mode[0], half * mode[1]};
    for (int i = 0; i < 2; i++) moved[i] = dot(FREE_A[i], slowed, 2) + dot(FREE_B[i], tip, 2);
    mode[0] = moved[0];
    mode[1] = half * moved[1];
    controller->outlet[0] = tip[0] + TICK_PERIOD * tip[1];
    controller->outlet[1] = tip[1];
    for (int i = 0; i < 2; i++) state[i] = dot(FREE_C[i], mode, 2) + dot(FREE_D[i], controller->outlet, 2);
}

/* The command that the law asks for: u = -gain x, with the share of the unit's own error bounded. */
static double ask(const double x[ORDER])
{
    const double whole = -dot(GAIN, x, ORDER);
    const double share = -(GAIN[UNIT] * x[UNIT] + GAIN[UNIT_RATE] * x[UNIT_RATE]);
    return whole - share + clip(share, -LARGEST_SHARE, LARGEST_SHARE);
}

/* Set-point that makes the limited servo gain what the linear one gains under `value`; see governor.SpeedServo. */
static double servo_set_point(double value, double rate)
{
    const double step = fabs(value - rate);
    if (step <= ACCELERATION * SERVO_LAG) return value;
    const double gain = fmin(step, LINEAR_STEP) * -expm1(-TICK_PERIOD / SERVO_LAG) / ACCELERATION;
    double low = 0.0, high = TICK_PERIOD;
    for (int i = 0; i < 20; i++) {
        const double limited = 0.5 * (low + high);
        const double reached = limited - SERVO_LAG * expm1(-(TICK_PERIOD - limited) / SERVO_LAG);
        if (reached < gain)
            low = limited;
        else
            high = limited;
    }
    return rate + copysign(ACCELERATION * (SERVO_LAG + high), value - rate);
}

/* Speed [m/s] from which half the acceleration is enough to stop after a distance [m]. */
static double approach_speed(double distance)
{
    return fmin(sqrt(ACCELERATION * distance), distance / (4.0 * SERVO_LAG));
}

/* Bound a command [m/s] by speed, range and acceleration; what the winch is sent for it in `sent`. */
static double govern(double wanted, double payout, double rate, double *sent)
{
    const double taken = POSITION_GAIN * (payout + 0.5 * rate * TICK_PERIOD), reach = SET_POINT_REACH * SPEED;
    double lower = -SPEED, upper = SPEED, value = wanted - taken;
    if (reach > SPEED) {
        const double share = -expm1(-TICK_PERIOD / SERVO_LAG);
        lower = clip(rate + (-SPEED - rate) / share, -reach, SPEED);
        upper = fmax(fmin(rate + (SPEED - rate) / share, reach), -SPEED);
    }
    value = clip(value, lower, upper);
    const double down = PAYOUT_MAXIMUM - payout - fmax(rate, 0.0) * 2.0 * SERVO_LAG;
    const double up = payout - PAYOUT_MINIMUM - fmax(-rate, 0.0) * 2.0 * SERVO_LAG;
    value = clip(value, -copysign(approach_speed(fabs(up)), up), copysign(approach_speed(fabs(down)), down));
    value = clip(value, rate - LINEAR_STEP, rate + LINEAR_STEP);
    const double speed = clip(servo_set_point(value, rate), -SET_POINT_REACH * SPEED, SET_POINT_REACH * SPEED);
    const double servo_gain = speed >= CREEP ? SPEED_GAIN : SPEED_GAIN * HAULING_GAIN;
    *sent = (speed - CREEP) / servo_gain + taken;
    return value + taken;
}

Order controller_step(Controller *controller, int tick, Reading *readings, int count)
{
    Order order = {0.0, 0.0, tick * TICK_PERIOD < SETTLING_TIME};
    double x[ORDER], tip[2], free_unit[2];
    filter_step(&controller->filter, tick, controller->command, readings, count);
    memcpy(x, controller->filter.x, sizeof x);
    for (int i = 0; i < 2; i++) tip[i] = dot(TIP[i], x, ORDER);
    step_free_unit(controller, tip, free_unit);
    const double payout = dot(AHEAD[0], x, ORDER), rate = dot(AHEAD[1], x, ORDER);
    if (order.brake) {
        controller->command = POSITION_GAIN * payout;
        order.payout = POSITION_GAIN > 0.0 ? payout : 0.0;
        return order;
    }
    controller->authority += clip(FACTOR - controller->authority, -FADE_STEP, FADE_STEP);
    x[UNIT] -= (1.0 - controller->authority) * free_unit[0];
    x[UNIT_RATE] -= (1.0 - controller->authority) * free_unit[1];
    for (int i = 0; i < ORDER; i++)
        if (IS_SEA[i]) x[i] *= controller->authority;
    controller->command = govern(ask(x), payout, rate, &order.payout_rate);
    return order;
}

void controller_sent(Controller *controller, const Order *ordered, const Order *sent)
{
    if (sent->brake && !ordered->brake) {
        controller->command = POSITION_GAIN * dot(AHEAD[0], controller->filter.x, ORDER);
        return;
    }
    const double more = sent->payout_rate - ordered->payout_rate;
    if (more != 0.0) controller->command += more * (more >= CREEP ? SPEED_GAIN : SPEED_GAIN * HAULING_GAIN);
}

Order controller_placed(Controller *controller, const Order *sent)
{
    const double *x = controller->filter.x, drum = dot(DRUM_PAYOUT, x, ORDER), ahead = dot(AHEAD[0], x, ORDER);
    Order placed = *sent;
    if (sent->brake || isnan(controller->place)) controller->place = drum;
    placed.payout = controller->place;
    if (sent->brake) return placed;
    const double speed = sent->payout_rate + POSITION_GAIN * (sent->payout - ahead);
    controller->place += TICK_PERIOD * (speed + (drum - controller->place) / PLACE_LEAK);
    placed.payout = controller->place = clip(controller->place, drum - PLACE_REACH, drum + PLACE_REACH);
    placed.payout_rate += POSITION_GAIN * (sent->payout - placed.payout);
    return placed;
}
