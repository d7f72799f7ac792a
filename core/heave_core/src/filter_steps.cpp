// Prediction and correction of a Kalman filter (Simon, Optimal State Estimation, 2006, 5.1 and 6.1).
#include <cstring>

#include "filter.h"

namespace heave {

double dot(int n, const double *a, const double *b) {
    double sum = 0.0;
    for (int i = 0; i < n; i++) sum += a[i] * b[i];
    return sum;
}

// product = left right of (n, n) and (n, columns); most of a transition is empty.
void multiply(int n, int columns, const double *left, const double *right, double *product) {
    for (int i = 0; i < n; i++) {
        double *row = product + i * columns;
        for (int j = 0; j < columns; j++) row[j] = 0.0;
        for (int k = 0; k < n; k++) {
            const double weight = left[i * n + k];
            if (weight != 0.0) add(columns, weight, right + k * columns, row);
        }
    }
}

// x = F x + B u; P = F P F' + Q = F (F P)' + Q of a symmetric P, which stays so to the bit.
void predict(int n, const Step &step, double command, double *x, double *P) {
    double moved[STATES], half[STATES * STATES], turned[STATES * STATES];
    for (int i = 0; i < n; i++) moved[i] = dot(n, step.F + i * n, x) + step.B[i] * command;
    std::memcpy(x, moved, sizeof(double) * n);
    multiply(n, n, step.F, P, half);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) turned[j * n + i] = half[i * n + j];
    multiply(n, n, step.F, turned, P);
    for (int i = 0; i < n; i++)
        for (int j = 0; j <= i; j++) P[i * n + j] = P[j * n + i] = P[i * n + j] + step.Q[i * n + j];
}

// product = P h, and h' P h
double across(int n, const double *row, const double *P, double *product) {
    for (int j = 0; j < n; j++) product[j] = 0.0;
    for (int i = 0; i < n; i++)
        if (row[i] != 0.0) add(n, row[i], P + i * n, product);
    return dot(n, row, product);
}

// Take in readings one after the other: their noises are independent, so that it is the same as all at once (Simon, 6.1).
// Each is linearised at the state before the first. K = P h/S, S = h' P h + r; the covariance by Joseph's form
// (I - K h') P (I - K h')' + K r K', multiplied out.
void take(const Filter &filter, const Reading *readings, int count, double *x, double *P) {
    const int n = filter.states;
    double before[STATES], row[STATES], carried[STATES], gain[STATES];
    std::memcpy(before, x, sizeof(double) * n);
    for (int m = 0; m < count; m++) {
        const double predicted = linearised(filter, readings[m], before, row);
        // a bilinear reading predicts something else than h x
        const double left = readings[m].value - predicted + dot(n, row, before) - dot(n, row, x);
        const double S = across(n, row, P, carried) + readings[m].variance;
        for (int i = 0; i < n; i++) {
            gain[i] = carried[i] / S;
            x[i] += gain[i] * left;
        }
        for (int i = 0; i < n; i++)
            for (int j = 0; j <= i; j++)
                P[i * n + j] += gain[i] * (S * gain[j] - carried[j]) - carried[i] * gain[j];
        for (int i = 0; i < n; i++)
            for (int j = 0; j < i; j++) P[j * n + i] = P[i * n + j];
    }
}

}  // namespace heave
