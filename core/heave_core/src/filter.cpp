// The Kalman filter over ticks: gates, and late readings, each taken in at its own tick and followed up to the present.
#include "filter.h"

#include <cstring>

namespace heave {

namespace {

int place_of(const Filter &filter, int tick) {
    const int place = tick % filter.kept;
    return place < 0 ? place + filter.kept : place;
}

// Where the prediction for a tick is kept: x, then the lower triangle of P.
double *past_of(const Filter &filter, FilterState &state, int place) {
    const int n = filter.states;
    return state.past + place * (n + n * (n + 1) / 2);
}

// Where the readings used of a tick are kept.
Reading *used_of(const Filter &filter, FilterState &state, int place) {
    return state.used + place * (USED / filter.kept);
}

void keep(const Filter &filter, FilterState &state, int place) {
    const int n = filter.states;
    double *to = past_of(filter, state, place);
    std::memcpy(to, state.x, sizeof(double) * n);
    to += n;
    for (int i = 0; i < n; to += ++i) std::memcpy(to, state.P + i * n, sizeof(double) * (i + 1));
}

void go_back(const Filter &filter, FilterState &state, int place) {
    const int n = filter.states;
    const double *from = past_of(filter, state, place);
    std::memcpy(state.x, from, sizeof(double) * n);
    from += n;
    for (int i = 0; i < n; from += ++i)
        for (int j = 0; j <= i; j++) state.P[i * n + j] = state.P[j * n + i] = from[j];
}

// Begin a tick with the prediction for it; the oldest one goes.
void begin_tick(const Filter &filter, FilterState &state, int tick) {
    const int place = place_of(filter, tick);
    keep(filter, state, place);
    state.counts[place] = 0;
    state.newest = tick;
    state.held = std::min(state.held + 1, filter.kept);
}

// Hold a reading against its prediction; return whether it may be used. One that goes on where the last one used was says
// something of the model, not of the sensor: a step of two innovations, of twice the variance, or of no more than half of
// what it is off. That many refused in a row are the filter's fault, whose covariance must be large enough to come back.
bool judged(const Filter &filter, FilterState &state, const Reading &reading, Said &said) {
    const int n = filter.states, which = int(reading.which);
    double row[STATES], carried[STATES];
    const double innovation = reading.value - linearised(filter, reading, state.x, row);
    const double variance = across(n, row, state.P, carried) + reading.variance;
    const double nis = innovation * innovation / variance, step = innovation - state.streams[which];
    const bool is_stream = step * step <= std::max(filter.stream_factor * filter.gate * variance, 0.25 * innovation * innovation);
    const bool accepted = nis <= filter.gate || ((is_stream || !filter.is_gated[which]) && std::isfinite(nis));
    said = {innovation, std::sqrt(variance), nis, accepted ? 1.0 : 0.0};
    state.refusals[which] = accepted ? 0 : state.refusals[which] + 1;
    const bool is_lost = state.refusals[which] > filter.gate_limit && std::isfinite(nis);
    if (is_lost) {
        for (int i = 0; i < n * n; i++) state.P[i] += filter.added[i];
        state.refusals[which] = 0;
    }
    if (accepted || is_lost) state.streams[which] = innovation;
    return accepted || is_lost;
}

// Judge readings of a tick, and note those that are used; one for which there is no place is refused.
void note(const Filter &filter, FilterState &state, int place, const Reading *readings, int count, Said *said) {
    for (int i = 0; i < count; i++) {
        if (state.counts[place] == USED / filter.kept) {
            said[i] = {NOT_KNOWN, NOT_KNOWN, NOT_KNOWN, 0.0};
            continue;
        }
        Reading &reading = used_of(filter, state, place)[state.counts[place]];
        reading = readings[i];
        // the stretch says nothing of the pull of a slack cable: it errs by as much as that is slack
        const double error = filter.slack.reads[int(reading.which)] * missing_push(filter.slack, filter.states, state.x);
        reading.variance += error * error;
        if (judged(filter, state, reading, said[i])) state.counts[place]++;
    }
}

// Take in readings of one tick: go back to it, and follow up to the present with everything that was known.
void take_at(const Filter &filter, FilterState &state, const Step &step, const Reading *readings, int count, Said *said) {
    const int tick = int(readings[0].tick), place = place_of(filter, tick), before = state.counts[place];
    if (state.newest - tick >= state.held) {
        for (int i = 0; i < count; i++) said[i] = {NOT_KNOWN, NOT_KNOWN, NOT_KNOWN, 0.0};
        return;
    }
    const Reading *used = used_of(filter, state, place);
    if (tick < state.newest) {
        go_back(filter, state, place);
        take(filter, used, before, state.x, state.P);
    }
    note(filter, state, place, readings, count, said);
    take(filter, used + before, state.counts[place] - before, state.x, state.P);
    for (int later = tick + 1; later <= state.newest; later++) {
        const int next = place_of(filter, later);
        predict(filter.states, step, state.commands[place_of(filter, later - 1)], state.x, state.P);
        keep(filter, state, next);
        take(filter, used_of(filter, state, next), state.counts[next], state.x, state.P);
    }
}

// Go on to a tick, and take in what was delivered at it, sorted by its own ticks.
void advance(const Filter &filter, FilterState &state, int tick, double command, const Reading *readings, int count,
             Said *said) {
    Step step;
    set_step(filter, state.x, step);
    if (state.held == 0) begin_tick(filter, state, tick);
    for (int next = state.newest + 1; next <= tick; next++) {
        state.commands[place_of(filter, next - 1)] = command;
        predict(filter.states, step, command, state.x, state.P);
        begin_tick(filter, state, next);
    }
    for (int first = 0, end; first < count; first = end) {
        for (end = first + 1; end < count && readings[end].tick == readings[first].tick;) end++;
        take_at(filter, state, step, readings + first, end - first, said + first);
    }
}

}  // namespace

// Begin: the estimate is 0, as uncertain as where the filter is lost; nothing was read.
void begin_filter(const Filter &filter, FilterState &state) {
    const int n = filter.states;
    state.held = state.newest = 0;
    state.missing_push = 0.0;
    std::fill_n(state.x, n, 0.0);
    std::memcpy(state.P, filter.added, sizeof(double) * n * n);
    std::fill_n(state.streams, filter.measurements, NOT_KNOWN);
    std::fill_n(state.refusals, filter.measurements, 0);
}

// Go through a run of ticks with their readings; leave what each reading said.
void run_filter(const Filter &filter, FilterState &state, const FilterTick *ticks, int count, const Reading *readings,
                Said *said) {
    for (int i = 0, first = 0; i < count; i++) {
        const int end = int(ticks[i].end);
        advance(filter, state, int(ticks[i].tick), ticks[i].command, readings + first, end - first, said + first);
        first = end;
    }
    state.missing_push = missing_push(filter.slack, filter.states, state.x);
}

}  // namespace heave
