// A reading is refused for what it shows alone: not a number, or one that cannot be; a status of the sensor's own, a stamp
// that cannot be, a value that does not change. What only the estimate can show (a spike) comes back from the innovations.
#include "sense.h"

namespace heave {

namespace {

void begin_sameness(Sameness &same, double usual) {
    same = Sameness{};
    same.run = same.longest = 1.0;
    same.usual = same.least = usual;
    same.step = INFINITE;
    std::fill_n(same.values, 4, NOT_KNOWN);
}

// Take in that the first number has changed to a value: its smallest step, and how high and low it goes, forgotten slowly.
void add_step(Sameness &same, double value, double weight) {
    if (std::isnan(same.values[0])) same.top = same.bottom = value;
    if (value != same.values[0]) same.step = std::min(same.step, std::abs(value - same.values[0]));
    same.top = std::max(value, same.top - weight * (same.top - value));
    same.bottom = std::min(value, same.bottom + weight * (value - same.bottom));
}

// Time for which readings in steps may stand at a crest: T / pi acos(1 - 2 / n), for which a wave of the period T and n
// steps high is within a step of its top. Until the first step nothing is known of them, and a sea may be smaller than one.
double time_at_crest(const Health &health, double step, double steps) {
    if (step == INFINITE) return health.standing_time;
    return health.longest_wave / M_PI * std::acos(1.0 - 2.0 / std::max(steps, 1.0));
}

// Whether the run of equal readings is no chance. Of a sensor that reads in steps two in a row are often the same: a run
// of n comes by chance with a probability p^(n - 1), p the share of readings that were like the one before. At a crest of
// the sea runs are longer than that: one must also be longer than those before, than a crest that is approached as fast as
// the last step shows (of a motion q - a t^2 / 2 in steps of q the last one takes 4.8 times the one before), and than the
// crest of a long wave as high as what was read of late.
bool stands(const Health &health, Sameness &same, double interval, const double *values, int count) {
    if (!std::equal(values, values + count, same.values)) {
        const double weight = std::min(1.0, same.run / health.sameness_memory);
        // one run far longer than all before was a sensor that stood, not one that reads in steps
        const double longest = std::min(same.run, 2.0 * same.longest);
        same.longest = std::max(longest, same.longest * (1.0 - weight / 10.0));
        same.usual += weight * ((same.run - 1.0) / same.run - same.usual);
        same.newest = same.run;
        add_step(same, values[0], weight / 10.0);
        same.run = 1.0;
        std::copy_n(values, count, same.values);
        return false;
    }
    same.run += 1.0;
    const double steps = (same.top - same.bottom) / same.step;
    double least = health.frozen_samples;
    if (steps < health.few_steps || same.longest >= health.in_steps) {
        if (same.run * interval < time_at_crest(health, same.step, steps)) return false;
        least = std::max({least, health.fewest_of_steps, std::nearbyint(health.longer * same.longest),
                          health.crest * (same.newest + 1.0)});
    }
    return same.run >= least && std::pow(std::max(same.usual, same.least), same.run - 1.0) < health.by_chance;
}

// Why a reading may not be used; heave and rate alone may freeze while the attitude goes on.
int fault_of(const Health &health, const Sensor &sensor, SensorGate &gate, double now, double time, const double *values,
             int count, double status) {
    double sum = 0.0;
    for (int i = 0; i < count; i++) sum += values[i];
    if (!std::isfinite(sum)) return NOT_A_NUMBER;
    if (!is_in_range(sensor, values, count)) return OUT_OF_RANGE;
    if (!std::isfinite(time) || time > now + health.stamp_tolerance) return WRONG_STAMP;
    if (time <= gate.newest_stamp) return OUT_OF_ORDER;
    // a heave that stands contradicts its rate as well
    if (count > 2 && stands(health, gate.same_part, gate.interval.value, values, 2)) status = FROZEN;
    if (status != GOOD) return int(status);
    const bool is_checked = sensor.checks_frozen != 0.0;
    return is_checked && stands(health, gate.same, gate.interval.value, values, count) ? FROZEN : GOOD;
}

void accept(SensorGate &gate) {
    gate.bad_in_a_row = 0.0;
    gate.good_in_a_row += 1.0;
    if (gate.level != SENSOR_OK && gate.good_in_a_row >= gate.good_needed) {
        gate.level = SENSOR_OK;
        gate.reason = GOOD;
    }
}

}  // namespace

// Whether each of the first numbers of a reading can be; one that cannot would be squared, or left in a running mean.
bool is_in_range(const Sensor &sensor, const double *values, int count) {
    for (int i = 0; i < count; i++)
        if (std::abs(values[i]) > sensor.largest[i]) return false;
    return true;
}

void begin_gate(const Health &health, const Sensor &sensor, SensorGate &gate) {
    gate = SensorGate{};
    gate.good_needed = health.recover_samples;
    gate.newest_stamp = gate.newest_arrival = -INFINITE;
    gate.newest_accepted = gate.started = gate.delayed_since = gate.zero = NOT_KNOWN;
    begin_sameness(gate.same, sensor.first_sameness);
    begin_sameness(gate.same_part, sensor.part_sameness);
    begin_interval(health, sensor, gate.interval);
}

bool judge(const Health &health, const Sensor &sensor, SensorGate &gate, double now, double time, const double *values,
           int count, double status) {
    const int reason = fault_of(health, sensor, gate, now, time, values, count, status);
    const bool can_be = time <= now + health.stamp_tolerance;  // else readings after it would come too late for ever
    if (can_be && gate.newest_stamp < time) {
        if (gate.newest_stamp > -INFINITE) add_interval(health, sensor, gate.interval, time - gate.newest_stamp);
        gate.newest_stamp = time;
    }
    if (reason != GOOD) {
        refuse(health, gate, reason);
        return false;
    }
    gate.accepted += 1.0;
    gate.newest_arrival = now;
    gate.newest_accepted = larger(time, gate.newest_accepted);
    accept(gate);
    return true;
}

void refuse(const Health &health, SensorGate &gate, int reason) {
    gate.refused += 1.0;
    gate.bad_in_a_row += 1.0;
    gate.good_in_a_row = 0.0;
    gate.good_needed = health.recover_samples;
    gate.reason = reason;
    const bool is_grave = reason == FROZEN || gate.bad_in_a_row >= health.bad_in_a_row;
    gate.level = is_grave || gate.level == SENSOR_LOST ? SENSOR_LOST : SENSOR_SUSPECT;
}

// Take back the newest reading. Where such readings were predicted badly before, one more is no news of the sensor.
void take_back(const Health &health, SensorGate &gate, int reason, bool is_news) {
    const double level = gate.level, before = gate.reason;
    gate.accepted -= 1.0;
    refuse(health, gate, reason);
    if (!is_news) {
        gate.level = level;
        gate.reason = before;
    }
}

// Age above which the newest accepted reading is stale [s].
double largest_age(const Health &health, const Sensor &sensor, const SensorGate &gate) {
    return sensor.latency + health.stale_samples * gate.interval.value;
}

// Notice what did not come; once a tick, after the readings.
void tick_gate(const Health &health, const Sensor &sensor, SensorGate &gate, double now) {
    if (std::isnan(gate.started)) gate.started = now;
    const double newest = std::isnan(gate.newest_accepted) ? gate.started : gate.newest_accepted, age = now - newest;
    if (age <= largest_age(health, sensor, gate) + health.rounding || gate.bad_in_a_row != 0.0) return;
    const double usual = health.late * gate.interval.value + health.rounding;  // else a silence would begin as a delay
    const int reason = now - gate.newest_arrival <= usual ? DELAYED : STALE;
    if (gate.reason != reason) gate.delayed_since = now;
    gate.level = SENSOR_LOST;
    gate.reason = reason;
    gate.silence = age;
    gate.good_in_a_row = 0.0;
}

}  // namespace heave
