/* The Kalman filter: late readings are taken in at their own tick, and the filter runs forward again from there. */
#include "filter.h"

#include <math.h>
#include <string.h>

#include "design.h"

#define DRAG_UNCERTAINTY 0.3
#define SLACK_UNCERTAINTY 0.3

double dot(const double *a, const double *b, int count)
{
    double sum = 0.0;
    for (int i = 0; i < count; i++) sum += a[i] * b[i];
    return sum;
}

static double excess_damping(double speed)
{
    return fmax(DRAG_QUADRATIC * fabs(speed) - DRAG_DAMPING, 0.0);
}

double kept_speed(double speed, double time)
{
    return exp(-excess_damping(speed) / CABLE_INERTIA * time);
}

void filter_begin(Filter *filter)
{
    memset(filter, 0, sizeof *filter);
    memcpy(filter->P, INITIAL_P, sizeof filter->P);
    for (int i = 0; i < MEASUREMENTS; i++) filter->streams[i] = NAN;
}

/* Refer to the model of a step from the present estimate: with the drag of its speed, and with a slack cable. */
static void set_model(Filter *filter)
{
    const double speed = fabs(filter->x[UNIT_RATE]), excess = excess_damping(speed);
    const double missing = fmax(-dot(SLACK_PULL, filter->x, ORDER) - SLACK_LARGEST, 0.0);
    memcpy(filter->F, MODEL_F, sizeof filter->F);
    memcpy(filter->B, MODEL_B, sizeof filter->B);
    memcpy(filter->Q, MODEL_Q, sizeof filter->Q);
    if (excess > 0.0) {
        const double half = kept_speed(speed, 0.5 * TICK_PERIOD);
        const double error = DRAG_UNCERTAINTY * excess / CABLE_INERTIA * speed;
        for (int j = 0; j < ORDER; j++) {
            filter->F[UNIT_RATE][j] *= half;
            filter->Q[UNIT_RATE][j] *= half;
        }
        filter->B[UNIT_RATE] *= half;
        for (int i = 0; i < ORDER; i++) {
            filter->F[i][UNIT_RATE] *= half;
            filter->Q[i][UNIT_RATE] *= half;
        }
        filter->Q[UNIT_RATE][UNIT_RATE] += error * error * TICK_PERIOD;
    }
    if (missing > 0.0) {
        const double share = missing / (missing + SLACK_LARGEST) * TICK_PERIOD / CABLE_INERTIA;
        const double error = SLACK_UNCERTAINTY * missing / CABLE_INERTIA;
        for (int j = 0; j < ORDER; j++) filter->F[UNIT_RATE][j] -= share * SLACK_PULL[j];
        filter->Q[UNIT_RATE][UNIT_RATE] += error * error * TICK_PERIOD;
    }
}

/* out = left P left' + noise, noise NULL: none */
static void carry_covariance(double left[ORDER][ORDER], double P[ORDER][ORDER], double noise[ORDER][ORDER])
{
    double half[ORDER][ORDER] = {{0.0}};
    for (int i = 0; i < ORDER; i++)
        for (int k = 0; k < ORDER; k++)
            for (int j = 0; j < ORDER; j++) half[i][j] += left[i][k] * P[k][j];
    for (int i = 0; i < ORDER; i++)
        for (int j = 0; j < ORDER; j++) P[i][j] = dot(half[i], left[j], ORDER) + (noise ? noise[i][j] : 0.0);
}

/* x = F x + B u, P = F P F' + Q */
static void predict(Filter *filter, double command)
{
    double x[ORDER];
    for (int i = 0; i < ORDER; i++) x[i] = dot(filter->F[i], filter->x, ORDER) + filter->B[i] * command;
    memcpy(filter->x, x, sizeof x);
    carry_covariance(filter->F, filter->P, filter->Q);
}

static void row_of(const Reading *reading, double row[ORDER])
{
    const double offset = reading->offset, bend = 0.5 * offset * (offset - 1.0);
    for (int j = 0; j < ORDER; j++)
        row[j] = ROWS[reading->which][j] + offset * CHANGES[reading->which][j] + bend * BENDS[reading->which][j];
}

/* Solve S X = R for X, in place of R, by elimination with pivots. */
static void solve(double S[MOST][MOST], double R[MOST][ORDER], int count)
{
    for (int k = 0; k < count; k++) {
        int pivot = k;
        for (int i = k + 1; i < count; i++)
            if (fabs(S[i][k]) > fabs(S[pivot][k])) pivot = i;
        for (int j = 0; j < count && pivot != k; j++) {
            const double swapped = S[k][j];
            S[k][j] = S[pivot][j];
            S[pivot][j] = swapped;
        }
        for (int j = 0; j < ORDER && pivot != k; j++) {
            const double swapped = R[k][j];
            R[k][j] = R[pivot][j];
            R[pivot][j] = swapped;
        }
        for (int i = k + 1; i < count; i++) {
            const double factor = S[i][k] / S[k][k];
            for (int j = k; j < count; j++) S[i][j] -= factor * S[k][j];
            for (int j = 0; j < ORDER; j++) R[i][j] -= factor * R[k][j];
        }
    }
    for (int k = count - 1; k >= 0; k--)
        for (int j = 0; j < ORDER; j++) {
            for (int i = k + 1; i < count; i++) R[k][j] -= S[k][i] * R[i][j];
            R[k][j] /= S[k][k];
        }
}

