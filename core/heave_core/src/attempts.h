// Attempts at compensation: see attempts.cpp.
#pragma once

#include "look.h"

namespace heave {

// What the guard and its attempts go by, and what they change.
struct Guarded {
    const GuardDesign &design;
    const AttemptDesign &attempts;
    GuardState &state;
    AttemptState &attempted;
};

double largest_residual(const AttemptDesign &design, const AttemptState &state);
bool awaits_operator(const AttemptDesign &design, const AttemptState &state);
void begin_inhibition(int why, AttemptState &state);
void inhibit(AttemptState &state);
void interrupt_attempt(AttemptState &state);
void explain_attempt(AttemptState &state);
void release_attempts(const Guarded &on);
void judge_attempt(const Guarded &on, Seen seen, bool fades, Verdict &verdict);

}  // namespace heave
