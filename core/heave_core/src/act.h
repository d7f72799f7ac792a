// From what is to be done to the order that leaves: see act.cpp.
#pragma once

#include "laws.h"
#include "look.h"
#include "watch.h"

namespace heave {

// What a tick acts on. Python fills the addresses once, in this order.
struct Acting {
    ActSeen *seen;
    const Motions *motions;
    const ActiveWinch *winch;
    const CommandDesign *design;
    Loop *loop;
    const Law *law;
    Problem *problem;
    LawState *law_state;
    CommandState *state;
    Command *command;
    const double *A, *B;  // model of the loop: x' = A x + B u
    MeanMotion *motion;
    const Design *envelope;  // null: it is not active
    State *envelope_state;
    Readings *readings;
    Order *order;
    Place *place;
    const LoadWatchDesign *load;
    LoadWatchState *load_state;
    const KpiDesign *kpi;
    KpiState *kpi_state;
    KpiRow *kpi_rows;  // null: not kept
    ActDone *done;
};

// act.cpp
int answer(const Acting &on);
void pose(const Acting &on);
void make(const Acting &on);
void leave(const Acting &on);
double place_at_end(Place &place, double tick_period, double rate, double payout, bool is_braked);

}  // namespace heave
