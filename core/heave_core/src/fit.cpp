// A sensor's record compared with what is expected of it: low-passed alike, and fitted by least squares.
#include "filter.h"
#include "proofs.h"

namespace heave {

namespace {

constexpr double ROUNDING = 1e-12;  // a share that is no motion

// The mean of the first `count` until its memory is full: the first sample alone would stand out by its noise.
double low_passed(const ProofDesign &design, double since, int count, double before, double value) {
    return count ? value + std::min(std::exp(-since / design.low_pass), count / (count + 1.0)) * (before - value) : value;
}

// Place in a ring of `size` of one of the `count` that it holds, 0 the oldest.
int place(int next, int count, int size, int index) { return (next - count + index + size) % size; }

int newest(const WitnessRecord &record, int size) { return place(record.next, 1, size, 0); }

// Adds `weight` of the samples of a witness at the times of what is expected, interpolated, and held beyond their ends.
void interpolate(const ProofDesign &design, const Expected &expected, const WitnessRecord &read, double weight,
                 double *values) {
    const int size = 2 * design.kept, count = expected.count;
    const auto at = [&](int index) { return place(read.next, read.count, size, index); };
    for (int i = 0, before = 0; i < count; i++) {
        const double time = expected.times[place(expected.next, count, design.kept, i)];
        while (before + 2 < read.count && read.times[at(before + 1)] <= time) before++;
        const int here = at(before), next = at(before + 1);
        const double share = clip((time - read.times[here]) / (read.times[next] - read.times[here]), 0.0, 1.0);
        values[i] += weight * (read.values[here] + share * (read.values[next] - read.values[here]));
    }
}

// Takes out of `values` what they share with columns that are orthonormal.
void take_out(int count, const double (*columns)[PROOF_TICKS], int columns_count, double *values) {
    for (int k = 0; k < columns_count; k++) add(count, -dot(count, columns[k], values), columns[k], values);
}

// Makes the size of `values` 1, and returns what it was; values that are rounding alone become 0.
double normalise(int count, double smallest, double *values) {
    const double size = std::sqrt(dot(count, values, values));
    for (int i = 0; i < count; i++) values[i] = size > smallest ? values[i] / size : 0.0;
    return size > smallest ? size : 0.0;
}

}  // namespace

// Offset, trend and free swing, made orthonormal; columns that say nothing new are 0.
void lay_beside(const ProofDesign &design, int count, ProofWork &work) {
    const double step = design.tick_period, mean = 0.5 * (count - 1) * step;
    for (int i = 0; i < count; i++) {
        const double t = step * i, turned = design.frequency * t;
        work.beside[0][i] = 1.0;
        work.beside[1][i] = t - mean;
        work.beside[2][i] = std::cos(turned);
        work.beside[3][i] = std::sin(turned);
    }
    for (int k = 0; k < BESIDE; k++) {
        const double smallest = ROUNDING * std::sqrt(dot(count, work.beside[k], work.beside[k]));
        take_out(count, work.beside, k, work.beside[k]);
        normalise(count, smallest, work.beside[k]);
    }
}

// Takes in a sample of a witness: a number, later than the last one.
void add(const ProofDesign &design, WitnessRecord &record, double time, double value) {
    const int size = 2 * design.kept, last = newest(record, size);
    const double since = record.count ? time - record.times[last] : INFINITE;
    if (!(std::isfinite(time + value) && since > 0.0)) return;
    record.times[record.next] = time;
    record.values[record.next] = low_passed(design, since, record.count, record.values[last], value);
    record.next = (record.next + 1) % size;
    record.count = std::min(record.count + 1, size);
}

// Takes in what the witnesses should read at a time; returns whether it counts.
bool add(const ProofDesign &design, Expected &expected, double time, double heave, const double *values) {
    const int last = place(expected.next, 1, design.kept, 0);
    const double since = expected.count ? time - expected.times[last] : INFINITE;
    if (!(std::isfinite(time + values[0]) && since > 0.0)) return false;
    for (int witness = 0; witness < WITNESSES; witness++) {
        double *held = expected.values[witness];
        held[expected.next] = low_passed(design, since, expected.count, held[last], values[witness]);
    }
    expected.times[expected.next] = time;
    expected.heaves[expected.next] = heave;
    expected.next = (expected.next + 1) % design.kept;
    expected.count = std::min(expected.count + 1, design.kept);
    return true;
}

double spread_of_heave(const ProofDesign &design, const Expected &expected) {
    double sum = 0.0, squares = 0.0;
    const auto at = [&](int i) { return expected.heaves[place(expected.next, expected.count, design.kept, i)]; };
    for (int i = 0; i < expected.count; i++) sum += at(i);
    for (int i = 0; i < expected.count; i++) squares += (at(i) - sum / expected.count) * (at(i) - sum / expected.count);
    return std::sqrt(squares / expected.count);
}

// Whether a witness has read over all of what is expected.
bool reaches(const ProofDesign &design, const Expected &expected, const WitnessRecord &read) {
    if (read.count < 2) return false;
    const int size = 2 * design.kept;
    const double first = expected.times[place(expected.next, expected.count, design.kept, 0)];
    const double last = expected.times[place(expected.next, 1, design.kept, 0)];
    return read.times[place(read.next, read.count, size, 0)] <= first + design.unread &&
           read.times[newest(read, size)] >= last - design.unread;
}

// Fit of what witnesses have read on what they should have, each in the sum of its weights, beside as many of offset, trend
// and the two phases of a free swing. The standard error is that of n (1 - r)/(1 + r) independent samples, r the residual's
// correlation from one sample to the next (Bayley and Hammersley 1946, for a first-order process).
Fit fitted(const ProofDesign &design, const ProofState &state, const Sum &expected, const Sum &read, int beside,
           ProofWork &work) {
    const int n = state.expected.count;
    double *x = work.expected, *y = work.read;
    std::fill_n(x, n, 0.0);
    std::fill_n(y, n, 0.0);
    for (int witness = 0; witness < WITNESSES; witness++) {
        if (expected[witness] == 0.0) continue;
        const double *values = state.expected.values[witness];
        for (int i = 0; i < n; i++) x[i] += expected[witness] * values[place(state.expected.next, n, design.kept, i)];
        interpolate(design, state.expected, state.read[witness], read[witness], y);
    }
    const double smallest_x = ROUNDING * std::sqrt(dot(n, x, x)), smallest_y = ROUNDING * std::sqrt(dot(n, y, y));
    take_out(n, work.beside, beside, x);
    take_out(n, work.beside, beside, y);
    const double x_size = normalise(n, smallest_x, x), y_size = normalise(n, smallest_y, y);
    if (x_size == 0.0 || y_size == 0.0) return {};
    const double correlation = dot(n, x, y), scale = correlation * y_size / x_size;
    add(n, -correlation, x, y);
    const double squares = dot(n, y, y);
    if (squares <= 1e-18) return {scale, std::copysign(1.0, correlation), std::copysign(INFINITE, correlation), 1.0};
    const double memory = std::max(dot(n - 1, y + 1, y) / squares, 0.0);
    const double independent = std::max(n * (1.0 - memory) / (1.0 + memory), 1.0);
    const double left = std::max(independent - beside - 1.0, 1.0) / independent;
    return {scale, correlation, correlation / std::sqrt(squares / independent), left};
}

}  // namespace heave
