// The rolling window of the figures of merit, from sensors and estimates alone.
#include "watch.h"

namespace heave {

namespace {

// The larger of two numbers, of which the first may not be known yet.
double larger(double known, double value) { return known > value ? known : value; }

// A row counts where each heave is known that is known now.
bool is_counted(const KpiRow &row, const KpiRow &now) {
    return (std::isfinite(row.unit) || std::isnan(now.unit)) && (std::isfinite(row.tip) || std::isnan(now.tip)) &&
           (std::isfinite(row.uncompensated) || std::isnan(now.uncompensated));
}

// Sums of heaves, and of the squares of their distances from means.
struct Heaves {
    double unit, uncompensated, tip, outlet;
};

Heaves mean_of(const Heaves &sums, double rows) {
    return {sums.unit / rows, sums.uncompensated / rows, sums.tip / rows, sums.outlet / rows};
}

void note_extremes(const KpiRow &row, KpiWindow &window, double &felt) {
    window.speed = std::max(window.speed, std::abs(row.rate));
    window.acceleration = std::max(window.acceleration, std::abs(row.acceleration));
    window.at_limit += row.at_limit;
    if (!std::isfinite(row.tension)) return;
    const double power = std::abs(row.tension * row.rate);
    felt += 1.0;
    window.power = larger(window.power, power);
    window.mean_power = (felt > 1.0 ? window.mean_power : 0.0) + power;
    window.least_tension = -larger(-window.least_tension, -row.tension);
    window.largest_tension = larger(window.largest_tension, row.tension);
}

// s = sqrt(mean square of the distances), of two ticks at least.
double deviation(double squares, double rows) { return rows > 1.0 ? std::sqrt(squares / rows) : NOT_KNOWN; }

}  // namespace

void add(const KpiDesign &design, KpiState &state, KpiRow *rows, KpiRow row) {
    row.acceleration = (row.rate - state.last_rate) / design.tick_period;
    row.at_limit = std::abs(row.rate) >= design.speed || std::abs(row.acceleration) >= design.acceleration;
    state.last_rate = row.rate;
    rows[(long long)state.count % (long long)design.rows] = row;
    state.count += 1.0;
}

void summarise(const KpiDesign &design, const KpiState &state, const KpiRow *rows, KpiWindow &window) {
    const long long held = (long long)std::min(state.count, design.rows), last = (long long)state.count - 1;
    window = KpiWindow{};
    window.power = window.mean_power = window.least_tension = window.largest_tension = window.largest = NOT_KNOWN;
    if (held == 0) {
        window.unit = window.uncompensated = window.tip = window.outlet = NOT_KNOWN;
        return;
    }
    const KpiRow &now = rows[last % (long long)design.rows];
    Heaves sums{}, squares{};
    double felt = 0.0;
    for (long long i = 0; i < held; i++) {
        const KpiRow &row = rows[i];
        if (!is_counted(row, now)) continue;
        window.rows += 1.0;
        sums.unit += row.unit;
        sums.uncompensated += row.uncompensated;
        sums.tip += row.tip;
        sums.outlet += row.tip - row.payout;
        note_extremes(row, window, felt);
    }
    const Heaves mean = mean_of(sums, window.rows);
    for (long long i = 0; i < held; i++) {
        const KpiRow &row = rows[i];
        if (!is_counted(row, now)) continue;
        const double off = row.unit - mean.unit, more = row.uncompensated - mean.uncompensated;
        const double tip = row.tip - mean.tip, outlet = row.tip - row.payout - mean.outlet;
        squares.unit += off * off;
        squares.uncompensated += more * more;
        squares.tip += tip * tip;
        squares.outlet += outlet * outlet;
        window.largest = larger(window.largest, std::abs(off));
    }
    // a heave that is not known now is not known of any tick
    window.unit = std::isnan(now.unit) ? NOT_KNOWN : deviation(squares.unit, window.rows);
    window.uncompensated = std::isnan(now.uncompensated) ? NOT_KNOWN : deviation(squares.uncompensated, window.rows);
    window.tip = std::isnan(now.tip) ? NOT_KNOWN : deviation(squares.tip, window.rows);
    window.outlet = std::isnan(now.tip) ? NOT_KNOWN : deviation(squares.outlet, window.rows);
    if (std::isnan(now.unit)) window.largest = NOT_KNOWN;
    if (felt > 0.0) window.mean_power /= felt;
    if (window.rows > 0.0) window.at_limit /= window.rows;
}

}  // namespace heave
