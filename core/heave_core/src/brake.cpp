// A braked drum by the raw load cell: wire that is paid out takes tension off at once, the stiffness of the cable times its
// length, before the unit has followed. By the count the envelope finds it. The count must go by the speed that the drive
// states with it, by the drive's clock.
#include "proofs.h"

namespace heave {

namespace {

void forget_fall(ProofState &state) {
    state.rest_count = state.slack = 0.0;
    state.falls = 0;
}

// Another drum, or another load beside it: how the tension fell without a cause says nothing of it.
void begin_anew(ProofState &state) {
    forget_fall(state);
    state.square = state.seen = 0.0;
}

double mean(const double *values, int count) {
    double sum = 0.0;
    for (int i = 0; i < count; i++) sum += values[i];
    return sum / count;
}

// Takes a tension in beside the nominal load; returns whether wire must have been paid out.
bool falls(const ProofDesign &design, double tension, double stretch, ProofState &state) {
    const double dt = design.tick_period;
    const int held = 2 * design.fall_ticks;
    state.slack = tension < design.slack_share * design.static_tension ? design.slack_time : std::max(state.slack - dt, 0.0);
    if (state.rest_count < held) state.rest_count += 1.0;
    else std::copy(state.rest + 1, state.rest + held, state.rest);
    state.rest[int(state.rest_count) - 1] = tension - design.stiffness * stretch;
    if (state.rest_count < held) return false;
    state.fall = mean(state.rest, design.fall_ticks) - mean(state.rest + held - 2, 2);
    const double largest = design.stiffness * design.felt + design.spreads * std::sqrt(state.square);
    const bool is_falling = state.seen > 0.25 * design.fall_window && state.slack == 0.0 && state.fall > largest;
    if (!is_falling) {
        const double weight = std::max(dt / design.fall_window, dt / (state.seen + dt));
        state.square += weight * (state.fall * state.fall - state.square);
        state.seen += dt;
    }
    state.falls = is_falling ? state.falls + 1 : 0;
    return state.falls > 1;
}

// Whether something holds a drum that was found to move, once that is known.
int follow(const ProofDesign &design, double rate, ProofState &state) {
    const double before = state.since;
    state.since += design.tick_period;
    if (!(before < design.held_time && design.held_time <= state.since)) return 0;
    state.moved = state.count - state.begin;
    state.moved_rate = rate;
    if (state.is_falling && !(std::abs(state.moved) >= design.felt)) return 0;  // no count tells whether it is held
    return std::abs(rate) < design.standing_speed ? DRUM_IS_HELD : DRUM_IS_NOT_HELD;
}

}  // namespace

// An operator knows of it.
void acknowledge_brake(ProofState &state) {
    state.is_falling = 0;
    state.since = NOT_KNOWN;
    forget_fall(state);
}

// A tick, with the newest tension of a load that hangs, NaN where there is none.
int watch_braked(const ProofDesign &design, const ProofSeen &seen, double tension, ProofState &state) {
    const bool is_braked = seen.is_braked != 0.0;
    state.watched_time = is_braked ? state.watched_time + design.tick_period : 0.0;
    const double before = state.count;
    state.count = seen.has_winch != 0.0 ? seen.encoder : NOT_KNOWN;
    if (!is_braked || seen.has_mru != state.had_mru) begin_anew(state);
    state.had_mru = seen.has_mru;
    if (!is_braked) {
        state.since = state.begin = NOT_KNOWN;
        return 0;
    }
    if (std::isnan(state.begin)) state.begin = state.count;
    if (seen.hangs == 0.0) forget_fall(state);
    const double shown = seen.has_mru != 0.0 ? state.load.heave - state.load.unit : 0.0;
    const double stretch = std::max(shown, -design.static_tension / design.stiffness);
    const bool is_plausible = std::abs(tension) <= design.largest_load * design.static_tension;
    const bool has_fallen = state.watched_time > design.settled && is_plausible && falls(design, tension, stretch, state);
    if (!std::isnan(state.since)) return follow(design, (state.count - before) / design.tick_period, state);
    if (seen.runs != 0.0) {
        state.since = 0.0;
        return 0;
    }
    if (!has_fallen) return 0;
    state.since = 0.0;
    state.is_falling = 1;
    return LOAD_FALLS;
}

// Compares the count with the speed stated beside it; a drive that states none (0 or NaN for ever) is no cross-check. A speed
// that is the mean of the interval and one that holds at its end are both taken.
int check_count(const ProofDesign &design, const ProofSeen &seen, ProofState &state) {
    const double before = state.drive_time, count = state.drive_count, last = state.drive_rate, rate = seen.encoder_rate;
    if (seen.has_winch == 0.0 || !std::isfinite(seen.winch_time + seen.encoder)) return 0;
    state.drive_time = seen.winch_time;
    state.drive_count = seen.encoder;
    state.drive_rate = rate;
    if (std::isfinite(rate) && rate != 0.0) state.has_rate = 1;
    const double since = seen.winch_time - before, step = seen.encoder - count;
    if (!state.has_rate || !std::isfinite(rate + last) || !(since > 0.0)) return 0;
    const double left = std::exp(-since / design.count_time), by_speed = 0.5 * (rate + last) * since, at_end = rate * since;
    state.error = left * state.error + step - clip(step, std::min(at_end, by_speed), std::max(at_end, by_speed));
    state.way = left * state.way + std::max(std::abs(step), std::abs(by_speed));
    if (std::abs(state.error) <= design.off_course + design.share_off * state.way) return 0;
    state.found_error = state.error;
    state.error = 0.0;
    return COUNT_CONTRADICTS;
}

}  // namespace heave
