// What failed attempts at compensation say of the next. One that fails shows that the model is not all: errors of unknown
// cause leave as much again of what is compensated. One that the winch ends for want of commands leaves a swing, and so
// lowers the motion that may remain. What compensation then does well in the waves takes both back.
#include "attempts.h"

namespace heave {

namespace {

void fail(int why, int harm, AttemptState &state) {
    begin_inhibition(why, state);
    state.harm = harm;
    state.doubt_before = state.doubt;
    state.doubt += 1.0;
}

// A disagreement in this tick is the reason until it is known who is wrong.
void disagree(AttemptState &state) {
    state.is_present = 1;
    if (state.inhibits) return;
    fail(HARM_UNEXPLAINED, DISAGREE, state);
    state.is_unexplained = 1;
}

// Errors leave no more than `measured` of compensated motion, over that motion.
void learn(double measured, double share, AttemptState &state) {
    state.doubt += share * (std::min(measured, state.doubt) - state.doubt);
    state.doubt_before = std::min(state.doubt_before, state.doubt);
    state.interruptions *= 1.0 - share;
}

// Takes in a tick that inhibits; returns whether compensation may be tried again from now on.
bool ends(const AttemptDesign &design, double residual, bool is_off, AttemptState &state) {
    const bool was_present = state.is_present;
    state.is_present = 0;
    if (!is_off || was_present || awaits_operator(design, state) || residual > largest_residual(design, state)) return false;
    state.inhibits = 0;
    state.why = NOT_OFF;
    return true;
}

}  // namespace

// Largest residual with which compensation is tried, over the motion with the winch locked.
double largest_residual(const AttemptDesign &design, const AttemptState &state) {
    return design.largest_residual - design.interruption * state.interruptions;
}

// No authority would gain enough any more: the residual of the best one is sqrt(d/(1 + d)) of a doubt d.
bool awaits_operator(const AttemptDesign &design, const AttemptState &state) {
    const double bar = largest_residual(design, state);
    return state.doubt / (1.0 + state.doubt) > square(std::max(bar, 0.0)) || bar <= 0.0;
}

void begin_inhibition(int why, AttemptState &state) {
    state.inhibits = 1;
    state.why = why;
    state.is_unexplained = 0;
    state.begun++;
}

// Keeps compensation off for a reason that is certain in this tick, and that no attempt has brought about.
void inhibit(AttemptState &state) {
    state.is_present = 1;
    if (!state.inhibits || state.is_unexplained) begin_inhibition(HARM_CERTAIN, state);
}

void interrupt_attempt(AttemptState &state) { state.interruptions += 1.0; }

// Takes the last failure back: a wrong belief has just been corrected.
void explain_attempt(AttemptState &state) {
    state.doubt = std::min(state.doubt, state.doubt_before);
    if (state.inhibits && state.is_unexplained) begin_inhibition(HARM_EXPLAINED, state);
}

// Compensation may be tried as at first: an operator asks for it.
void release_attempts(const Guarded &on) {
    AttemptState &state = on.attempted;
    if (awaits_operator(on.attempts, state)) {
        if (state.inhibits) {
            state.distrusts = 0;
            restart_waves(on.state);
        }
        state.inhibits = 0;
        state.why = NOT_OFF;
    }
    state.doubt = state.doubt_before = state.interruptions = 0.0;
}

// The guard of a tick, with what it means for this attempt and the next. `fades`: the winch comes to rest after it.
void judge_attempt(const Guarded &on, Seen seen, bool fades, Verdict &verdict) {
    AttemptState &state = on.attempted;
    seen.unknown += state.doubt;
    seen.inhibits = state.inhibits;
    guard(on.design, on.state, seen, verdict);
    const int bits = int(verdict.bits);
    if (bits & DISAGREE) {
        state.distrusts = 1;
        disagree(state);
    }
    if (state.inhibits) {
        if (!ends(on.attempts, verdict.residual, seen.authority <= 0.0 && !fades, state)) return;
        state.distrusts = 0;
        restart_waves(on.state);
    } else if (seen.authority > 0.0) {
        if (bits & DEPTH_HIGH) state.distrusts = 1;
        if (bits) fail(HARM_DONE, bits, state);
        else if (verdict.measured >= 0.0) learn(verdict.measured, on.attempts.learnt, state);
    }
}

}  // namespace heave
