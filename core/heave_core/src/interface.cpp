// The C interface. Sizes and the number of the layout are asked for by whoever loads the library, before anything else.
#include "filter.h"
#include "pass.h"
#include "servo.h"

extern "C" {

long long heave_core_layout() { return heave::LAYOUT; }

long long heave_core_size(int structure) {
    const int count = sizeof heave::RECORD_SIZES / sizeof *heave::RECORD_SIZES;
    return structure >= 0 && structure < count ? heave::RECORD_SIZES[structure] : 0;
}

// Begin: the brake is on, and nothing was read yet.
void heave_core_begin(heave::State *state) { heave::begin_envelope(*state); }

// One tick: readings and the controller's order in, the order that leaves out.
void heave_core_envelope(const heave::Design *design, heave::State *state, const heave::Readings *readings, heave::Order *order) {
    heave::envelope(*design, *state, *readings, *order);
}

// Begin: the filter knows nothing yet.
void heave_core_filter_begin(const heave::Filter *filter, heave::FilterState *state) { heave::begin_filter(*filter, *state); }

// A run of ticks of the filter with their readings; each leaves what it said.
void heave_core_filter(const heave::Filter *filter, heave::FilterState *state, const heave::FilterTick *ticks, int count,
                       const heave::Reading *readings, heave::Said *said) {
    heave::run_filter(*filter, *state, ticks, count, readings, said);
}

// A pass over a record: state x (n, c) and P (n, n) in place, work (n, c + 2 n), innovations (m, c) over the standard
// deviation that was predicted, and its square (m,).
void heave_core_pass(const heave::Pass *pass, const heave::PassTick *ticks, const double *commands,
                     const heave::PassReading *readings, const double *rows, const double *values, double *x, double *P,
                     double *work, double *innovations, double *variances) {
    heave::run_pass(*pass, ticks, {readings, rows, values, innovations, variances}, commands, x, P, work);
}

// Readings of the encoder under set-points, of each of several drums, (count, ticks).
void heave_core_servo(const heave::ServoRun *run, const double *payouts, const double *rates, const double *late,
                      const double *tensions, const heave::Servo *servos, const heave::ServoStart *starts, int count,
                      double *readings) {
    const heave::SetPoints sent{payouts, rates, late, tensions, run->sent};
    for (int i = 0; i < count; i++)
        heave::servo_record(*run, sent, servos[i], starts[i], run->ticks, readings + i * run->ticks);
}

// What the encoder should read at the end of a record.
void heave_core_servo_reading(const heave::ServoRun *run, const double *payouts, const double *rates, const double *late,
                              const double *tensions, const double *readings, const heave::Servo *servo, double *work,
                              double *found) {
    const heave::SetPoints sent{payouts, rates, late, tensions, run->sent};
    *found = heave::servo_reading(*run, sent, *servo, readings, work);
}

}
