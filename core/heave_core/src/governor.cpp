// The governor: no command leaves that would take the winch beyond its limits. The command of a tick acts after the delay;
// what counts is the winch's state then, predicted from the commands that are on their way. The governed command is the
// estimator's input, so that it never predicts a motion that the winch cannot make: all the anti-windup that is needed.
#include "laws.h"

namespace heave {

// P = T v: the speed limit under a tension [m/s]
double speed_under(const ActiveWinch &winch, double tension) {
    if (!std::isfinite(winch.power) || !(tension > 0.0)) return winch.speed;
    return std::min(winch.speed, winch.power / tension);
}

double gain_at(const ActiveWinch &winch, double speed) {
    return speed >= winch.creep ? winch.gain : winch.gain * winch.hauling_gain;
}

// Speed that a set-point asks for [m/s]
double speed_by(const ActiveWinch &winch, double set_point) {
    return winch.creep + gain_at(winch, winch.creep + set_point) * set_point;
}

namespace {

// The set-point that makes the limited servo gain in a tick what the linear one gains under `value`, from `rate`. A limited
// servo gains a t up to t_1, where the set-point is a T away, and then a T (1 - exp(-(dt - t_1) / T)).
double limited_set_point(const ActiveWinch &winch, double value, double rate) {
    const double limit = winch.acceleration, lag = winch.lag, step = std::abs(value - rate);
    if (step <= limit * lag) return value;
    const double gain = std::min(step, winch.linear_step) * winch.tick_share / limit;
    double low = 0.0, high = winch.tick_period;
    for (int i = 0; i < HALVINGS; i++) {
        const double limited = 0.5 * (low + high);
        const double reached = limited - lag * std::expm1(-(winch.tick_period - limited) / lag);
        (reached < gain ? low : high) = limited;
    }
    return rate + std::copysign(limit * (lag + high), value - rate);
}

// Keeps a value within bounds, and notes whether they shaped it.
void bound(Governed &governed, double lower, double upper, int by) {
    if (!(governed.value < lower || governed.value > upper)) return;
    governed.value = clip(governed.value, lower, upper);
    governed.shaped += by;
}

// Set-points under which the speed is within its limit at the end of the tick: v + (s - v)(1 - exp(-dt/T)) = V. One beyond
// the limit drives a slow servo harder, where the winch takes it.
void bound_speed(const ActiveWinch &winch, double speed, double rate, Governed &governed) {
    const double reach = winch.reach * speed, share = winch.tick_share;
    const int by = speed >= winch.speed ? BY_SPEED : BY_POWER;
    if (reach <= speed) return bound(governed, -speed, speed, by);
    const double lower = rate + (-speed - rate) / share, upper = rate + (speed - rate) / share;
    bound(governed, clip(lower, -reach, speed), std::max(std::min(upper, reach), -speed), by);
}

// Speeds from which the winch can stop before the ends of its range; the servo needs its lag twice before it brakes.
void bound_range(const ActiveWinch &winch, double payout, double rate, Governed &governed) {
    const double down = winch.highest - payout - std::max(rate, 0.0) * 2.0 * winch.lag;
    const double up = payout - winch.lowest - std::max(-rate, 0.0) * 2.0 * winch.lag;
    const auto speed = [&](double room) {
        return std::copysign(approach_speed(std::abs(room), winch.acceleration, winch.lag), room);
    };
    bound(governed, -speed(up), speed(down), BY_RANGE);
}

// A first-order winch u' = K (u_0 - u) is ordered a payout no further off than its speed takes it: V / K.
Governed govern_payout(const ActiveWinch &winch, const Wanted &wanted) {
    Governed governed{wanted.command, 0.0, 0.0};
    const double step = speed_under(winch, wanted.tension) / winch.position_rate;
    bound(governed, winch.lowest, winch.highest, BY_RANGE);
    bound(governed, wanted.payout + wanted.lowest, wanted.payout + wanted.highest, BY_BOUNDS);
    bound(governed, wanted.payout - step, wanted.payout + step, BY_SPEED);
    governed.sent = governed.value;
    return governed;
}

}  // namespace

Governed govern(const ActiveWinch &winch, const Wanted &wanted) {
    if (winch.is_first_order) return govern_payout(winch, wanted);
    const double rate = wanted.rate, dt = winch.tick_period, step = winch.linear_step;
    const bool fades = !std::isnan(wanted.least);
    // limits are those of the speed that the servo is asked for, less what its position loop takes off over the tick
    const double taken = winch.position_gain * (wanted.payout + 0.5 * rate * dt);
    Governed governed{wanted.command - taken, 0.0, 0.0};
    bound_speed(winch, speed_under(winch, wanted.tension), rate, governed);
    bound_range(winch, wanted.payout, rate, governed);
    const double lowest = speed_by(winch, wanted.lowest), highest = speed_by(winch, wanted.highest);
    bound(governed, lowest, highest, BY_BOUNDS);
    bound(governed, rate - step, rate + step, BY_ACCELERATION);
    if (fades) bound(governed, wanted.least, wanted.most, BY_FADING);
    const double reach = winch.reach * winch.speed, more = winch.acceleration * (winch.lag + dt);
    double sent = clip(limited_set_point(winch, governed.value, rate), -reach, reach);
    if (fades) sent = clip(sent, wanted.least - more, wanted.most + more);
    sent = clip(sent, lowest, highest);
    governed.value += taken;
    governed.sent = (sent - winch.creep) / gain_at(winch, sent) + taken;
    return governed;
}

}  // namespace heave
