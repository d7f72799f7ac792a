// One pass of a linear filter over a record, for many versions of the record at once.
#pragma once

#include "filter.h"

namespace heave {

// What is read, of m readings and c columns, and what it leaves.
struct PassReads {
    const PassReading *readings;
    const double *rows;                 // of the measurements, and their first and second differences over ticks (3, k, n)
    const double *values;               // (m, c)
    double *innovations, *variances;    // over the standard deviation that was predicted (m, c), and its square (m,)
};

void run_pass(const Pass &pass, const PassTick *ticks, const PassReads &reads, const double *commands, double *x,
              double *P, double *work);

}  // namespace heave
