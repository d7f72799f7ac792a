// The sea as the boom tip moves in it, against that of the design: its height, and how many waves were seen.
#include "sense.h"

namespace heave {

// Height of the boom tip's motion over that of the design; 1 until enough has been seen.
double height_ratio(const SeaDesign &design, const SeaSeen &sea) {
    const double settled = sea.seen >= design.patience ? std::sqrt(sea.variance / design.variance) : 1.0;
    const double growing = design.group_share * std::sqrt(sea.group_variance / design.variance);
    return std::min(std::max({settled, growing, design.smallest}), design.largest);
}

void begin_sea(SeaSeen &sea) {
    sea = SeaSeen{};
    sea.applied = sea.mean_nis = 1.0;
}

// What a heave rate said against its prediction. A perfect instrument sees what no model has.
void note_innovation(const SeaDesign &design, double tick_period, SeaSeen &sea, double nis, double sigma) {
    const double counted = std::min(nis * std::min(1.0, square(sigma / design.least_error)), design.largest_nis);
    sea.mean_nis += tick_period / design.innovation_memory * (counted - sea.mean_nis);
}

// Take in a tick, as in a plain mean at first; return whether the height has changed enough for another noise.
bool update_sea(const SeaDesign &design, double tick_period, SeaSeen &sea, const Motion &tip) {
    sea.seen += tick_period;
    sea.since_judged += tick_period;
    const double share = tick_period / std::min(sea.seen, design.memory), heave2 = square(tip.heave);
    sea.variance += share * (heave2 - sea.variance);
    sea.rate_variance += share * (square(tip.rate) - sea.rate_variance);
    sea.fourth_moment += share * (square(heave2) - sea.fourth_moment);
    sea.group_variance += tick_period / std::min(sea.seen, design.group_memory) * (heave2 - sea.group_variance);
    const double ratio = height_ratio(design, sea);
    if (std::abs(ratio / sea.applied - 1.0) < design.step) return false;
    sea.applied = ratio;
    return true;
}

// Waves in the fading memory; in a sea that has just grown only the last ones count. Of a normal sea the fourth moment is
// three times the variance squared; where heights differ more, fewer count.
double waves_of(const SeaDesign &design, const SeaSeen &sea) {
    if (sea.variance < square(design.least_heave)) return 0.0;
    const double counted = std::min(sea.seen, design.memory) * std::min(3.0 * square(sea.variance) / sea.fourth_moment, 1.0);
    return counted * std::sqrt(sea.rate_variance / sea.variance) / (2.0 * M_PI);
}

}  // namespace heave
