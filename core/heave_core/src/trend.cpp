// The newest readings of something, in the order of their times, in a ring.
#include "watch.h"

namespace heave {

namespace {

// Place of the reading that is so many before the newest one.
int place(const Trend &trend, int back) { return (trend.next - 1 - back + 2 * REMEMBERED) % REMEMBERED; }

double newest(const Trend &trend) { return trend.times[place(trend, 0)]; }

// Readings of the last `window` seconds.
int count_within(const Trend &trend, double window) {
    const double first = newest(trend) - window;
    int count = 0;
    while (count < trend.count && trend.times[place(trend, count)] >= first) count++;
    return count;
}

}  // namespace

// One that is no later than the last one is left out.
void add(Trend &trend, double time, double value) {
    if (trend.count > 0 && time <= newest(trend)) return;
    if (trend.count == 0 || value != trend.values[place(trend, 0)]) trend.changed = time;
    trend.times[trend.next] = time;
    trend.values[trend.next] = value;
    trend.next = (trend.next + 1) % REMEMBERED;
    trend.count = std::min(trend.count + 1, int(REMEMBERED));
}

// All readings of the last `window` seconds are equal; so they are where there are none.
bool has_stood(const Trend &trend, double window) { return trend.count == 0 || trend.changed <= newest(trend) - window; }

double mean_of(const Trend &trend, double window) {
    if (trend.count == 0) return 0.0;
    const int count = count_within(trend, window);
    double sum = 0.0;
    for (int i = count - 1; i >= 0; i--) sum += trend.values[place(trend, i)];
    return sum / count;
}

// Least squares: s = sum (t - mean t) y / sum (t - mean t)^2, and its error from what the line leaves.
Slope slope_of(const Trend &trend, double window, double least_readings, double filled) {
    const Slope unknown{0.0, 0.0, false};
    if (trend.count < least_readings) return unknown;
    if (newest(trend) - trend.times[place(trend, trend.count - 1)] < filled * window) return unknown;
    const int count = count_within(trend, window);
    if (count < least_readings) return unknown;
    double time = 0.0, value = 0.0, spread = 0.0, across = 0.0, left = 0.0;
    for (int i = 0; i < count; i++) {
        time += trend.times[place(trend, i)];
        value += trend.values[place(trend, i)];
    }
    time /= count;
    value /= count;
    for (int i = 0; i < count; i++) {
        const double about = trend.times[place(trend, i)] - time;
        spread += about * about;
        across += about * trend.values[place(trend, i)];
    }
    const double slope = across / spread;
    for (int i = 0; i < count; i++) {
        const double off = trend.values[place(trend, i)] - value - slope * (trend.times[place(trend, i)] - time);
        left += off * off;
    }
    return {slope, std::sqrt(left / (count - 2) / spread), true};
}

}  // namespace heave
