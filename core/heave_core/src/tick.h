// A tick of the controller as a whole: see tick.cpp.
#pragma once

#include "act.h"
#include "proofs.h"
#include "supervise.h"

namespace heave {

// What a tick works on. Python fills the addresses once, in this order; a part that it makes anew, again.
struct Control {
    const Given *given;
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
    Controlled *done;
    Supervising supervising;
    Acting acting;
};

int control(const Control &on, int from);

}  // namespace heave
