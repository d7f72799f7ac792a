// Proofs before the brake opens: see proofs.cpp, fit.cpp and brake.cpp.
#pragma once

#include "watch.h"

namespace heave {

// One signal on another: slope of the least squares, correlation of what is left of both, slope over its standard error.
struct Fit {
    double scale, correlation, certainty, left;  // left: share of the independent samples that were not needed for the fit
};

// fit.cpp: what a witness has read, and how it fits what it should have
void add(const ProofDesign &design, WitnessRecord &record, double time, double value);
bool add(const ProofDesign &design, Expected &expected, double time, double heave, const double *values);
double spread_of_heave(const ProofDesign &design, const Expected &expected);
bool reaches(const ProofDesign &design, const Expected &expected, const WitnessRecord &read);
void lay_beside(const ProofDesign &design, int count, ProofWork &work);
using Sum = double[WITNESSES];  // weights of the witnesses in a sum
Fit fitted(const ProofDesign &design, const ProofState &state, const Sum &expected, const Sum &read, int beside,
           ProofWork &work);

// What the proofs see of a tick, beside its readings.
struct ProofSeen {
    double latest;  // stamp up to which a reading can be [s]
    double has_winch, winch_time, encoder, encoder_rate;  // the drive has reported: by its clock [s], count, its speed [m], [m/s]
    double is_braked;  // the last order has the brake on, or there was none
    double waits, hangs, has_mru;  // compensation is to begin; the unit hangs; the MRU is neither lost nor excluded
    double runs, has_swung;  // the envelope has found that the braked drum runs, that compensation swings the load higher
};

// brake.cpp: the braked drum by the load cell, and the count by its stated speed; they return bits of ProofNews
int watch_braked(const ProofDesign &design, const ProofSeen &seen, double tension, ProofState &state);
int check_count(const ProofDesign &design, const ProofSeen &seen, ProofState &state);
void acknowledge_brake(ProofState &state);

// proofs.cpp
void begin_proofs(const ProofDesign &design, ProofState &state);
int prove(const ProofDesign &design, const ProofSeen &seen, const Delivered *delivered, int count, ProofState &state,
          ProofWork &work);
void ask(ProofState &state, bool consent);
bool is_closed(const ProofState &state);
bool is_gate_closed(const ProofState &state);

}  // namespace heave
