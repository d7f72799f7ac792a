// Running statistics; the first values of each weigh as in a plain average.
#include "look.h"

namespace heave {

// Variance about a mean that is followed more slowly.
void add(RunningSigma &sigma, double value, double weight, double slow_mean) {
    sigma.count += 1.0;
    const double first = 1.0 / sigma.count;
    sigma.mean += std::max(weight / slow_mean, first) * (value - sigma.mean);
    sigma.variance += std::max(weight, first) * (square(value - sigma.mean) - sigma.variance);
}

// Squares of the motion and of its reference; weights are those of the check's time and of the waves.
void add(AmplitudeCheck &check, double square, double reference, double weight, double wave_weight) {
    check.count += 1.0;
    const double first = 1.0 / check.count, quick = std::max(weight, first);
    check.now += quick * (reference - check.now);
    check.waves += std::max(wave_weight, first) * (reference - check.waves);
    check.square += quick * (square - check.square);
}

// The larger of now and of the last waves: the pause between two groups of waves is no reason to find a motion too large.
double reference_of(const AmplitudeCheck &check) { return std::max(check.now, check.waves); }

double amplitude_of(const AmplitudeCheck &check) { return std::sqrt(std::max(check.square - square(check.noise), 0.0)); }

// Never before some waves have been seen.
bool is_exceeded(const AmplitudeCheck &check, const AmplitudeLimit &limit, double seen_ticks) {
    if (check.count < seen_ticks) return false;
    const double largest = limit.ratio * (std::sqrt(reference_of(check)) + check.left_over);
    return amplitude_of(check) > std::max(limit.floor, largest);
}

// Heave by the steps of the readings, of which none is larger than a unit can make; NaN: no reading came.
void add(DetrendedHeave &heave, const GuardDesign &design, double reading, double noise) {
    heave.ticks += 1.0;
    heave.value *= 1.0 - design.tick_period / design.detrend_time;
    if (std::isnan(reading)) return;
    const double step = std::isnan(heave.last) ? 0.0 : reading - heave.last;
    const double elapsed = heave.ticks * design.tick_period;
    const double largest = std::max(design.largest_step, design.step_sigmas * noise) + design.step_speed * elapsed;
    if (std::abs(step) <= largest) heave.value += step;
    heave.last = reading;
    heave.ticks = 0.0;
}

}  // namespace heave
