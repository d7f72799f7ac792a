// The C interface. Sizes and the number of the layout are asked for by whoever loads the library, before anything else.
#include "filter.h"

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

}
