// Whether the drum is off what the last second foresaw, and whether its encoder goes as the winch was ordered.
#include "watch.h"

namespace heave {

namespace {

// The row of so many ticks before the newest.
const DrumRow &row_before(const DrumWatchDesign &design, const DrumWatchState &state, const DrumRecord &record, int ticks) {
    return record.rows[(state.next - 1 - ticks + design.kept) % design.kept];
}

// What was sent in the last ticks, oldest first, at the start of the work's numbers.
SetPoints sent_of(const DrumWatchDesign &design, const DrumWatchState &state, const DrumRecord &record, int ticks) {
    double *payouts = record.work, *rates = payouts + ticks, *late = rates + ticks, *tensions = late + ticks;
    for (int i = 0; i < ticks; i++) {
        const DrumRow &row = row_before(design, state, record, ticks - 1 - i);
        payouts[i] = row.payout;
        rates[i] = row.rate;
        late[i] = 0.0;
        tensions[i] = row.tension;
    }
    return {payouts, rates, late, tensions, ticks};
}

// Sums of two records about their means, where both are known.
struct Products {
    double asked_squares, read_squares, both;
};

Products products_of(const double *asked, const double *read, int ticks) {
    double seen = 0.0, mean_asked = 0.0, mean_read = 0.0;
    for (int i = 0; i < ticks; i++)
        if (std::isfinite(read[i])) {
            seen += 1.0;
            mean_asked += asked[i];
            mean_read += read[i];
        }
    mean_asked /= seen;
    mean_read /= seen;
    Products sums{};
    for (int i = 0; i < ticks; i++) {
        if (!std::isfinite(read[i])) continue;
        const double a = asked[i] - mean_asked, b = read[i] - mean_read;
        sums.asked_squares += a * a;
        sums.read_squares += b * b;
        sums.both += a * b;
    }
    return sums;
}

// Speed that the winch was ordered so many ticks ago and has reached by now.
double rate_before(const DrumWatchDesign &design, const DrumWatchState &state, const DrumRecord &record, int ticks) {
    const int lag = int(std::nearbyint((design.assumed.lag + design.assumed.delay) / design.run.tick_period));
    return row_before(design, state, record, std::min(ticks + lag, state.count - 1)).rate;
}

}  // namespace

void add(const DrumWatchDesign &design, DrumWatchState &state, const DrumRecord &record, const DrumRow &row) {
    record.rows[state.next] = row;
    state.next = (state.next + 1) % design.kept;
    state.count = std::min(state.count + 1, design.kept);
    state.readings = std::min(state.readings + 1, design.kept);
}

// The drum is at rest at a payout.
void reset_drum(const DrumWatchDesign &design, DrumWatchState &state, const DrumRecord &record, double payout) {
    for (int i = 0; i < design.ahead; i++) add(design, state, record, {payout, 0.0, NOT_KNOWN, NOT_KNOWN, 0.0});
    state.readings = 0;
}

// How far the drum is off what was predicted a second ago [m]; 0 where unknown. Payout and rate of then are those that
// explain the second before it best: at a limit an error of the rate stays.
double drum_error(const DrumWatchDesign &design, const DrumWatchState &state, const DrumRecord &record) {
    const int checked = design.checked, needed = checked + design.ahead;
    if (state.readings < checked) return 0.0;
    double *readings = record.work + 4 * needed;
    for (int i = 0; i < checked; i++) {
        readings[i] = row_before(design, state, record, checked - 1 - i).reading;
        if (!std::isfinite(readings[i])) return 0.0;
    }
    ServoRun run = design.run;
    run.sent = needed;
    run.ticks = checked - 1;
    run.fitted = checked / 2;
    const SetPoints sent = sent_of(design, state, record, needed);
    return readings[checked - 1] - servo_reading(run, sent, design.assumed, readings, readings + checked);
}

// What the encoder reads of what a drum was ordered. A slow servo still goes as it was ordered long before: that is known
// from where the readings begin. The share is that of the least squares about the means.
Ordered drum_ordered(const DrumWatchDesign &design, const DrumWatchState &state, const DrumRecord &record, const Servo &drum) {
    const Ordered unknown{NOT_KNOWN, 0.0, 0.0, 0.0};
    const int ticks = design.ordered;
    if (state.readings <= ticks) return unknown;
    int seen = 0;
    bool is_limited = false;
    for (int i = 0; i <= ticks; i++) {
        const DrumRow &row = row_before(design, state, record, i);
        seen += std::isfinite(row.reading);
        is_limited |= row.is_limited > 0.0;
    }
    const double first = row_before(design, state, record, ticks).reading;
    if (!std::isfinite(first) || seen < design.least_seen * ticks) return unknown;
    const double decay = std::ceil(design.settled * drum.lag / design.run.tick_period);
    const int before = int(std::min(decay, double(state.readings - ticks - 1))), all = before + ticks;
    double begin = row_before(design, state, record, all).reading;
    if (!std::isfinite(begin)) begin = first;
    const int needed = std::min(all + 1 + design.ahead, state.count);
    const SetPoints sent = sent_of(design, state, record, needed);
    double *path = record.work + 4 * needed, *readings = path + all;
    servo_record(design.run, sent, drum, {begin, rate_before(design, state, record, all)}, all, path);
    for (int i = 0; i < ticks; i++) readings[i] = row_before(design, state, record, ticks - 1 - i).reading;
    const Products sums = products_of(path + before, readings, ticks);
    const int compared = seen - 1;
    if (std::min(sums.asked_squares, sums.read_squares) < design.least_motion * design.least_motion * compared) return unknown;
    const double share = sums.both / sums.asked_squares;
    const double left = std::max(sums.read_squares - share * share * sums.asked_squares, 0.0);
    const double travel = path[all - 1] - (before > 0 ? path[before - 1] : begin);
    return {share, std::sqrt(left / sums.read_squares), first + travel, double(is_limited)};
}

}  // namespace heave
