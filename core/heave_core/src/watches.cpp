// Whether readings are as far off their prediction as their noise allows; the top tension, low-passed and over waves,
// where it is the weight that the cable carries; whether the boom tip is known.
#include "sense.h"

namespace heave {

void add_innovation(const Watches &watches, double tick_period, SensorNoise &noise, double nis) {
    if (std::isfinite(nis)) noise.mean += tick_period / watches.memory * (std::min(nis, watches.largest_nis) - noise.mean);
}

// Something else is assumed from now on.
void restart_consistency(SenseState &state) {
    for (SensorNoise &noise : state.noises) {
        noise.mean = 1.0;
        noise.quiet_time = 0.0;
    }
    state.disagree_time = 0.0;
}

// After the innovations of a tick; returns what is news.
int watch_consistency(const SenseDesign &design, SenseState &state) {
    const Watches &watches = design.watches;
    double worst = 0.0;
    int news = 0;
    for (int i = 0; i < MEASUREMENTS; i++) {
        SensorNoise &noise = state.noises[i];
        const bool has_refused = !std::isnan(noise.refused) && noise.is_refused == 0.0;
        if (has_refused) {
            noise.is_refused = 1.0;
            news |= ACCURACY_REFUSED;
        }
        noise.news = has_refused ? ACCURACY_REFUSED : 0;
        worst = std::max(worst, noise.mean);
        noise.quiet_time = noise.mean < watches.quiet ? noise.quiet_time + design.tick_period : 0.0;
        if (noise.quiet_time < watches.quiet_time || noise.is_quiet != 0.0) continue;
        noise.is_quiet = 1.0;
        if (!design.measured[i].has_noise || design.measured[i].nominal <= design.health.least_noise) continue;
        noise.news += NOISE_LOW;
        news |= NOISE_LOW;
    }
    state.disagree_time = worst > watches.inconsistent ? state.disagree_time + design.tick_period : 0.0;
    const bool was = state.is_unexplained != 0.0, is_unexplained = state.disagree_time >= watches.unexplained_time;
    state.is_unexplained = is_unexplained;
    return is_unexplained && !was ? news | UNEXPLAINED : news;
}

void restart_tension(MeanTension &mean) {
    mean.count = mean.variance = 0.0;
    mean.value = NOT_KNOWN;
}

void begin_mean(MeanTension &mean) {
    mean = MeanTension{};
    mean.place = mean.filtered = NOT_KNOWN;
    restart_tension(mean);
}

// The mean of one situation: the unit stands or hangs, and the mean payout stays where it is. The first ticks weigh as in
// a plain average.
void add_tension(const Watches &watches, double tick_period, MeanTension &mean, double tension, double place, bool stands) {
    if (!(std::abs(place - mean.place) <= watches.moved) || stands != (mean.stands != 0.0)) {
        mean.place = place;
        mean.stands = stands;
        restart_tension(mean);
    }
    mean.count += 1.0;
    if (mean.count == 1.0) mean.value = tension;
    const double weight = std::max(1.0 / mean.count, tick_period / watches.tension_memory);
    mean.value += weight * (tension - mean.value);
    mean.variance += weight * (square(tension - mean.value) - mean.variance);
}

void filter_tension(const Watches &watches, MeanTension &mean, double tension) {
    if (!std::isfinite(mean.filtered)) mean.filtered = tension;
    mean.filtered += watches.tension_share * (tension - mean.filtered);
}

// The boom tip is known while its sensor is there, or has been lost for no longer than it is predicted; of one that is
// excluded nothing is predicted.
void watch_tip(const Watches &watches, double tick_period, SenseState &state, bool is_lost, bool is_excluded) {
    if (is_excluded || is_lost) {
        state.tip_lost = is_excluded ? INFINITE : state.tip_lost + tick_period;
        state.tip_back = 0.0;
    } else {
        state.tip_back += tick_period;
        if (state.tip_back > watches.back_time) state.tip_lost = 0.0;
    }
    state.knows_tip = state.tip_lost <= watches.coast_time;
}

}  // namespace heave
