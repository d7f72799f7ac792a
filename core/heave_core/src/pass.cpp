// A pass: covariance and gains of a linear filter do not depend on what was read, so that many columns go through one.
#include "pass.h"

#include <cstring>

namespace heave {

namespace {

// moved = F x, (n, columns), with what a slack cable does not push; what it gives up is taken before the drag.
void move(const Pass &pass, const PassTick &tick, int columns, const double *x, double *moved) {
    const int n = pass.states;
    multiply(n, columns, pass.F, x, moved);
    if (!(tick.gives > 0.0)) return;
    double *row = moved + pass.rate * columns;
    for (int j = 0; j < n; j++) {
        const double weight = tick.gives * pass.pull[j];
        if (weight != 0.0) add(columns, -weight, x + j * columns, row);
    }
}

// Drag takes its share of the unit's speed for half a tick.
void slow(const Pass &pass, double kept, double *x, double *P) {
    const int n = pass.states, c = pass.columns, r = pass.rate;
    for (int j = 0; j < c; j++) x[r * c + j] *= kept;
    for (int j = 0; j < n; j++) P[r * n + j] *= kept;
    for (int i = 0; i < n; i++) P[i * n + r] *= kept;
}

// x = F x + B u of each column; P = F (F P)' + Q of a symmetric P.
void predict(const Pass &pass, const PassTick &tick, const double *commands, double *x, double *P, double *work) {
    const int n = pass.states, c = pass.columns;
    double *half = work + n * c, *turned = half + n * n;
    slow(pass, tick.kept, x, P);
    move(pass, tick, c, x, work);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < c; j++) x[i * c + j] = work[i * c + j] + pass.B[i] * commands[j];
    move(pass, tick, n, P, half);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) turned[j * n + i] = half[i * n + j];
    move(pass, tick, n, turned, P);
    for (int i = 0; i < n * n; i++) P[i] += pass.Q[i];
    slow(pass, tick.kept, x, P);
    P[pass.rate * n + pass.rate] += tick.unknown;
}

// The row of a reading on the state of its tick: between ticks by Newton's formula over two ticks ahead.
void set_row(const Pass &pass, const PassReads &reads, int m, double *row) {
    const int n = pass.states, table = pass.measurements * n;
    const double offset = reads.readings[m].offset, bend = 0.5 * offset * (offset - 1.0);
    const double *at = reads.rows + int(reads.readings[m].which) * n;
    for (int j = 0; j < n; j++) row[j] = at[j] + offset * at[table + j] + bend * at[2 * table + j];
}

// Judge a reading, and take it in: K = P h/S, x = x + K e, P = P - K S K' (Simon 2006, Eq. 5.19).
void take(const Pass &pass, const PassReads &reads, int m, double *x, double *P) {
    const int n = pass.states, c = pass.columns;
    double *left = reads.innovations + m * c, row[STATES], carried[STATES];
    set_row(pass, reads, m, row);
    std::memcpy(left, reads.values + m * c, sizeof(double) * c);
    for (int i = 0; i < n; i++)
        if (row[i] != 0.0) add(c, -row[i], x + i * c, left);
    const double S = across(n, row, P, carried) + reads.readings[m].noise, deviation = std::sqrt(S);
    reads.variances[m] = S;
    if (reads.readings[m].used != 0.0)
        for (int i = 0; i < n; i++) {
            const double gain = carried[i] / S;
            add(c, gain, left, x + i * c);
            add(n, -gain, carried, P + i * n);
        }
    for (int j = 0; j < c; j++) left[j] /= deviation;
}

}  // namespace

// `work` has place for x and for two matrices.
void run_pass(const Pass &pass, const PassTick *ticks, const PassReads &reads, const double *commands, double *x,
              double *P, double *work) {
    for (int k = 0, m = 0; k < pass.ticks; k++) {
        predict(pass, ticks[k], commands + k * pass.columns, x, P, work);
        for (const int end = int(ticks[k].end); m < end; m++) take(pass, reads, m, x, P);
    }
}

}  // namespace heave
