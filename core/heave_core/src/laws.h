// From estimate to order: governor, laws and command, each a function of the structures of the laws' table.
#pragma once

#include "filter.h"

namespace heave {

// Inputs of the governor: command [m/s], of a first-order winch a payout [m]; the drum when it takes effect [m], [m/s]; the
// tension expected [N]; speeds that a fade-out may have, NaN: any [m/s]; set-points that the envelope lets pass [m/s], of a
// first-order winch about the drum [m].
struct Wanted {
    double command, payout, rate, tension, least, most, lowest, highest;
};

// governor.cpp: what the winch can do
double speed_under(const ActiveWinch &winch, double tension);
double gain_at(const ActiveWinch &winch, double speed);
double speed_by(const ActiveWinch &winch, double set_point);
Governed govern(const ActiveWinch &winch, const Wanted &wanted);

// laws.cpp
void bound_plan(const ActiveWinch &winch, const Law &law, const Problem &problem, LawState &state);
void ask_law(const ActiveWinch &winch, const Law &law, const Problem &problem, LawState &state);
void follow_plan(const ActiveWinch &winch, const Law &law, const Problem &problem, LawState &state);
void restart_law(LawState &state);

// command.cpp: the order of a tick
struct Commanded {  // what a command stands on
    const ActiveWinch &winch;
    const CommandDesign &design;
    const Loop &loop;
};
void pose_problem(const Commanded &on, Problem &problem, Command &command);
int ask_command(const Commanded &on, const Law &law, const Problem &problem, LawState &law_state, CommandState &state,
                Command &command);
void make_command(const Commanded &on, const Problem &problem, CommandState &state, Command &command);

// A rate command in two parts: what follows the boom tip, and what corrects the tension [m/s].
struct TensionRate {
    double tip, correction;
};

// tension.cpp: constant tension
void note_tension(TensionRecord &record, double tension, double payout);
double read_tip(const TensionAlone &alone, const TensionRecord &record);
void begin_alone(const double *x, const TensionRecord &record, TensionAlone &alone);
double follow_tip(const TensionRecord &record, TensionAlone &alone);
TensionRate lead_alone(const TensionRecord &record, double set_point, double largest, bool unit_stands, TensionAlone &alone);
int ask_tension(const Commanded &on, const Problem &problem, TensionState &state, Command &command);

// motion.cpp: the mean payout
bool advance_mean(MeanPayout &mean);
int ticks_to_go(MeanPayout mean, int longest);
void advance_state(const double *A, const double *B, int states, double command, double *state);
int advance_motion(const double *A, const double *B, int states, double command, bool is_braked, MeanMotion &motion);

}  // namespace heave
