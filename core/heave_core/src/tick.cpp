// A tick of the controller, from the readings to the order that leaves: encoder reflex (encoder_reflex.cpp), sense (sense.cpp),
// proofs, winch watch, supervision (supervise.cpp), command, envelope, and the alarms of the load (`leave` in act.cpp), in this
// order. `control`, at the end, is the entry. Where Python has something to do it comes back, and is called again from there.
#include "tick.h"

namespace heave {

namespace {

bool has(double bits, int sensor) { return int(bits) >> sensor & 1; }

// Limits of the winch that act, as it reports in this tick.
int limits_of(const Control &on) { return on.given->has_winch != 0.0 ? int(on.given->limits_hit) : 0; }

// Whether the motion reference unit is lost, or excluded: no other sensor measures what it does.
bool is_mru_lost(const Control &on) {
    return has(on.tick->lost_sensors, on.sense->mru) || on.sense_state->excluded == on.sense->mru;
}

// A winch that has forgotten which commands it took has begun anew, braked and with another count: what was ordered of the
// drum before it must not be ordered of it.
void watch_restart(const Control &on) {
    Given &given = *on.given;
    const double newest = on.winch_state->link.newest;  // above the own number: of another controller
    const bool has_forgotten = given.has_winch != 0.0 && given.command < newest && newest <= on.done->sequence;
    if (has_forgotten && on.acting.done->brake == 0.0 && given.fault == 0.0) given.fault = on.supervising.design->restart;
}

void sense(const Control &on) {
    const Given &given = *on.given;
    const Command &last = *on.acting.command;
    LookAt at{};
    at.number = given.number;
    at.compensating = last.compensating;
    at.mean = last.mean;
    at.unit_stands = !shows_hanging(*on.supervising.landing_state);
    at.readings = given.readings;
    at.winch_time = NOT_KNOWN;
    if (given.has_winch != 0.0 && on.active->has_begun) {
        at.has_winch = 1.0;
        at.winch_time = given.winch_time;
        at.encoder = given.encoder;
        at.is_driven = given.brake == 0.0 && given.fault == 0.0;
    }
    const Core core{*on.sense, *on.filter, *on.look, *on.acting.motion, *on.sense_state, *on.filter_state, *on.look_state};
    look_at(core, at, on.delivered, {on.found, on.observed, on.taken, on.said, on.by_measurement, on.depths}, *on.tick);
}

int prove(const Control &on) {
    const Given &given = *on.given;
    const ModeState &mode = *on.supervising.mode;
    ProofSeen seen{};
    seen.latest = given.number * on.sense->tick_period + on.sense->health.stamp_tolerance;
    seen.has_winch = given.has_winch;
    seen.winch_time = given.winch_time;
    seen.encoder = given.encoder;
    seen.encoder_rate = given.encoder_rate;
    seen.is_braked = on.done->sequence == 0.0 || on.acting.done->brake != 0.0 || given.cause == BRAKE_SLIPS;
    seen.waits = mode.mode == IN_STANDBY && mode.wants;
    seen.hangs = hangs(*on.supervising.landing_state);
    seen.has_mru = !is_mru_lost(on);
    seen.runs = given.cause == BRAKE_SLIPS;
    seen.has_swung = given.cause == HARM;
    return prove(*on.proofs, seen, on.delivered, int(given.readings), *on.proof_state, *on.proof_work);
}

// Orders of the last seconds beside what the encoder made of them.
void watch_orders(const Control &on) {
    const Given &given = *on.given;
    const ActDone &last = *on.acting.done;
    WinchSeen seen{};
    seen.has_state = given.has_winch;
    seen.taken = given.command;
    seen.at_end = limits_of(on) & on.active->payout_limit;
    seen.is_limited = limits_of(on) != 0;
    seen.given = on.done->sequence > 0.0 ? on.done->sequence : NOT_KNOWN;
    seen.payout = last.own_payout;
    seen.rate = last.own_rate;
    seen.brake = last.brake;
    seen.reading = on.tick->encoder_payout;
    seen.tension = on.tick->tension;
    watch_winch(*on.winch_watch, *on.winch_state, {on.drum_rows, on.drum_work}, on.minute, seen);
}

// What the adviser is told of the order of the tick before, and of the winch under it.
void note_order(const Control &on) {
    const Given &given = *on.given;
    const ActDone &last = *on.acting.done;
    const bool has_winch = given.has_winch != 0.0, rests = has_winch && (given.brake != 0.0 || given.fault != 0.0);
    Noted &noted = on.done->noted;
    noted.order_payout = last.own_payout;
    noted.order_rate = last.own_rate;
    noted.sequence = on.done->sequence;
    noted.brake = on.done->sequence == 0.0 || last.brake != 0.0 || rests;
    noted.taken = has_winch ? given.command : NOT_KNOWN;
    noted.limits_hit = limits_of(on);
}

// Speed of the winch, as commanded; infinite while the envelope brings it to rest [m/s].
double commanded_speed(const Control &on) {
    const Order &sent = *on.acting.order;
    if (sent.phase == TAKEN || sent.phase == RAMP) return INFINITE;
    if (on.acting.winch->is_first_order) return std::abs(on.tick->motions.total_payout_rate);
    return std::abs(on.acting.command->value - on.acting.command->standing);
}

void decide(const Control &on) {
    const Active &active = *on.active;
    const LinkState &link = on.winch_state->link;
    const MeanPayout &mean = on.acting.motion->mean;
    SupervisionSeen &seen = *on.supervising.seen;
    seen.fault = on.given->fault;
    seen.speed = commanded_speed(on);
    seen.mean_payout = mean.payout;
    seen.mean_acceleration = mean.move.slope;
    seen.settled_swing = active.settled_swing;
    seen.share = active.share;
    const bool is_drum_seen = active.identifies_winch && !is_count_refuted(*on.reflex_state);
    seen.drum_error = is_drum_seen ? on.winch_state->error : 0.0;
    seen.is_reversed = on.reflex_state->is_unresolved;
    seen.is_certain = link.is_cut || link.overdue > active.tolerated_delay || on.reflex_state->is_unresolved;
    seen.envelope = on.given->cause != 0.0;
    seen.is_proved = !is_gate_closed(*on.proof_state);
    seen.cell_jumped = (int(on.acting.order->bits) & LOAD_IS_OFF) != 0;
    supervise(on.supervising, on.depths);
}

// Whether something has happened of which Python makes words, or another mode.
bool is_news(const Control &on) {
    const Supervised &decided = *on.supervising.done;
    const bool is_mode = decided.event >= 0.0 || decided.mode != decided.before;
    return is_mode || decided.happened != 0.0 || on.done->proof_news != 0.0 || on.winch_state->link.news;
}

// By what the command is made. Where a sensor was lost the estimated motion of the unit is not to be acted upon; a winch of
// first order has no rate to command: its law fades out by itself.
Way way_of(const Control &on) {
    const Supervised &decided = *on.supervising.done;
    if (decided.is_braked != 0.0) return BY_BRAKE;
    switch (int(decided.mode)) {
        case IN_COMPENSATING: return BY_LAW;
        case IN_CONSTANT_TENSION: return BY_TENSION;
        case IN_MANUAL: return BY_PLACE;
        case IN_STOPPING: return BY_SLOWING;
        case IN_FADE_OUT: break;
        default: return BY_NOTHING;
    }
    if (decided.trusts_estimate == 0.0) return BY_SLOWING;
    if (on.acting.winch->is_first_order) return BY_LAW;
    if (decided.is_damped != 0.0) return BY_SETTLING;
    return decided.fades_by_law != 0.0 ? BY_LAW : BY_FADE;
}

void see_what_to_do(const Control &on) {
    const Active &active = *on.active;
    const Supervised &decided = *on.supervising.done;
    const Tick &tick = *on.tick;
    ActSeen &seen = *on.acting.seen;
    seen.way = way_of(on);
    seen.authority = decided.authority;
    seen.compensates = decided.mode == IN_COMPENSATING;
    seen.fades = decided.mode == IN_FADE_OUT;
    seen.brake = decided.is_braked;
    seen.is_damped = decided.is_damped;
    seen.bounds_tension = decided.bounds_tension;
    seen.unit_stands = decided.unit_stands;
    seen.knows_tip = tick.knows_tip;
    seen.has_depth = tick.has_depth;
    seen.sees_landing = tick.sees_landing;
    seen.follows_tip = !is_mru_lost(on);
    seen.mru_rate = tick.mru_rate;
    seen.tension = tick.tension;
    seen.filtered_tension = tick.filtered_tension;
    seen.static_tension = active.static_tension;
    // every limit but that of the payout, also of torque and pressure, acts as one of speed or acceleration
    seen.at_limit = (limits_of(on) & ~active.payout_limit) != 0;
    seen.stated_payout = active.stated_payout;
    seen.scale = on.sense_state->encoder.scale;
    seen.offset = on.sense_state->encoder.offset;
}

// What the envelope sees: raw readings, and what the controller is there for.
void read_raw(const Control &on) {
    const Given &given = *on.given;
    Readings &readings = *on.acting.readings;
    readings.mru_heave = readings.mru_rate = readings.count = readings.load = readings.depth = NOT_KNOWN;
    readings.count_age = 0.0;
    for (int i = 0; i < int(given.readings); i++) {
        const Delivered &one = on.delivered[i];
        if (one.sensor == on.sense->mru && one.status == 0.0) {
            readings.mru_heave = one.value;
            readings.mru_rate = one.rate;
        }
        if (one.sensor == on.sense->load_cell) readings.load = one.value;
        if (one.sensor == on.sense->depth) readings.depth = one.value;
    }
    readings.drive = DRIVE_FREE;
    if (given.has_winch != 0.0) {
        readings.count = given.encoder;
        // times of ticks are rounded otherwise than stamps
        readings.count_age = 1e-6 * std::nearbyint(1e6 * (given.number * on.sense->tick_period - given.winch_time));
        if (given.fault != 0.0) readings.drive = DRIVE_FAILED;
        else if (given.brake != 0.0) readings.drive = DRIVE_RESTS;
        else if (given.limits_hit != 0.0) readings.drive = DRIVE_LIMITED;
    }
    const int mode = on.supervising.mode->mode;
    const bool is_damped_blind = mode == IN_FADE_OUT && on.supervising.situation->is_damped_blind != 0.0;
    readings.duty = is_damped_blind ? double(DAMP) : on.supervising.design->duties[mode];
}

// Poses the problem of the tick.
void begin_to_act(const Control &on) {
    see_what_to_do(on);
    read_raw(on);
    std::copy_n(on.filter_state->x, on.acting.design->states, on.acting.loop->estimate);
    std::copy_n(on.acting.motion->state, on.acting.design->states, on.acting.loop->mean_state);
    pose(on.acting);
}

// What the adviser is told of the tick.
void note(const Control &on) {
    const Tick &tick = *on.tick;
    Noted &noted = on.done->noted;
    noted.command = tick.compensating;
    noted.encoder = std::isnan(tick.encoder_payout) ? NOT_KNOWN : on.sense_state->encoder.as_read;
    noted.tension = tick.tension;
    noted.authority = on.supervising.done->authority;
    noted.compensates = on.supervising.done->mode == IN_COMPENSATING;
    noted.tip_heave = tick.motions.tip;
    noted.tip_rate = tick.motions.tip_rate;
    noted.unit_rate = on.filter_state->x[on.look->unit_rate];
    noted.missing_push = tick.missing_push;
}

// The order leaves; what was acknowledged is.
void send(const Control &on) {
    leave(on.acting);
    on.acting.readings->acknowledged = 0.0;
    on.done->sequence += 1.0;
    on.done->authority = on.supervising.done->authority;
    note(on);
}

}  // namespace

// A tick from a stage of it on; returns the stage at which Python is to call again, DONE where the order has left.
int control(const Control &on, int from) {
    const int stops = int(on.given->stops);
    Controlled &done = *on.done;
    switch (from) {
        case BEGIN:
            watch_restart(on);
            done.encoder_news = watch_encoder(on);
            if (done.encoder_news != 0.0) return SENSE;
            [[fallthrough]];
        case SENSE:
            sense(on);
            done.news = on.tick->news;
            done.observed = on.tick->observed_count;
            if ((stops & AFTER_SENSE) || (int(done.news) & SEA_CHANGED)) return DECIDE;
            [[fallthrough]];
        case DECIDE:
            done.proof_news = prove(on);
            watch_orders(on);
            note_order(on);
            decide(on);
            if ((stops & BEFORE_ACT) || is_news(on)) return POSE;
            [[fallthrough]];
        case POSE:
            begin_to_act(on);
            if (stops & BEFORE_ANSWER) return ANSWER;
            [[fallthrough]];
        case ANSWER:
            done.asks = answer(on.acting);
            if (done.asks != 0.0) return MAKE;
            break;
        case MAKE:
            make(on.acting);
            break;
        default: break;  // SEND
    }
    send(on);
    return DONE;
}

}  // namespace heave
