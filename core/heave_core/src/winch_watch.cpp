// Whether the winch does what is predicted of it, and takes commands in time, by the numbers that it acknowledges. That
// they have just become late is seen within three ticks, long before the record of the drum shows it; it is news where it
// is more than a hiccup: by the median over some seconds, and by the share of a minute.
#include "watch.h"

namespace heave {

namespace {

// Time by which more than half of the commands of the last seconds were later than modelled, at least. Behind the minute
// there is place for the window.
double overdue_of(const LinkDesign &design, const LinkState &state, double *minute) {
    const int window = std::min(design.window, state.count), half = design.window / 2;
    if (state.late_in_minute == 0 || window <= half) return 0.0;
    double *later = minute + design.minute;
    for (int i = 0; i < window; i++) later[i] = minute[(state.next - 1 - i + design.minute) % design.minute];
    std::nth_element(later, later + half, later + window, [](double a, double b) { return a > b; });
    return later[half];
}

// Puts a command on record.
void note_overdue(const LinkDesign &design, LinkState &state, double *minute, double overdue) {
    if (state.count == design.minute) state.late_in_minute -= minute[state.next] > 0.0;
    minute[state.next] = overdue;
    state.next = (state.next + 1) % design.minute;
    state.count = std::min(state.count + 1, design.minute);
    state.late_in_minute += overdue > 0.0;
    state.known++;
    state.late += overdue > 0.0;
    state.largest = std::max(state.largest, overdue);
}

// What the statistics say that they did not say before.
void judge_link(const LinkDesign &design, LinkState &state, double *minute) {
    const bool was_slow = state.is_slow, was_ragged = state.is_ragged;
    const double share = double(state.late_in_minute) / design.minute;
    state.is_ragged = share > (was_ragged ? 0.5 : 1.0) * design.largest_share;
    state.overdue = overdue_of(design, state, minute);
    state.is_slow = state.overdue > 0.0 && (state.in_a_row > 0 || was_slow);
    state.news = 0;
    if (state.is_slow && !was_slow) state.news = COMMANDS_SLOW;
    else if (state.is_ragged && !was_ragged && !was_slow) state.news = COMMANDS_RAGGED;
}

}  // namespace

// A tick's command: that which was given last, and the newest one in effect at the end of its tick.
void note_command(const LinkDesign &design, LinkState &state, double *minute, int given, int taken, double modelled) {
    const int due = int(std::ceil(modelled / design.tick_period - design.rounding)) - 1, late = given - taken - due - 1;
    const bool is_late = taken > 0 && late > 0;
    state.in_a_row = is_late ? state.in_a_row + 1 : 0;
    state.has_begun = state.in_a_row == design.late_ticks;
    state.without_new = is_late && taken == state.newest ? state.without_new + 1 : 0;
    state.newest = taken;
    state.is_cut = state.without_new * design.tick_period > design.cut_time - 0.5 * design.tick_period;
    if (!state.is_cut) note_overdue(design, state, minute, is_late ? late * design.tick_period : 0.0);
    judge_link(design, state, minute);
}

// Who is silent: the cause of a winch that stops because no command came in time.
void note_silence(const LinkDesign &design, LinkState &state, bool has_state, double untaken) {
    state.since_state += design.tick_period;
    state.since_silence += design.tick_period;
    if (state.since_state >= state.silence || state.since_silence > design.memory) {
        state.silence = state.since_state;
        state.since_silence = 0.0;
    }
    if (has_state) {
        state.since_state = 0.0;
        state.untaken = untaken;
    }
}

void watch_winch(const WinchWatchDesign &design, WinchWatchState &state, const DrumRecord &record, double *minute,
                 const WinchSeen &seen) {
    const bool has_state = seen.has_state != 0.0, is_given = std::isfinite(seen.given);
    const double behind = has_state && is_given ? (seen.given - seen.taken) * design.link.tick_period : 0.0;
    note_silence(design.link, state.link, has_state, behind - design.delay);
    state.link.news = 0;
    if (has_state && is_given) {
        note_command(design.link, state.link, minute, int(seen.given), int(seen.taken), design.modelled);
        if (state.link.has_begun) state.drum.readings = 0;
    }
    state.error = 0.0;
    if (!is_given || seen.brake != 0.0) {
        reset_drum(design.drum, state.drum, record, is_given ? seen.payout : 0.0);
    } else if (has_state && seen.at_end != 0.0) {
        add(design.drum, state.drum, record, {seen.payout, seen.rate, seen.tension, NOT_KNOWN, 0.0});
        state.drum.readings = 0;
    } else {
        add(design.drum, state.drum, record, {seen.payout, seen.rate, seen.tension, seen.reading, seen.is_limited});
        state.error = drum_error(design.drum, state.drum, record);
    }
}

}  // namespace heave