/* Take in the readings of a tick together: K' = (H P H' + R)^-1 H P, and Joseph's form of the covariance. */
static void take(Filter *filter, const Reading *readings, int count)
{
    double H[MOST][ORDER], gain[MOST][ORDER], S[MOST][MOST], rest[ORDER][ORDER], innovations[MOST];
    if (count == 0) return;
    for (int m = 0; m < count; m++) {
        row_of(&readings[m], H[m]);
        innovations[m] = readings[m].value - dot(H[m], filter->x, ORDER);
        for (int j = 0; j < ORDER; j++) gain[m][j] = dot(filter->P[j], H[m], ORDER);
    }
    for (int m = 0; m < count; m++) {
        for (int l = 0; l < count; l++) S[m][l] = dot(gain[m], H[l], ORDER);
        S[m][m] += VARIANCES[readings[m].which];
    }
    solve(S, gain, count);
    for (int i = 0; i < ORDER; i++) {
        for (int m = 0; m < count; m++) filter->x[i] += gain[m][i] * innovations[m];
        for (int j = 0; j < ORDER; j++) {
            rest[i][j] = i == j ? 1.0 : 0.0;
            for (int m = 0; m < count; m++) rest[i][j] -= gain[m][i] * H[m][j];
        }
    }
    carry_covariance(rest, filter->P, NULL);
    for (int i = 0; i < ORDER; i++)
        for (int j = 0; j < ORDER; j++)
            for (int m = 0; m < count; m++)
                filter->P[i][j] += gain[m][i] * VARIANCES[readings[m].which] * gain[m][j];
    for (int i = 0; i < ORDER; i++)
        for (int j = 0; j < i; j++)
            filter->P[i][j] = filter->P[j][i] = 0.5 * (filter->P[i][j] + filter->P[j][i]);
}

/* Tell whether a reading may be used; after many refusals in a row the covariance is raised, and it may. */
static bool judge(Filter *filter, const Reading *reading)
{
    const int which = reading->which;
    double row[ORDER], variance = VARIANCES[which];
    row_of(reading, row);
    for (int i = 0; i < ORDER; i++) variance += row[i] * dot(filter->P[i], row, ORDER);
    const double innovation = reading->value - dot(row, filter->x, ORDER);
    const double nis = innovation * innovation / variance, step = innovation - filter->streams[which];
    const bool is_stream = step * step <= 2.0 * GATE * variance;
    bool accepted = nis <= GATE || ((is_stream || !IS_GATED[which]) && isfinite(nis));
    filter->refusals[which] = accepted ? 0 : filter->refusals[which] + 1;
    if (filter->refusals[which] > GATE_LIMIT && isfinite(nis)) {
        for (int i = 0; i < ORDER; i++)
            for (int j = 0; j < ORDER; j++) filter->P[i][j] += INITIAL_P[i][j];
        filter->refusals[which] = 0;
        accepted = true;
    }
    if (accepted) filter->streams[which] = innovation;
    return accepted;
}

static void keep_prediction(Filter *filter, int tick)
{
    const int place = tick % KEPT;
    memcpy(filter->past_x[place], filter->x, sizeof filter->x);
    memcpy(filter->past_P[place], filter->P, sizeof filter->P);
}

static void begin_tick(Filter *filter, int tick)
{
    keep_prediction(filter, tick);
    filter->counts[tick % KEPT] = 0;
    filter->newest = tick;
    if (filter->kept < KEPT) filter->kept++;
}

/* Take in readings of one tick, and run forward again to the present. */
static void take_at(Filter *filter, const Reading *readings, int count)
{
    const int tick = readings[0].tick;
    if (filter->newest - tick >= filter->kept) return;
    const int place = tick % KEPT, before = filter->counts[place];
    if (tick < filter->newest) {
        memcpy(filter->x, filter->past_x[place], sizeof filter->x);
        memcpy(filter->P, filter->past_P[place], sizeof filter->P);
        take(filter, filter->used[place], before);
    }
    for (int i = 0; i < count; i++)
        if (filter->counts[place] < MOST && judge(filter, &readings[i]))
            filter->used[place][filter->counts[place]++] = readings[i];
    take(filter, &filter->used[place][before], filter->counts[place] - before);
    for (int later = tick + 1; later <= filter->newest; later++) {
        predict(filter, filter->commands[(later - 1) % KEPT]);
        keep_prediction(filter, later);
        take(filter, filter->used[later % KEPT], filter->counts[later % KEPT]);
    }
}

void filter_step(Filter *filter, int tick, double command, Reading *readings, int count)
{
    set_model(filter);
    if (filter->kept == 0) begin_tick(filter, tick);
    for (int next = filter->newest + 1; next <= tick; next++) {
        filter->commands[(next - 1) % KEPT] = command;
        predict(filter, command);
        begin_tick(filter, next);
    }
    for (int i = 0; i < count; i++) {
        const Reading reading = readings[i];
        int place = i;
        for (; place > 0 && readings[place - 1].tick > (reading.tick < tick ? reading.tick : tick); place--)
            readings[place] = readings[place - 1];
        readings[place] = reading;
        if (readings[place].tick > tick) readings[place].tick = tick;
    }
    for (int first = 0, end; first < count; first = end) {
        for (end = first + 1; end < count && readings[end].tick == readings[first].tick;) end++;
        take_at(filter, &readings[first], end - first);
    }
}
