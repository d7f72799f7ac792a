// Noise and rate of a sensor by itself, from its readings alone. A third difference takes away what is smooth and leaves
// white noise, sqrt(20) times as large; the median of its magnitude does not see spikes.
#include "sense.h"

namespace heave {

// Median; of an even number the mean of the two in the middle.
double median(int count, const double *values) {
    double sorted[NOISE_READINGS];
    std::copy_n(values, count, sorted);
    double *middle = sorted + count / 2;
    std::nth_element(sorted, middle, sorted + count);
    return count % 2 ? *middle : (*std::max_element(sorted, middle) + *middle) / 2.0;
}

void begin_noise(const Measured &measured, SensorNoise &noise) {
    noise = SensorNoise{};
    noise.seen = noise.refused = NOT_KNOWN;
    noise.reported = noise.sigma = measured.nominal;
    noise.mean = 1.0;
}

// Take in a reading; return the standard deviation to use: until it is seen, or stated, several times the nominal one, as
// a sensor noisier than assumed must not be taken for one with an error. An accuracy that cannot be is not stated: its
// square would be in the filter for good.
double add_noise(const Health &health, const Measured &measured, SensorNoise &noise, double value, double stated) {
    noise.count += 1.0;
    if (measured.is_judged && noise.count > 3.0) {
        const double *last = noise.last;
        const int count = int(noise.count) - 3;
        noise.differences[(count - 1) % NOISE_READINGS] = std::abs(value - 3.0 * last[2] + 3.0 * last[1] - last[0]);
        const int held = std::min(count, int(NOISE_READINGS)), step = int(health.noise_updated);
        if (held >= health.fewest_noise && count % step == 0) {
            noise.seen = median(held, noise.differences) / health.noise_median;
            noise.worse = noise.seen >= health.noise_worse * noise.reported ? noise.worse + step : 0.0;
        }
    }
    noise.last[0] = noise.last[1];
    noise.last[1] = noise.last[2];
    noise.last[2] = value;
    const bool is_stated = stated >= 0.0 && stated <= measured.largest_stated;
    if (!is_stated && !std::isnan(stated) && std::isnan(noise.refused)) noise.refused = stated;
    // one that is not a number is no maximum
    noise.sigma = larger(std::max(measured.nominal, is_stated ? stated : 0.0), noise.seen);
    const bool is_known = is_stated || std::isfinite(noise.seen) || !measured.is_judged;
    return is_known ? noise.sigma : health.noise_unknown * measured.nominal;
}

// Whether the newest reading is as far off those before it as off its prediction, by half at least: a spike is. One that goes
// on from those before says that the prediction is wrong.
bool stands_out(const Measured &measured, const SensorNoise &noise, double innovation) {
    const int count = int(noise.count) - 3;
    return !measured.is_judged || count < 1 || noise.differences[(count - 1) % NOISE_READINGS] > 0.5 * std::abs(innovation);
}

// Whether the noise has just become much larger than nominal, or than reported; then `factor` over the nominal one.
bool has_worse_noise(const Health &health, const Measured &measured, SensorNoise &noise) {
    noise.factor = 0.0;
    const bool is_sure = std::isnan(noise.seen) || noise.worse >= NOISE_READINGS;
    if (!is_sure || noise.sigma < health.noise_worse * noise.reported) return false;
    noise.reported = noise.sigma;
    noise.worse = 0.0;
    noise.factor = noise.sigma / measured.nominal;
    return true;
}

void begin_interval(const Health &health, const Sensor &sensor, OwnInterval &interval) {
    interval = OwnInterval{};
    interval.reported = health.late * sensor.period;
    interval.seen = sensor.period, interval.value = sensor.longest_period;
}

// Before the first two readings it is the longest that may be; one longer than that must be known to be so slow.
void add_interval(const Health &health, const Sensor &sensor, OwnInterval &interval, double value) {
    interval.last[int(interval.count) % INTERVALS] = value;
    interval.count += 1.0;
    const double late = health.late * sensor.period;
    if (value <= late && interval.value == sensor.period) return;
    const int held = std::min(int(interval.count), int(INTERVALS));
    interval.seen = held == INTERVALS ? median(held, interval.last) : *std::min_element(interval.last, interval.last + held);
    interval.value = interval.seen > late ? std::min(interval.seen, sensor.longest_period) : sensor.period;
}

// Whether the sensor has become slower than nominal, or than reported.
bool is_slow(const Health &health, OwnInterval &interval) {
    if (interval.seen <= interval.reported || interval.count < INTERVALS) return false;
    interval.reported = health.late * interval.seen;
    return true;
}

}  // namespace heave
