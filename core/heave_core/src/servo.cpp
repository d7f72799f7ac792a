// The servo: v' = (v_set - v)/T within limits of speed, acceleration and power, after its delay; exact in each piece of
// constant set-points.
#include "servo.h"

namespace heave {

namespace {

struct Motion {
    double payout, rate;  // [m], [m/s]
};

// Steps of the position loop within a piece of h [s].
int steps_of(const ServoRun &run, double h) { return std::max(int(std::ceil(h / run.position_step)), 1); }

// What the servo makes of an error in a step of a piece of h [s], less 1.
double left_of_error(const ServoRun &run, const Servo &servo, double h) {
    return std::expm1(-(run.position_gain == 0.0 ? h : h / steps_of(run, h)) / servo.lag);
}

// h [s] on: constant acceleration while the limit acts, then the linear servo. `left` is what that makes of an error
// over all of h, less 1.
Motion moved(Motion now, double v_set, const Servo &servo, double h, double left) {
    auto [u, v] = now;
    if (servo.reach > 1.0) v = clip(v, -servo.speed_in, servo.speed_out);
    double error = v_set - v;
    const double acceleration = error > 0.0 ? servo.acceleration_out : servo.acceleration_in;
    const double limited = (std::abs(error) - acceleration * servo.lag) / acceleration;
    if (limited > 0.0) {
        const double time = std::min(limited, h), gain = std::copysign(acceleration * time, error);
        u += (v + 0.5 * gain) * time;
        v += gain;
        h -= time;
        error = v_set - v;
        left = std::expm1(-h / servo.lag);
    }
    const double change = -error * left;
    return {u + v_set * h - servo.lag * change, v + change};
}

// Speed that the servo goes for [m/s].
double set_point(double demand, const Servo &servo) {
    const double gain = demand >= 0.0 ? servo.gain : servo.gain * servo.hauling;
    const double wanted = gain * std::copysign(std::max(std::abs(demand) - servo.deadband, 0.0), demand) + servo.creep;
    return clip(wanted, -servo.reach * servo.speed_in, servo.reach * servo.speed_out);
}

// The servo under a tension [N]: the limit of its power is one of its speed there.
Servo under(const ServoRun &run, Servo servo, double tension) {
    if (servo.power >= run.no_power_limit || !(tension > 0.0)) return servo;
    servo.speed_out = std::min(servo.speed_out, servo.power / tension);
    servo.speed_in = std::min(servo.speed_in, servo.power / tension);
    return servo;
}

// h [s] of constant set-points on.
Motion piece(const ServoRun &run, Motion now, double payout, double rate, const Servo &servo, double h, double left) {
    if (h <= 0.0) return now;
    const double k = run.position_gain;
    if (k == 0.0) return moved(now, set_point(rate, servo), servo, h, left);
    const int steps = steps_of(run, h);
    h /= steps;
    for (int i = 0; i < steps; i++)
        now = moved(now, set_point(rate + k * (payout - now.payout - 0.5 * now.rate * h), servo), servo, h, left);
    return now;
}

}  // namespace

// The encoder's reading at the end of each of the last ticks [m]. The set-point of tick k acts from k + delay on.
void servo_record(const ServoRun &run, const SetPoints &sent, const Servo &servo, const ServoStart &start, int ticks,
                  double *readings) {
    const double delay = servo.delay / run.tick_period, play = 0.5 * servo.backlash;
    const int first = sent.count - ticks;
    Motion now{start.payout, start.rate};
    double reading = now.payout - std::copysign(play, now.rate), length = -1.0, left = 0.0;
    int k = std::min(std::max(first - int(std::floor(delay)) - 2, 0), sent.count - 1);
    for (int j = 0; j < ticks; j++) {
        double time = first + j;
        const double end = first + j + 1;
        const Servo limited = under(run, servo, sent.tensions[std::max(first + j - 1, 0)]);
        while (time < end) {
            double until = end;
            if (k + 1 < sent.count) {
                const double takes = k + 1 + delay + sent.late[k + 1];
                if (takes <= time + run.edge) {
                    k++;
                    continue;
                }
                until = std::min(takes, end);
            }
            const double h = (until - time) * run.tick_period;
            if (h != length) {
                length = h;
                left = left_of_error(run, servo, h);
            }
            now = piece(run, now, sent.payouts[k], sent.rates[k], limited, h, left);
            time = until;
        }
        reading = clip(reading, now.payout - play, now.payout + play);
        readings[j] = reading;
    }
}

// What the encoder should read at the end of the last tick [m]: payout and rate at the start are those that explain the
// first readings best, by Gauss-Newton steps. `readings` has one more than there are ticks, that at the start; `work`
// has place for twice the readings that are fitted, and for the ticks.
double servo_reading(const ServoRun &run, const SetPoints &sent, const Servo &servo, const double *readings, double *work) {
    const int fitted = run.fitted;
    double *plain = work, *shifted = work + fitted, *path = work + 2 * fitted;
    SetPoints early = sent;
    early.count = sent.count - run.ticks + fitted;
    ServoStart start{readings[0], (readings[1] - readings[0]) / run.tick_period};
    for (int i = 0; i < run.start_steps; i++) {
        servo_record(run, early, servo, start, fitted, plain);
        servo_record(run, early, servo, {start.payout, start.rate + run.rate_step}, fitted, shifted);
        double mean_slope = 0.0, mean_left = 0.0, spread = 0.0, pull = 0.0;
        for (int j = 0; j < fitted; j++) {
            shifted[j] = (shifted[j] - plain[j]) / run.rate_step;
            plain[j] = readings[j + 1] - plain[j];
            mean_slope += shifted[j] / fitted;
            mean_left += plain[j] / fitted;
        }
        for (int j = 0; j < fitted; j++) {
            const double about = shifted[j] - mean_slope;
            spread += about * about;
            pull += about * plain[j];
        }
        const double rate = spread > fitted * run.weak_slope * run.weak_slope ? pull / spread : 0.0;
        start.payout += mean_left - rate * mean_slope;
        start.rate += rate;
    }
    servo_record(run, sent, servo, start, run.ticks, path);
    return path[run.ticks - 1];
}

}  // namespace heave
