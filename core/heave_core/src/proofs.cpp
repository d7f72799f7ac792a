// Proofs by nominal values and raw readings alone, before the brake opens. While the drum is braked, the load cell is compared
// with what a nominal load makes of the raw MRU, k (x0 - z), and the depth sensor with its z, beside an offset, a trend and a
// free swing. A slope of 1 says that the MRU reads what the load does; a negative one that it is reversed. On a long cable
// tension is not mass times acceleration: the waves are quicker than the load, and the sign is the other one.
#include "proofs.h"

#include <cstring>

namespace heave {

namespace {

constexpr int OFFSET_AND_TREND = 2;  // of what is beside the motion

void begin_record(const ProofDesign &design, ProofState &state) {
    if (state.expected.count + state.read[0].count + state.read[1].count == 0) return;
    state.expected.next = state.expected.count = 0;
    for (WitnessRecord &read : state.read) read.next = read.count = 0;
    state.next_look = design.shortest;
}

bool is_sure(const ProofDesign &design, const Fit &fit, double certainty) {
    return std::abs(certainty) > design.certain && std::abs(fit.correlation) > design.alike;
}

// Both signals are the same motion.
bool proves(const ProofDesign &design, const Fit &fit) {
    return is_sure(design, fit, fit.certainty) && design.least_scale < fit.scale && fit.scale < design.most_scale;
}

// They are not, and not by chance, nor by what was fitted to few waves: the slope is outside, and so is all that it may be.
bool refutes(const ProofDesign &design, const Fit &fit) {
    const double certainty = std::sqrt(fit.left) * fit.certainty;
    const double error = certainty != 0.0 ? design.refuted * std::abs(fit.scale / certainty) : INFINITE;
    return is_sure(design, fit, certainty) && (fit.scale + error < design.least_scale || fit.scale - error > design.most_scale);
}

// Fit of load cell and depth sensor together: tension over stiffness and heave of the load are the boom tip's, whatever hangs
// on the cable and however it swings. Returns that of the plausible cable that fits best; `nominal` becomes the nominal one's.
Fit fitted_tip(const ProofDesign &design, const ProofState &state, Fit &nominal, ProofWork &work) {
    Fit best{};
    for (const double softness : design.softness) {
        const Sum expected = {1.0 / design.stiffness, 1.0}, read = {softness / design.stiffness, 1.0};
        const Fit fit = fitted(design, state, expected, read, OFFSET_AND_TREND, work);
        if (softness == 1.0) nominal = fit;
        if (std::abs(fit.correlation) > std::abs(best.correlation)) best = fit;
    }
    return best;
}

// Judges the record: a witness that proves the MRU outweighs one that is wired the other way. One that refutes it by the
// nominal load may see another load or cable: both together must agree, unless they have not settled it for long. A result is
// not reset by a record without one.
void look(const ProofDesign &design, ProofState &state, ProofWork &work) {
    Fit fits[WITNESSES + 1] = {};
    int proved = -1, refuted = -1, surest = -1, read = 0;
    lay_beside(design, state.expected.count, work);
    for (int i = WITNESSES - 1; i >= 0; i--) {
        if (!reaches(design, state.expected, state.read[i])) continue;
        const Sum alone = {i == 0 ? 1.0 : 0.0, i == 1 ? 1.0 : 0.0};
        fits[i] = fitted(design, state, alone, alone, BESIDE, work);
        if (proves(design, fits[i])) proved = i;
        if (refutes(design, fits[i])) refuted = i;
        if (surest < 0 || std::abs(fits[i].certainty) >= std::abs(fits[surest].certainty)) surest = i;
        read++;
    }
    if (proved < 0 && read == WITNESSES) {
        const bool has_depth = std::abs(fits[1].correlation) > design.alike;  // a frozen one reads as a softer cable does
        const bool is_late = state.waited > design.patience && state.standing != MRU_PROVED;
        const Fit tip = fitted_tip(design, state, fits[WITNESSES], work);
        if (has_depth && proves(design, fits[WITNESSES])) proved = WITNESSES;
        else if (is_late ? has_depth && proves(design, tip) : !refutes(design, tip)) refuted = -1;
    }
    int standing = MRU_OPEN;
    if (proved >= 0) standing = MRU_PROVED;
    else if (refuted >= 0) standing = fits[refuted].scale < 0.0 ? MRU_REVERSED : MRU_SCALED;
    if (standing == MRU_OPEN) {
        if (state.standing != MRU_OPEN && state.standing != MRU_QUIET && state.standing != MRU_ALONE) return;
        if (surest < 0 || state.waited > design.patience) standing = MRU_ALONE;
        if (spread_of_heave(design, state.expected) < design.quiet) standing = MRU_QUIET;
    }
    state.standing = standing;
    state.witness = proved >= 0 ? proved : refuted >= 0 ? refuted : surest;
    const Fit fit = state.witness >= 0 ? fits[state.witness] : Fit{};
    state.scale = fit.scale;
    state.correlation = fit.correlation;
    state.certainty = fit.certainty;
}

// Advances the nominal load by a tick, with the last good reading of the MRU in it. Returns whether its cable has become
// another one.
bool move_load(const ProofDesign &design, const ProofSeen &seen, const Delivered *delivered, int count, ProofState &state) {
    const Delivered *last = nullptr;
    for (int i = 0; i < count; i++) {
        const Delivered &one = delivered[i];
        const bool is_rate = std::isnan(one.rate) || std::abs(one.rate) <= design.largest_rate;
        const bool is_good = one.status == 0.0 && one.time <= seen.latest && std::abs(one.value) <= design.largest_heave;
        if (one.sensor == design.mru && is_good && is_rate && one.time > -INFINITE) last = &one;
    }
    if (last) read_nominal_load(design.load, state.load, last->time, last->value, last->rate);
    else advance_nominal_load(design.load, state.load);
    if (seen.has_winch == 0.0 || !std::isfinite(seen.encoder)) return false;
    const double length = std::max(design.length + seen.encoder, 1.0);
    return !(std::abs(length / design.cable_length - 1.0) < design.followed);
}

// Takes in a tick under a locked drum.
void compare(const ProofDesign &design, const ProofSeen &seen, const Delivered *delivered, int count, ProofState &state,
             ProofWork &work) {
    for (int i = 0; i < count; i++) {
        const Delivered &one = delivered[i];
        if (!(one.time <= seen.latest)) continue;  // else those after it would come too late
        if (one.sensor == design.load_cell) add(design, state.read[0], one.time, one.value);
        if (one.sensor == design.depth) add(design, state.read[1], one.time, -one.value);
    }
    const NominalLoadState &load = state.load;
    const double stretch = std::max(load.heave - load.unit, -design.static_tension / design.stiffness);
    const double values[WITNESSES] = {design.stiffness * stretch, load.unit};
    if (!add(design, state.expected, load.time, load.heave, values)) return;
    state.waited += design.tick_period;
    state.next_look -= design.tick_period;
    if (state.next_look > 0.0) return;
    state.next_look = design.looked_every;
    look(design, state, work);
}

// Prove the MRU again: the last result holds no more.
void reset_proof(const ProofDesign &design, ProofState &state) {
    state.standing = MRU_OPEN;
    state.witness = -1;
    state.scale = state.correlation = state.certainty = state.waited = 0.0;
    begin_record(design, state);
}

}  // namespace

// Nothing was read yet, and the drum counts as locked.
void begin_proofs(const ProofDesign &design, ProofState &state) {
    std::memset(&state, 0, sizeof state);
    begin_nominal_load(state.load);
    state.braked_time = design.at_rest;
    state.next_look = design.shortest;
    state.count = state.begin = state.since = state.drive_time = state.drive_count = state.drive_rate = NOT_KNOWN;
    state.witness = -1;
}

// An operator asks for a mode, with or without consent to begin without a cross-check: what he knows of is over.
void ask(ProofState &state, bool consent) {
    if (consent) state.consent = 1;
    acknowledge_brake(state);
    state.told = MRU_OPEN;
}

// Compensation may not begin until somebody has done something.
bool is_closed(const ProofState &state) {
    return state.standing == MRU_REVERSED || ((state.standing == MRU_SCALED || state.standing == MRU_ALONE) && !state.consent);
}

// Compensation may not begin by what is known of MRU and brake.
bool is_gate_closed(const ProofState &state) { return state.is_falling || state.standing == MRU_OPEN || is_closed(state); }

// A tick; returns bits of ProofNews.
int prove(const ProofDesign &design, const ProofSeen &seen, const Delivered *delivered, int count, ProofState &state,
          ProofWork &work) {
    int news = move_load(design, seen, delivered, count, state) ? CABLE_IS_LONGER : 0;
    state.braked_time = seen.is_braked != 0.0 ? state.braked_time + design.tick_period : 0.0;
    double tension = NOT_KNOWN;
    for (int i = 0; i < count; i++)
        if (delivered[i].sensor == design.load_cell && seen.hangs != 0.0) tension = delivered[i].value;
    news |= watch_braked(design, seen, tension, state) | check_count(design, seen, state);
    const bool is_known = state.load.read_time > design.blend;
    if (state.braked_time > design.at_rest && seen.hangs != 0.0 && is_known) compare(design, seen, delivered, count, state, work);
    else begin_record(design, state);
    if (seen.has_swung != 0.0) {
        reset_proof(design, state);
        state.consent = 0;
    }
    if (seen.waits == 0.0 || state.standing == state.told) return news;
    state.told = state.standing;
    return is_closed(state) ? news | MRU_CLOSED : news;
}

}  // namespace heave
