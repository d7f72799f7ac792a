// All motions at a tick. By linearity the loop's motion is the sum of what the mean payout brings about, which is known
// exactly, and of the rest, which is estimated.
#include "look.h"

namespace heave {

namespace {

// Payout and its rate in a state, under a command that is active.
Motion drum_of(const LookDesign &design, const double *state, double command) {
    const double rate = dot(design.order, design.payout_rate, state) + design.through * command;
    return {dot(design.order, design.payout, state), rate};
}

Motion tip_of(const LookDesign &design, const double *state) {
    return {dot(design.order, design.tip, state), dot(design.order, design.tip_rate, state)};
}

// Share of the boom tip's estimated motion that is not noise.
double wave_share(const LookDesign &design, double tip_power, const double *covariance) {
    double product[STATES];
    const double noise = square(design.noise_swing) * across(design.order, design.tip, covariance, product);
    return tip_power > noise ? 1.0 - noise / tip_power : 0.0;
}

// The taut shadow goes over to the shadow: near the resonance it would else swing by far more than any unit does.
void relax_taut_shadow(const LookDesign &design, LookState &state) {
    const Motion free = motion_of(design.cable, state.shadow), taut = motion_of(design.taut_cable, state.taut_shadow);
    const double share = design.tick_period / design.taut_time;
    const Motion relaxed{taut.heave + share * (free.heave - taut.heave), taut.rate + share * (free.rate - taut.rate)};
    continue_at(design.taut_cable, state.taut_shadow, relaxed);
}

}  // namespace

void begin_share(const LookDesign &design, LookState &state) {
    continue_at(design.taut_cable, state.taut_shadow, motion_of(design.cable, state.shadow));
}

void continue_shadow(const LookDesign &design, LookState &state, const Motion &motion) {
    continue_at(design.cable, state.shadow, motion);
    begin_share(design, state);
}

// The unit is elsewhere, and so is the one with the winch locked.
void take_unit(const LookDesign &design, LookState &state, const Motion &motion) {
    const Motion free = motion_of(design.cable, state.shadow), hanging = motion_of(design.cable, state.hanging);
    continue_shadow(design, state, {free.heave + motion.heave - hanging.heave, free.rate + motion.rate - hanging.rate});
    continue_at(design.cable, state.hanging, motion);
}

void find_motions(const LookDesign &design, const LookState &state, const LookInputs &inputs, const LoopStates &loop,
                  Motions &motions) {
    const double *x = loop.x, *mean = loop.mean;
    const Motion tip = tip_of(design, x), drum = drum_of(design, x, inputs.compensating);
    const Motion mean_drum = drum_of(design, mean, inputs.mean);
    const Motion swing{mean_drum.heave + mean[design.unit], mean_drum.rate + mean[design.unit_rate]};
    const Motion free = motion_of(design.cable, state.shadow), taut = motion_of(design.taut_cable, state.taut_shadow);
    const double waves = state.wave_share, aside = inputs.knows_tip != 0.0 ? waves : 0.0;
    motions.tip = tip.heave;
    motions.tip_rate = tip.rate;
    motions.payout = drum.heave;
    motions.payout_rate = drum.rate;
    motions.total_payout_rate = drum.rate + mean_drum.rate;
    motions.mean_payout = mean_drum.heave;
    motions.mean_heave = swing.heave;
    motions.mean_rate = swing.rate;
    motions.unit = swing.heave + x[design.unit];
    motions.unit_rate = swing.rate + x[design.unit_rate];
    motions.free = free.heave;
    motions.free_rate = free.rate;
    motions.taut = taut.heave;
    motions.taut_rate = taut.rate;
    motions.released = waves * free.heave;
    motions.released_rate = waves * free.rate;
    motions.offset = motions.unit + drum.heave - aside * free.heave;
    motions.offset_rate = motions.unit_rate + drum.rate - aside * free.rate;
    motions.hanging_heave = state.hanging_heave;
    motions.hanging_stretch = tip.heave - (drum.heave + mean_drum.heave) - state.hanging_heave;
    motions.wave_share = waves;
}

void look(const LookDesign &design, LookState &state, const LookInputs &inputs, const LoopStates &loop, Motions &motions) {
    const double *x = loop.x;
    const Motion tip = tip_of(design, x), drum = drum_of(design, x, inputs.compensating);
    state.tip_power += (square(tip.heave) - state.tip_power) * design.tick_period / design.tip_memory;
    advance_unit(design.cable, state.shadow, tip);
    advance_unit(design.taut_cable, state.taut_shadow, tip);
    relax_taut_shadow(design, state);
    advance_unit(design.cable, state.hanging, {tip.heave - drum.heave, tip.rate - drum.rate});
    if (inputs.takes_unit != 0.0) take_unit(design, state, {x[design.unit], x[design.unit_rate]});
    state.wave_share = wave_share(design, state.tip_power, loop.P);
    state.hanging_heave = loop.mean[design.unit] + motion_of(design.cable, state.hanging).heave;
    find_motions(design, state, inputs, loop, motions);
}

}  // namespace heave
