// Supervision of a tick: landing and standing load, the guard's judgement, command timeouts, what limits authority, how the
// unit is damped while compensation fades out, the mode, and touchdown, in this order. What happens is a bit of which Python
// makes words; nothing here waits for them.
#include "supervise.h"

namespace heave {

namespace {

// Sensors that are lost, by what supervision asks of them.
struct Lost {
    int bits;  // by index; an excluded motion reference unit or load cell is: no other measures what it does
    bool mru, encoder, depth, cell;
};

Lost lost_of(const Supervising &on) {
    const SenseDesign &sense = *on.sense;
    int bits = int(on.tick->lost_sensors);
    const int excluded = on.sense_state->excluded;
    if (excluded == sense.mru || excluded == sense.load_cell) bits |= 1 << excluded;
    if (on.seen->cell_jumped != 0.0) bits |= 1 << sense.load_cell;
    const auto has = [bits](int sensor) { return (bits >> sensor & 1) != 0; };
    return {bits, has(sense.mru), has(sense.encoder), has(sense.depth), has(sense.load_cell)};
}

int required(const Supervising &on) { return on.design->required[on.mode->mode]; }

bool is_lost(const Supervising &on, const Lost &lost) { return (lost.bits & required(on)) != 0; }

// Where the drum is, not where its command is.
void observe_landing(const Supervising &on, const double *depths, const Lost &lost) {
    const Tick &tick = *on.tick;
    for (int i = 0; i < int(tick.depth_count); i++) add(on.landing_state->depth, depths[2 * i], depths[2 * i + 1]);
    LandingSeen seen{};
    seen.time = tick.number * on.design->tick_period;
    seen.tension = tick.tension;
    seen.is_weighed = !lost.cell && std::isfinite(tick.filtered_tension);
    seen.mean_payout = tick.motions.mean_payout;
    seen.hanging_depth = -tick.motions.hanging_heave;
    seen.hanging_stretch = tick.motions.hanging_stretch;
    seen.innovation = tick.depth_innovation;
    observe_landing(*on.landing, *on.landing_state, seen);
}

// The unit's heave by the newest depth reading, carried from its stamp to now by the estimate [m]: a sensor that is late, or
// slow, reads where the unit was.
double depth_now(const Supervising &on, const double *depths) {
    const Tick &tick = *on.tick;
    const int kept = on.design->past, count = int(tick.depth_count);
    SupervisionState &state = *on.state;
    const double unit = tick.motions.unit - tick.motions.mean_heave;
    state.past[state.next] = unit;
    const int newest = state.next;
    state.next = (state.next + 1) % kept;
    state.count = std::min(state.count + 1, kept);
    if (std::isnan(tick.depth_heave)) return NOT_KNOWN;
    const double dt = on.design->tick_period;
    const double age = count > 0 ? tick.number * dt - depths[2 * (count - 1)] : 0.0;
    const int ago = int(clip(std::nearbyint(age / dt), 0.0, state.count - 1));
    return tick.depth_heave + tick.motions.mean_heave + unit - state.past[(newest - ago + kept) % kept];
}

// Variance that what is not known of sea and winch leaves of compensated motion, over that motion's: that of an authority A
// which is best is 1/A - 1.
double unknown(const Supervising &on) {
    return 1.0 / on.seen->share - 1.0 + (on.tick->is_sea_refuted != 0.0 ? 1.0 / on.design->cautious - 1.0 : 0.0);
}

// The guard judges the tick. The estimate is that of a hanging unit, counted with a winch that does nothing but move the mean
// payout.
void judge(const Supervising &on, const double *depths) {
    const Motions &motions = on.tick->motions;
    const ModeState &mode = *on.mode;
    const double measured = depth_now(on, depths);
    const bool is_hanging = hangs(*on.landing_state) && on.landing_state->may_stand == 0.0;
    const bool is_judged = is_hanging && on.tick->knows_tip != 0.0 && mode.mode != IN_CONSTANT_TENSION;
    Seen seen{};
    seen.unit = motions.unit;
    seen.unit_rate = motions.unit_rate;
    seen.free = motions.free + motions.mean_heave;
    seen.free_rate = motions.free_rate + motions.mean_rate;
    seen.tip = motions.tip;
    seen.tip_rate = motions.tip_rate;
    seen.payout_rate = motions.payout_rate;
    seen.measured = is_hanging ? measured : NOT_KNOWN;
    seen.noise = on.tick->depth_noise;
    seen.mean_acceleration = on.seen->mean_acceleration;
    seen.drum_error = on.seen->drum_error;
    seen.unknown = unknown(on);
    seen.payout = motions.payout;
    seen.authority = is_judged ? mode.authority : 0.0;
    seen.target = mode.target;
    const bool fades = mode.mode == IN_FADE_OUT || mode.mode == IN_STOPPING;
    judge_attempt({*on.guard, *on.attempt_design, *on.guard_state, *on.attempts}, seen, fades, *on.verdict);
}

// A timeout has ended compensation: it is asked for again, or too often.
int note_timeout(const Supervising &on) {
    interrupt_attempt(*on.attempts);
    const bool is_often = awaits_operator(*on.attempt_design, *on.attempts);
    on.state->is_pending = !is_often;
    on.state->is_tried = 0;
    on.state->link_well = 0.0;
    return is_often ? LINK_LOST_OFTEN : 0;
}

// What follows where the winch has stopped because no command came in time: a hiccup between controller and winch is over
// when commands are taken again. Each raises the bar for the next attempt; where they come again and again an operator
// decides. A winch that was released and kept its fault counts as one that has timed out again.
int watch_link(const Supervising &on, bool is_well) {
    SupervisionState &state = *on.state;
    const int fault = int(on.seen->fault), timeout = on.design->command_timeout;
    const bool is_new = fault == timeout && state.fault_before != fault;
    state.fault_before = fault;
    if (is_new && on.mode->wants && on.modes->resumes) return note_timeout(on);
    state.is_pending = state.is_pending && fault == timeout;
    if (!state.is_pending) return 0;
    state.link_well = is_well ? state.link_well + on.design->tick_period : 0.0;
    if (state.link_well < on.design->link_wait) return 0;
    const int given_up = state.is_tried ? note_timeout(on) : 0;
    state.is_tried = state.is_pending;
    state.link_well = 0.0;
    return given_up ? given_up : LINK_BACK;
}

// Compensation is asked for again where only late commands ended it.
void resume_after_timeout(const Supervising &on, const Lost &lost, int &happened) {
    const bool may_go_on = may_resume(*on.modes, *on.situation, *on.mode) || !on.mode->wants;
    const bool is_stopped = on.mode->mode == IN_STOPPED;
    const int found = watch_link(on, is_stopped && !is_lost(on, lost) && may_go_on && on.seen->is_certain == 0.0);
    if (found == LINK_BACK) request_mode(*on.modes, *on.situation, ON_ASK_COMPENSATING, *on.mode);
    happened |= found;
}

// What limits authority is news once it lasts, and again after a minute; so is its end.
int watch_share(const Supervising &on) {
    const double dt = on.design->tick_period, longest = on.design->held_time;
    SupervisionState &state = *on.state;
    const bool compensates = on.mode->mode == IN_COMPENSATING;
    const double share = on.verdict->best_authority < on.verdict->allowed ? on.verdict->best_authority : 1.0;
    const bool is_held = share < 1.0 && compensates;
    state.held = is_held ? state.held + dt : std::min(state.held + dt, 0.0);
    if (state.held >= longest) {
        state.held = -on.design->reported_again;
        state.is_reported = 1;
        return AUTHORITY_HELD;
    }
    state.is_reported = state.is_reported && compensates;  // whatever ends compensation is reported with its mode
    state.free = state.is_reported && !is_held ? state.free + dt : 0.0;
    if (state.free < longest || on.mode->authority < on.mode->factor) return 0;
    state.is_reported = 0;
    return AUTHORITY_FREE;
}

double free_swing(const Supervising &on, double heave, double rate) {
    return std::hypot(heave, std::sqrt(on.design->inertia) * rate);
}

// The unit swings no more about its uncompensated motion: the winch may stop. In calm water it is hardly to move at all, and
// rests below where the drum stands when it stops.
bool is_settled(const Supervising &on) {
    const Motions &motions = on.tick->motions;
    double swing = on.seen->settled_swing;
    if (std::isinf(swing)) return true;
    if (on.tick->knows_tip != 0.0)
        swing = std::min(swing, on.design->settled_at_rest + free_swing(on, motions.released, motions.released_rate));
    return free_swing(on, motions.offset, motions.offset_rate) < swing;
}

// Whether the unit is damped by the depth sensor alone: let go at rest it would take minutes to swing as it does without
// compensation, and swing more on the way.
bool is_damped_blind(const Supervising &on, const Lost &lost) {
    const bool has_depth = on.tick->has_depth != 0.0 && !lost.depth && !on.attempts->distrusts;
    const bool is_blind = on.tick->knows_tip == 0.0 && has_depth && std::isfinite(on.seen->settled_swing);
    on.state->blind = is_blind ? on.state->blind + on.design->tick_period : 0.0;
    return is_blind && on.state->blind < on.design->blind_limit;
}

// Whether the unit may be damped in a fade-out: after harm, or without the encoder. For that time payout is known from the
// commands sent, and the rest from motion reference unit and depth sensor.
bool may_damp(const Supervising &on, const Lost &lost) {
    if (on.attempts->distrusts) return false;
    if (!is_lost(on, lost)) return on.attempts->inhibits;
    const bool is_mru_lost = lost.mru && (required(on) >> on.sense->mru & 1);
    return on.tick->has_depth != 0.0 && !lost.depth && !is_mru_lost;
}

// Whether the law itself lets the unit go: an operator has asked for the fade-out, and the sensors are well. It goes on by
// prediction while one is missing, for as long as compensation does, and again once that one is back.
bool lets_go(const Supervising &on) {
    const ModeState &mode = *on.mode;
    const bool is_known = mode.coasted <= on.modes->coast_time || mode.well_time > on.modes->back_time;
    return on.state->fades_compensation && !mode.wants && is_known;
}

// Inputs of the mode machine; returns whether the unit is damped. A unit that stands is at rest, and one that swings as
// below a locked winch may go beyond a highest tension.
bool fill_situation(const Supervising &on, const Lost &lost) {
    const SupervisionSeen &seen = *on.seen;
    Situation &now = *on.situation;
    const bool is_reversed = seen.is_reversed != 0.0, is_blind = is_damped_blind(on, lost);
    const bool can_settle = on.landing_state->unit_stands == 0.0 && std::isinf(on.design->highest_ratio);
    const bool settles = lets_go(on) && can_settle, has_faded = settles && on.mode->authority == 0.0;
    const bool is_damped = !is_reversed && (is_blind || has_faded || may_damp(on, lost));
    const int fault = int(seen.fault), encoder = on.sense->encoder;
    now.lost = is_lost(on, lost);
    now.encoder_lost = lost.encoder && (required(on) >> encoder & 1);
    now.encoder_frozen = now.encoder_lost != 0.0 && on.sense_state->gates[encoder].reason == FROZEN;
    now.winch_silent = now.encoder_lost != 0.0 && on.sense_state->gates[encoder].reason == STALE;
    now.has_estimate = on.tick->has_encoder;
    now.winch_fault = fault;
    now.is_emergency = fault == on.design->emergency_stop;
    now.is_automatic = on.design->automatic >> fault & 1;
    now.harm = is_reversed || on.attempts->inhibits;
    now.envelope = seen.envelope;
    now.is_settled = !(is_damped || settles) || is_settled(on);
    now.is_damped_blind = is_blind;
    now.speed = seen.speed;
    now.authority_limit = on.verdict->best_authority;
    now.shown_authority = on.verdict->shown;
    on.done->gates = compensation_gates(on);
    on.done->tension_gates = tension_gates(on, lost.cell);
    now.gates_closed = on.done->gates != 0.0;
    now.tension_closed = on.done->tension_gates != 0.0;
    return is_damped;
}

// Notes whether a fade-out is that of compensation.
void follow_mode(const Supervising &on, int before) {
    const int mode = on.mode->mode;
    if (mode == IN_COMPENSATING && before == IN_FADE_OUT) allow_resumption(*on.guard, *on.guard_state);
    if (mode != IN_FADE_OUT) on.state->fades_compensation = 0;
    else if (before == IN_COMPENSATING) on.state->fades_compensation = 1;
}

// Lowering without depth readings is news; touchdown while lowering, and that the unit hangs again after lift-off.
void watch_landing(const Supervising &on, int &happened) {
    const Tick &tick = *on.tick;
    const SupervisionDesign &design = *on.design;
    LandingState &landing = *on.landing_state;
    const bool compensates = on.mode->mode == IN_COMPENSATING;
    const bool is_blind = compensates && tick.sees_landing == 0.0 && landing.unit_stands == 0.0;
    const bool lowers = is_blind && landing.lowering_rate >= design.least_rate;
    if (begins(on.state->quiet[2], design.quiet_time, design.tick_period, lowers)) happened |= LOWERS_BLIND;
    LandingSeen seen{};
    seen.time = tick.number * design.tick_period;
    seen.filtered_tension = tick.filtered_tension;
    seen.sees_landing = tick.sees_landing;
    seen.has_depths = tick.depth_count > 0.0;
    seen.compensates = compensates && on.mode->authority > design.least_authority;
    judge_landing(*on.landing, landing, seen);
    if (landing.event != NOT) happened |= UNIT_EVENT;
}

// Compensation in a sea with peaks above those that the winch is to be used for is news, and again once they have grown.
int watch_peaks(const Supervising &on) {
    SupervisionState &state = *on.state;
    if (on.mode->mode == IN_STANDBY) state.peak_reported = 0.0;
    const double peak = on.design->peak_ratio * on.verdict->demand;
    const double most = std::max(on.design->peak_use, on.design->grown * state.peak_reported);
    // not a number: a law has spoilt the estimate
    if (on.mode->mode != IN_COMPENSATING || !(peak > most)) return 0;
    state.peak_reported = peak;
    return SEA_ABOVE_WINCH;
}

void report(const Supervising &on, bool is_damped, int happened) {
    Supervised &done = *on.done;
    const bool is_reversed = on.seen->is_reversed != 0.0;
    done.mode = on.mode->mode;
    done.authority = on.mode->authority;
    done.is_braked = is_braked(*on.mode);
    done.is_inhibited = on.attempts->inhibits;
    done.is_damped = is_damped;
    done.trusts_estimate = !on.attempts->distrusts && !is_reversed;
    done.fades_by_law = lets_go(on);
    done.unit_stands = !hangs(*on.landing_state);
    done.bounds_tension = on.state->is_kept;
    done.happened = happened;
}

}  // namespace

void begin_supervision(SupervisionState &state) {
    state = SupervisionState{};
    begin_standing_load(state);
    begin_highest_tension(state);
    for (double &quiet : state.quiet) quiet = INFINITE;
}

void supervise(const Supervising &on, const double *depths) {
    const Lost lost = lost_of(on);
    int happened = 0;
    observe_landing(on, depths, lost);
    if (on.seen->is_certain != 0.0) inhibit(*on.attempts);
    watch_standing_load(on, depths, lost.cell, lost.encoder, happened);
    judge(on, depths);
    if (on.attempts->begun != on.state->reasons) happened |= INHIBITED;
    on.state->reasons = on.attempts->begun;
    resume_after_timeout(on, lost, happened);
    watch_highest_tension(on, happened);
    happened |= watch_share(on);
    const bool is_damped = fill_situation(on, lost);
    on.done->event = step_modes(*on.modes, *on.situation, *on.mode);
    const int before = on.mode->before;
    on.done->before = before;
    on.mode->before = on.mode->mode;
    follow_mode(on, before);
    happened |= watch_peaks(on);
    watch_landing(on, happened);
    report(on, is_damped, happened);
}

}  // namespace heave
