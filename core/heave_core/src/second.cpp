// A filter beside the active one: the same readings, otherwise explained, and how far either was off them.
#include "sense.h"

namespace heave {

namespace {

// A reading for the second filter: as corrected, or as read, without the mean payout's share.
bool put(const SenseDesign &design, const Second &second, const Observed &observed, Reading &reading) {
    const int row = int(observed.row);
    if (second.which[row] < 0) return false;
    reading = in_terms(design, observed);
    if (!second.goes_by_count) {
        reading.tick = std::min(observed.tick, observed.delivered);
        reading.offset = observed.offset;
        reading.value = observed.value - observed.share;
    }
    reading.which = second.which[row];
    reading.variance = square(observed.sigma > 0.0 ? observed.sigma : second.sigma[row]);
    reading.first_state = second.levers[0];
    reading.second_state = second.levers[1];
    return true;
}

// What is read counts in units of the larger noise of the two predictions.
void compare(Second &second, const Core &core, const Room &room, int count) {
    for (int i = count - 1; i >= 0; i--) {
        int row = 0;
        while (second.which[row] != room.readings[i].which) row++;
        bool is_newest = true;
        for (int j = i + 1; j < count; j++) is_newest &= room.readings[j].which != room.readings[i].which;
        const int which = core.design.measured[row].which;
        if (!second.is_compared[row] || !is_newest || which < 0) continue;
        const Said &active = room.by_measurement[which], &mine = room.said[i];
        if (!std::isfinite(mine.nis + active.nis)) continue;
        const double noise = square(std::max(active.sigma, mine.sigma));
        second.active[row] += square(active.innovation) / noise;
        second.second[row] += square(mine.innovation) / noise;
        second.count[row] += 1.0;
    }
}

}  // namespace

void step_second(const Core &core, const Room &room, const Tick &tick, double command, bool compares, Second &second) {
    const SenseDesign &design = core.design;
    const int payout = design.sensors[design.encoder].measured;
    const bool takes_all = !second.goes_by_count && core.state.excluded >= 0 && core.state.excluded != design.encoder;
    const bool has_count = second.goes_by_count && !std::isnan(tick.counted);
    int count = 0;
    for (int i = 0; i < int(tick.observed_count); i++) {
        const Observed &observed = room.observed[i];
        if ((observed.is_used == 0.0 && !takes_all) || (has_count && observed.row == payout)) continue;
        count += put(design, second, observed, room.readings[count]);
    }
    if (has_count) {
        Observed counted{tick.number, tick.count_tick, double(payout), tick.counted, 0.0, tick.count_offset, NOT_KNOWN, 1.0,
                         NOT_KNOWN, 0.0, 0.0, tick.counted};
        counted.share = share_of(design, core.state, core.look, counted);
        count += put(design, second, counted, room.readings[count]);
    }
    sort_readings(room.readings, count);
    const FilterTick step{tick.number, command, double(count)};
    run_filter(core.filter, core.filter_state, &step, 1, room.readings, room.said);
    if (compares) compare(second, core, room, count);
}

}  // namespace heave
