// What a tick does with the estimate: simulated units, motions, the guard's statistics. See look_table.py.
#pragma once

#include "filter.h"

namespace heave {

inline double square(double value) { return value * value; }

// A motion, positive up.
struct Motion {
    double heave, rate;  // [m], [m/s]
};

// unit.cpp: a unit below an outlet whose motion is known
Motion motion_of(const HangingCable &cable, const HangingUnit &unit);
void continue_at(const HangingCable &cable, HangingUnit &unit, const Motion &motion);
void advance_unit(const HangingCable &cable, HangingUnit &unit, const Motion &outlet);

// look.cpp: all motions at a tick
struct LoopStates {
    const double *x, *mean, *P;  // estimate, state by the mean payout alone, covariance of the estimate
};
void look(const LookDesign &design, LookState &state, const LookInputs &inputs, const LoopStates &loop, Motions &motions);
void find_motions(const LookDesign &design, const LookState &state, const LookInputs &inputs, const LoopStates &loop,
                  Motions &motions);
void begin_share(const LookDesign &design, LookState &state);
void continue_shadow(const LookDesign &design, LookState &state, const Motion &motion);
void take_unit(const LookDesign &design, LookState &state, const Motion &motion);

// statistics.cpp: running statistics, and the check of one amplitude against another
void add(RunningSigma &sigma, double value, double weight, double slow_mean);
void add(AmplitudeCheck &check, double square, double reference, double weight, double wave_weight);
void add(DetrendedHeave &heave, const GuardDesign &design, double reading, double noise);
double reference_of(const AmplitudeCheck &check);
double amplitude_of(const AmplitudeCheck &check);
bool is_exceeded(const AmplitudeCheck &check, const AmplitudeLimit &limit, double seen_ticks);

// demand.cpp: what the sea asks of the winch
void observe_sea(const GuardDesign &design, WinchDemand &demand, double tip_rate);
void judge_demand(const GuardDesign &design, const WinchDemand &demand, Verdict &verdict);

// authority.cpp: the residual that is predicted
void note_drum(const GuardDesign &design, GuardState &state, const Seen &seen);
void note_left(const GuardDesign &design, GuardState &state, const Seen &seen);
void show_authority(const GuardDesign &design, const Seen &seen, Verdict &verdict);
void predict_residual(const GuardDesign &design, const GuardState &state, const Seen &seen, Verdict &verdict);
double measured_residual(const Seen &seen, const Verdict &verdict);

// guard.cpp: whether compensation does harm
void guard(const GuardDesign &design, GuardState &state, const Seen &seen, Verdict &verdict);
void begin_guard(GuardState &state);
void restart_waves(GuardState &state);
void allow_catch_up(const GuardDesign &design, GuardState &state);
void allow_resumption(const GuardDesign &design, GuardState &state);
void reset_mismatch(GuardState &state);

}  // namespace heave
