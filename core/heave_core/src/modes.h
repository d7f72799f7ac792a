// The mode machine: see modes.cpp.
#pragma once

#include "parts.h"

namespace heave {

int step_modes(const ModeDesign &design, const Situation &situation, ModeState &state);
bool may_resume(const ModeDesign &design, const Situation &situation, const ModeState &state);
int missing_guards(const ModeDesign &design, const Situation &situation, int event, const ModeState &state);
bool request_mode(const ModeDesign &design, const Situation &situation, int event, ModeState &state);
bool take_event(const ModeDesign &design, const Situation &situation, int event, ModeState &state);
bool goes_on_blind(const Situation &situation, const ModeState &state);
bool is_braked(const ModeState &state);

}  // namespace heave
