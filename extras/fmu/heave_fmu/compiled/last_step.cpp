// The envelope of heave_core between the fixed controller's order and the winch.
#include "last_step.h"

#include "parts.h"

static_assert(sizeof(heave::State) == ENVELOPE_NUMBERS * sizeof(double), "bounds.h is of another layout");

static const heave::Design DESIGN = ENVELOPE_DESIGN;

extern "C" {

void last_step_begin(double *memory) { heave::begin_envelope(*reinterpret_cast<heave::State *>(memory)); }

Within last_step(double *memory, const Seen *seen, const Within *ordered) {
    heave::Readings readings{};
    readings.mru_heave = seen->heave;
    readings.mru_rate = seen->heave_rate;
    readings.count = seen->count;
    readings.load = readings.held_tension = readings.target = readings.reference = heave::NOT_KNOWN;
    readings.duty = ordered->brake != 0.0 ? heave::OPERATE : heave::FOLLOW;
    readings.request = -1.0;
    readings.payout = ordered->payout;
    readings.rate = ordered->payout_rate;
    readings.brake = ordered->brake;
    heave::Order order;
    heave::envelope(DESIGN, *reinterpret_cast<heave::State *>(memory), readings, order);
    return {order.payout, order.rate, order.brake};
}

}
