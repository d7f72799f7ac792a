// A tick of the controller as a whole: see tick.cpp.
#pragma once

#include "act.h"
#include "proofs.h"
#include "supervise.h"

namespace heave {

// What a tick works on. Python fills the addresses once, in this order; a part that it makes anew, again.
struct Control {
    Given *given;
    const Active *active;
    const Delivered *delivered;
    const SenseDesign *sense;
    const Filter *filter;
    const LookDesign *look;
    SenseState *sense_state;
    FilterState *filter_state;
    LookState *look_state;
    Observed *found, *observed;
    Reading *taken;
    Said *said, *by_measurement;
    double *depths;
    Tick *tick;
    const ProofDesign *proofs;
    ProofState *proof_state;
    ProofWork *proof_work;
    const WinchWatchDesign *winch_watch;
    WinchWatchState *winch_state;
    DrumRow *drum_rows;
    double *drum_work, *minute;
    const ReflexDesign *reflex;
    ReflexState *reflex_state;
    Controlled *done;
    Supervising supervising;
    Acting acting;
};

// encoder_reflex.cpp: what an encoder reads of what the winch was ordered; a look; what is found before a tick
bool is_count_refuted(const ReflexState &state);
bool reads_reversed(const ReflexDesign &design, const Ordered &ordered, bool was);
bool reads_suddenly(const ReflexDesign &design, const Ordered &ordered, bool was);
bool reads_the_right_way(const ReflexDesign &design, const Ordered &ordered);
bool reads_true(const ReflexDesign &design, const Ordered &ordered);
int look_at_encoder(const ReflexDesign &design, ReflexState &state, int tick, const Ordered &ordered, bool is_aside);
void compare_count(ReflexState &state);
int watch_encoder(const Control &on);

// tick.cpp
int control(const Control &on, int from);

}  // namespace heave
