// Supervision of a tick: see supervise.cpp.
#pragma once

#include "attempts.h"
#include "modes.h"
#include "sense.h"
#include "watch.h"

namespace heave {

// What supervision works on. Python fills the addresses once, in this order.
struct Supervising {
    const SenseDesign *sense;
    const SenseState *sense_state;
    const Tick *tick;
    const SupervisionDesign *design;
    SupervisionState *state;
    SupervisionSeen *seen;
    Supervised *done;
    const LandingDesign *landing;
    LandingState *landing_state;
    const GuardDesign *guard;
    GuardState *guard_state;
    Verdict *verdict;
    const AttemptDesign *attempt_design;
    AttemptState *attempts;
    const ModeDesign *modes;
    ModeState *mode;
    Situation *situation;
};

// standing_load.cpp: the load while the winch stands
bool hangs(const LandingState &state);
bool shows_hanging(const LandingState &state);
void begin_standing_load(SupervisionState &state);
void watch_standing_load(const Supervising &on, const double *depths, bool is_cell_lost, bool is_encoder_lost, int &happened);
int load_gates(const Supervising &on);

// start_gates.cpp: what keeps compensation and constant tension from beginning, and a tension that is too low for the sea
int compensation_gates(const Supervising &on);
int tension_gates(const Supervising &on, bool is_cell_lost);
void begin_highest_tension(SupervisionState &state);
void watch_highest_tension(const Supervising &on, int &happened);

// supervise.cpp
void begin_supervision(SupervisionState &state);
void supervise(const Supervising &on, const double *depths);

}  // namespace heave
