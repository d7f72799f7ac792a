// Steps in the heave of a motion reference unit, which cannot move otherwise than its own heave rate says, and jumps of a
// depth sensor, which no unit makes. A ship heaves about where it floats: after a step heave and rate contradict each
// other by as much as the step, for as long as it stays; a wrong mean heave would be paid out, metre by metre.
#include "sense.h"

namespace heave {

namespace {

// By how much the heave has changed since the last reading, a step left out: by the rates that were read, or by the heave
// itself, unless it is off what it did before. Stamps that are arrivals scatter.
double change_of(const StepLimits &limits, MruSteps &steps, const Delivered &reading, double noise) {
    const double elapsed = reading.time - steps.time, rates = steps.heave_rate + reading.rate;
    if (!std::isnan(rates)) return 0.5 * rates * elapsed;
    const double change = reading.value - steps.heave, filtered = elapsed + limits.scatter;
    if (std::isnan(steps.rate)) {
        steps.rate = change / filtered;
        return change;
    }
    const double expected = steps.rate * elapsed;
    const double allowed = std::max(limits.mru_step, limits.sigmas * noise) + limits.scatter * std::abs(steps.rate);
    if (std::abs(change - expected) > allowed) return expected;
    steps.rate += (change - expected) / filtered;
    return change;
}

// Whether what is read since a step has the mean of before.
bool is_back(const StepLimits &limits, MruSteps &steps, double heave, double elapsed) {
    if (steps.new_time == 0.0) steps.new_mean = steps.new_square = 0.0;
    steps.new_time += elapsed;
    heave = clip(heave, -limits.largest_heave, limits.largest_heave);
    const double weight = elapsed / std::min(steps.new_time, limits.mean_time);
    steps.new_mean += weight * (heave - steps.new_mean);
    steps.new_square += weight * (square(heave) - steps.new_square);
    const double spread = std::sqrt(std::max(steps.new_square - square(steps.new_mean), 0.0));
    const double near = std::max(limits.near_mean * spread, limits.least_near);
    steps.is_unproved = steps.new_time >= limits.mean_time && std::abs(steps.new_mean - steps.mean) < near;
    return steps.is_unproved != 0.0;
}

}  // namespace

void begin_steps(MruSteps &steps) {
    steps = MruSteps{};
    steps.time = steps.rate = steps.attitude_time = NOT_KNOWN;
}

// Take a reading in; return whether its heave is off by a step.
bool is_off(const StepLimits &limits, MruSteps &steps, const Delivered &reading, double noise) {
    steps.is_unproved = 0.0;
    const double elapsed = reading.time - steps.time, heave = reading.value;
    const bool goes_on = elapsed > 0.0 && elapsed <= limits.longest_gap;
    bool off = false;
    if (!goes_on) {
        steps.foreseen = heave;
        steps.rate = NOT_KNOWN;
        steps.new_time = 0.0;
    } else {
        steps.foreseen += change_of(limits, steps, reading, noise);
        const bool is_near = std::abs(heave - steps.foreseen) <= std::max(limits.mru_step, limits.sigmas * noise);
        off = !is_near && !is_back(limits, steps, heave, elapsed);
    }
    steps.time = reading.time;
    steps.heave = heave;
    steps.heave_rate = reading.rate;
    if (off || !goes_on) return off;
    steps.foreseen = heave;
    steps.new_time = 0.0;
    steps.known = std::min(steps.known + elapsed, limits.mean_time);
    steps.mean += elapsed / steps.known * (heave - steps.mean);
    return false;
}

// Whether a reading of the motion reference unit may be used, its status included.
bool admits_mru(const SenseDesign &design, SenseState &state, double now, const Delivered &reading) {
    const Sensor &sensor = design.sensors[design.mru];
    SensorGate &gate = state.gates[design.mru];
    int status = reading.status != 0.0 ? STATUS + int(reading.status) : GOOD;
    // a unit that does not measure the rate says NaN
    const double rate = std::isnan(reading.rate) ? 0.0 : reading.rate;
    const double values[] = {reading.value, rate, reading.roll, reading.pitch};
    const bool can_be = std::isfinite(reading.value + rate + reading.time) && is_in_range(sensor, values, 4);
    if (status != GOOD || !can_be) state.mru.time = NOT_KNOWN;
    else if (is_off(design.steps, state.mru, reading, state.noises[sensor.measured].sigma)) status = JUMP;
    const bool passes = judge(design.health, sensor, gate, now, reading.time, values, 4, status);
    if (gate.reason == FROZEN) state.mru.time = NOT_KNOWN;  // where the ship has gone meanwhile its rate does not tell
    return passes;
}

void begin_jumps(DepthJumps &jumps) {
    jumps = DepthJumps{};
    jumps.time = NOT_KNOWN;
}

// The depth without jumps, or NaN where it has just jumped. A sensor that jumps back, as after a spike, is again where it
// was at first.
double take_off(const StepLimits &limits, DepthJumps &jumps, double time, double depth, double noise) {
    const bool is_first = std::isnan(jumps.time);
    const double last = is_first ? depth : jumps.depth, elapsed = is_first ? 0.0 : time - jumps.time;
    const double allowed = std::max(limits.depth_step, limits.sigmas * noise) + limits.depth_speed * elapsed;
    jumps.time = time;
    for (const double offset : {jumps.offset, 0.0}) {
        if (std::abs(depth - offset - last) > allowed) continue;
        jumps.is_unproved = jumps.has_jumped != 0.0 && jumps.is_like_scale != 0.0 && offset != 0.0;
        jumps.has_jumped = 0.0;
        jumps.offset = offset;
        return jumps.depth = depth - offset;
    }
    jumps.jump = depth - jumps.offset - last;
    jumps.is_like_scale = std::abs(jumps.jump) > limits.like_scale * std::abs(last);
    jumps.has_jumped = 1.0;
    jumps.is_unproved = 0.0;
    jumps.offset = depth - last;
    jumps.depth = last;
    return NOT_KNOWN;
}

}  // namespace heave
