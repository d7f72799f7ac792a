// The controller's tick on memory of its own: sense, proofs, winch watch, supervision, command, envelope, in this order.
#include "controller.h"

#include "act.h"
#include "image.h"
#include "proofs.h"
#include "supervise.h"

#include <cstring>

namespace heave {

namespace {

constexpr int MOST = 2 * READINGS_MOST + 2;  // readings of a tick as the filter has them

// Room to work in; nothing in it is remembered.
struct Work {
    Delivered delivered[READINGS_MOST];
    Observed found[MOST], observed[MOST];
    Reading readings[MOST];
    Said said[MOST], by_measurement[MEASUREMENTS];
    double depths[2 * READINGS_MOST], drum[7 * DRUM_ROWS];
    double P[STATES * STATES];
    ProofWork proofs;
};

// All that a tick changes. A copy of it is the controller at that tick.
struct Memory {
    Filter filter;  // its process noise goes with the sea
    SenseState sense;
    FilterState filter_state;
    LookState look;
    MeanMotion motion;
    Tick tick;
    ProofState proofs;
    WinchWatchState winch_watch;
    DrumRow drum_rows[DRUM_ROWS];
    double minute[MINUTE];
    LandingState landing;
    GuardState guard;
    Verdict verdict;
    AttemptState attempts;
    ModeState mode;
    Situation situation;
    SupervisionState supervision;
    Supervised decided;
    Loop loop;
    Problem problem;
    LawState law;
    CommandState command_state;
    Command command;
    State envelope;
    Readings readings;
    Order order;
    Place place;
    LoadWatchState load;
    ActDone done;
    double first_count;                            // read before the payout is known [m]; NaN: none
    double sent[3];                                // own set-points of the last order, and its brake
    int number, fault, cause, asks;                // of the tick; of the winch; of the envelope; what was needed last
    bool has_begun, is_taken_over, is_acknowledged;
    Work work;
};

Acting acting(Memory &m, const ActSeen &seen) {
    return {&seen, &m.tick.motions, &IMAGE.winch, &IMAGE.command, &m.loop, &IMAGE.law, &m.problem, &m.law, &m.command_state,
            &m.command, IMAGE.A, IMAGE.B, &m.motion, IMAGE.has_envelope ? &IMAGE.envelope : nullptr, &m.envelope, &m.readings,
            &m.order, &m.place, &IMAGE.load, &m.load, nullptr, nullptr, nullptr, &m.done};
}

// The process noise of the filter in the sea that is seen.
void follow_sea(Memory &m) {
    const double ratio = square(m.sense.sea.applied);
    for (int i = 0; i < m.filter.states * m.filter.states; i++) m.filter.Q[i] = IMAGE.quiet_noise[i] + ratio * IMAGE.sea_noise[i];
}

// The mean payout is here, at rest.
void stand_at(MeanPayout &mean, double payout) {
    mean.payout = payout;
    mean.move.kind = STAND;
    mean.move.rate = mean.move.slope = mean.move.speed = mean.move.distance = 0.0;
}

// The envelope makes the move a second time.
void note_move(Memory &m, int kind) {
    Readings &readings = m.readings;
    readings.request += 1.0;
    readings.kind = kind;
    readings.distance = readings.speed = 0.0;
    readings.target = readings.reference = NOT_KNOWN;
    readings.acceleration = m.motion.mean.move.acceleration;
}

// Takes the payout at which the drum stands when it is first read for the mean one; one that is not near 0 is read twice.
// Drum and unit are at rest there, and the chain of commands holds what keeps them so. Returns whether the count may be used.
bool begin_at_count(Memory &m, const HeaveWinch &winch) {
    if (m.has_begun || !winch.is_new || !std::isfinite(winch.payout)) return true;
    const double before = m.first_count, payout = m.first_count = winch.payout;
    const bool is_near = std::abs(payout) <= IMAGE.near;
    m.has_begun = is_near || std::abs(payout - before) <= IMAGE.near;
    if (!m.has_begun || is_near) return m.has_begun;
    stand_at(m.motion.mean, payout);
    note_move(m, STAND);
    for (int i = 0; i < IMAGE.command.states; i++) m.motion.state[i] = IMAGE.rest_state[i] * payout;
    const double heave = m.sense.first_heave = -payout * (1.0 + IMAGE.sense.stretch_per_payout);
    m.sense.shares = 0;
    for (int i = 0; i < SENSORS; i++) m.sense.gates[i].zero -= IMAGE.sense.sensors[i].sign * heave;
    return true;
}

// Goes on after a tick from the present estimate, with its covariance P.
void continue_filter(Memory &m, int tick) {
    FilterState &state = m.filter_state;
    double x[STATES], streams[MEASUREMENTS];
    const int n = m.filter.states;
    std::copy_n(state.x, n, x);
    std::copy_n(state.P, n * n, m.work.P);
    std::copy_n(state.streams, MEASUREMENTS, streams);
    begin_filter(m.filter, state);
    std::copy_n(x, n, state.x);
    std::copy_n(m.work.P, n * n, state.P);
    std::copy_n(streams, MEASUREMENTS, state.streams);
    const FilterTick step{double(tick), 0.0, 0.0};
    run_filter(m.filter, state, &step, 1, nullptr, nullptr);
}

// What has stopped the winch may have left the unit elsewhere than the estimate has it: it is found again.
void find_drum(Memory &m) {
    const int n = m.filter.states, bias = IMAGE.depth_bias;
    if (bias >= 0) {
        double *P = m.filter_state.P;
        for (int i = 0; i < n; i++) P[bias * n + i] = P[i * n + bias] = 0.0;
        P[bias * n + bias] = IMAGE.bias_variance;
        continue_filter(m, m.number);
    }
    restart_consistency(m.sense);
}

// The winch begins to follow the sea from where it is: payout that is out, and does not follow it, goes away slowly.
void begin_to_follow(Memory &m) {
    const Motions &motions = m.tick.motions;
    const double *x = m.filter_state.x;
    continue_shadow(IMAGE.look, m.look, {motions.unit + motions.payout, motions.unit_rate + motions.payout_rate});
    continue_at(IMAGE.look.cable, m.look.hanging, {x[int(IMAGE.look.unit)], x[int(IMAGE.look.unit_rate)]});
    MeanPayout &left_over = m.motion.left_over;
    stand_at(left_over, motions.payout - m.decided.authority * motions.tip);
    left_over.move.kind = GO;
    left_over.move.speed = IMAGE.return_speed;
    left_over.move.distance = -left_over.payout;
    restart_law(m.law);
}

// Lets mean payout, estimate and law go on from where they are in another mode.
void change_mode(Memory &m, int before, int mode) {
    if (before == IN_STOPPED && mode == IN_STANDBY) find_drum(m);
    if (is_braked(m.mode)) {
        stand_at(m.motion.mean, m.motion.mean.payout);
        stand_at(m.motion.carried, m.motion.carried.payout);
        note_move(m, STAND);
    } else if (mode != IN_COMPENSATING) {
        m.motion.mean.move.kind = m.motion.carried.move.kind = STOP_MOVE;
        note_move(m, STOP_MOVE);
    }
    if (mode == IN_COMPENSATING) begin_share(IMAGE.look, m.look);
    if (mode == IN_COMPENSATING && before != IN_FADE_OUT) begin_to_follow(m);
    const LookInputs inputs{m.tick.compensating, m.tick.mean, m.tick.knows_tip, 0.0};
    find_motions(IMAGE.look, m.look, inputs, {m.filter_state.x, m.motion.state, nullptr}, m.tick.motions);
}

void sense_tick(Memory &m, const HeaveReading *readings, int count, const HeaveWinch &winch) {
    const bool may_use = begin_at_count(m, winch);
    LookAt given{};
    given.number = m.number;
    given.compensating = m.command.compensating;
    given.mean = m.command.mean;
    given.unit_stands = m.decided.unit_stands;
    given.winch_time = NOT_KNOWN;
    for (int i = 0; i < count; i++) {
        const HeaveReading &one = readings[i];
        m.work.delivered[i] = {one.sensor, one.time, one.value, one.rate, one.roll, one.pitch, one.status, one.sigma, one.rate_sigma};
    }
    given.readings = count;
    if (winch.is_new && may_use) {
        given.has_winch = 1.0;
        given.winch_time = winch.time;
        given.encoder = winch.payout;
        given.is_driven = !winch.brake && winch.fault == 0;
    }
    const Core core{IMAGE.sense, m.filter, IMAGE.look, m.motion, m.sense, m.filter_state, m.look};
    look_at(core, given, m.work.delivered, {m.work.found, m.work.observed, m.work.readings, m.work.said, m.work.by_measurement, m.work.depths},
            m.tick);
    if (int(m.tick.news) & SEA_CHANGED) follow_sea(m);
}

void prove_tick(Memory &m, int count, const HeaveWinch &winch) {
    ProofSeen seen{};
    seen.latest = m.number * IMAGE.sense.tick_period + IMAGE.sense.health.stamp_tolerance;
    seen.has_winch = winch.is_new;
    seen.winch_time = winch.time;
    seen.encoder = winch.payout;
    seen.encoder_rate = winch.rate;
    seen.is_braked = m.sent[2];
    seen.waits = m.mode.mode == IN_STANDBY && m.mode.wants;
    seen.hangs = hangs(m.landing);
    seen.has_mru = !(int(m.tick.lost_sensors) >> IMAGE.sense.mru & 1) && m.sense.excluded != IMAGE.sense.mru;
    seen.runs = m.is_taken_over && m.cause == BRAKE_SLIPS;
    seen.has_swung = m.is_taken_over && m.cause == HARM;
    prove(IMAGE.proofs, seen, m.work.delivered, count, m.proofs, m.work.proofs);
}

// Orders of the last seconds beside what the encoder made of them.
void watch_orders(Memory &m, const HeaveWinch &winch) {
    WinchSeen seen{};
    seen.has_state = winch.is_new;
    seen.given = m.number > 1 ? m.number - 1 : NOT_KNOWN;
    if (winch.is_new) {
        m.fault = winch.fault;
        seen.taken = winch.sequence;
        seen.at_end = winch.limits_hit & IMAGE.payout_limit;
        seen.is_limited = winch.limits_hit != 0;
    }
    seen.payout = m.sent[0];
    seen.rate = m.sent[1];
    seen.brake = m.sent[2];
    seen.reading = m.tick.encoder_payout;
    seen.tension = m.tick.tension;
    watch_winch(IMAGE.winch_watch, m.winch_watch, {m.drum_rows, m.work.drum}, m.minute, seen);
}

Supervising supervising(Memory &m, const SupervisionSeen &seen) {
    return {&IMAGE.sense, &m.sense, &m.tick, &IMAGE.supervision, &m.supervision, &seen, &m.decided, &IMAGE.landing, &m.landing,
            &IMAGE.guard, &m.guard, &m.verdict, &IMAGE.attempts, &m.attempts, &IMAGE.modes, &m.mode, &m.situation};
}

void decide(Memory &m) {
    const LinkState &link = m.winch_watch.link;
    const bool makes_own = m.order.phase == TAKEN || m.order.phase == RAMP;
    SupervisionSeen seen{};
    seen.fault = m.fault;
    seen.speed = makes_own                       ? INFINITE
                 : IMAGE.winch.is_first_order    ? std::abs(m.tick.motions.total_payout_rate)
                                                 : std::abs(m.command.value - m.command.standing);
    seen.mean_payout = m.motion.mean.payout;
    seen.mean_acceleration = m.motion.mean.move.slope;
    seen.settled_swing = IMAGE.settled_swing;
    seen.share = IMAGE.share;
    seen.drum_error = IMAGE.identifies_winch ? m.winch_watch.error : 0.0;
    seen.is_certain = link.is_cut != 0 || link.overdue > IMAGE.largest_delay;
    seen.envelope = m.is_taken_over;
    seen.is_proved = !is_gate_closed(m.proofs);
    seen.cell_jumped = (int(m.order.bits) & LOAD_IS_OFF) != 0;
    supervise(supervising(m, seen), m.work.depths);
    const int before = int(m.decided.before), mode = int(m.decided.mode);
    if (mode != before) change_mode(m, before, mode);
    // a landed load asks for constant tension, which is not made here
    if (int(m.decided.happened) & UNIT_EVENT) take_event(IMAGE.modes, m.situation, ON_ASK_STOPPED, m.mode);
}

double way_of(const Memory &m) {
    const Supervised &decided = m.decided;
    if (decided.is_braked != 0.0) return BY_BRAKE;
    switch (int(decided.mode)) {
        case IN_COMPENSATING: return BY_LAW;
        case IN_MANUAL: return BY_PLACE;
        case IN_STOPPING: return BY_SLOWING;
        case IN_FADE_OUT: break;
        default: return BY_NOTHING;
    }
    if (decided.trusts_estimate == 0.0) return BY_SLOWING;
    if (IMAGE.winch.is_first_order) return BY_LAW;
    if (decided.is_damped != 0.0) return BY_SETTLING;
    return decided.fades_by_law != 0.0 ? BY_LAW : BY_FADE;
}

ActSeen act_seen(const Memory &m, const HeaveWinch &winch) {
    const Supervised &decided = m.decided;
    const Tick &tick = m.tick;
    const bool is_mru_lost = (int(tick.lost_sensors) >> IMAGE.sense.mru & 1) || m.sense.excluded == IMAGE.sense.mru;
    ActSeen seen{};
    seen.way = way_of(m);
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
    seen.follows_tip = !is_mru_lost;
    seen.mru_rate = tick.mru_rate;
    seen.tension = tick.tension;
    seen.filtered_tension = tick.filtered_tension;
    seen.static_tension = IMAGE.static_tension;
    seen.at_limit = winch.is_new && (winch.limits_hit & ~IMAGE.payout_limit);
    seen.stated_payout = m.has_begun ? NOT_KNOWN : m.first_count;
    seen.scale = m.sense.encoder.scale;
    seen.offset = m.sense.encoder.offset;
    return seen;
}

// What the envelope sees: raw readings, and what an operator asks for.
void read_raw(Memory &m, int count, const HeaveWinch &winch) {
    Readings &readings = m.readings;
    readings.mru_heave = readings.mru_rate = readings.count = readings.load = readings.depth = NOT_KNOWN;
    for (int i = 0; i < count; i++) {
        const Delivered &one = m.work.delivered[i];
        if (one.sensor == IMAGE.sense.mru && one.status == 0.0) {
            readings.mru_heave = one.value;
            readings.mru_rate = one.rate;
        }
        if (one.sensor == IMAGE.sense.load_cell) readings.load = one.value;
        if (one.sensor == IMAGE.sense.depth) readings.depth = one.value;
    }
    readings.drive = DRIVE_FREE;
    if (winch.is_new) {
        readings.count = winch.payout;
        if (winch.brake || winch.fault) readings.drive = DRIVE_RESTS;
        else if (winch.limits_hit) readings.drive = DRIVE_LIMITED;
    }
    const bool is_damped_blind = m.mode.mode == IN_FADE_OUT && m.situation.is_damped_blind != 0.0;
    readings.duty = is_damped_blind ? double(DAMP) : IMAGE.duties[m.mode.mode];
    readings.acknowledged = m.is_acknowledged;
    m.is_acknowledged = false;
}

void act_tick(Memory &m, int count, const HeaveWinch &winch) {
    const ActSeen seen = act_seen(m, winch);
    read_raw(m, count, winch);
    const Acting on = acting(m, seen);
    std::copy_n(m.filter_state.x, IMAGE.command.states, m.loop.estimate);
    std::copy_n(m.motion.state, IMAGE.command.states, m.loop.mean_state);
    m.asks = act(on);
    if (m.asks & NEEDS_PLAN) {  // without a plan the governor alone keeps the limits of the winch
        m.law.has_plan = m.law.plan_age = 0;
        std::fill_n(m.law.correction, int(FOLLOWED), 0.0);
        follow_plan(IMAGE.winch, IMAGE.law, m.problem, m.law);
        m.command.asked = m.law.command;
        make(on);
    }
    leave(on);
    if (m.order.cause != 0.0 && int(m.order.cause) != m.cause) m.is_taken_over = true;
    m.cause = int(m.order.cause);
    m.sent[0] = m.done.own_payout;
    m.sent[1] = m.done.own_rate;
    m.sent[2] = m.done.brake;
}

HeaveOrder ordered(const Memory &m) {
    const ActDone &done = m.done;
    const double lowered = m.motion.mean.payout + m.motion.left_over.payout;
    const double depth = m.has_begun || std::isnan(m.first_count) ? lowered : m.first_count;
    return {done.payout, done.rate, done.mean_payout, depth, done.brake != 0.0, m.number, m.mode.mode, int(m.decided.gates), m.decided.authority,
            int(m.tick.lost_sensors), m.attempts.harm, m.cause, int(m.decided.happened), m.asks};
}

void step(Memory &m, const HeaveReading *readings, int count, const HeaveWinch &winch) {
    m.number++;
    sense_tick(m, readings, count, winch);
    prove_tick(m, count, winch);
    watch_orders(m, winch);
    decide(m);
    act_tick(m, count, winch);
}

void begin(Memory &m) {
    std::memset(&m, 0, sizeof m);
    std::memcpy(&m.filter, &IMAGE.filter, sizeof m.filter);
    m.motion = IMAGE.motion;
    m.mode = IMAGE.mode;
    m.place = IMAGE.place;
    std::memcpy(&m.command_state, &IMAGE.command_state, sizeof m.command_state);
    begin_filter(m.filter, m.filter_state);
    begin_sense(IMAGE.sense, m.sense);
    m.sense.sea.applied = 1.0;
    begin_proofs(IMAGE.proofs, m.proofs);
    m.proofs.consent = IMAGE.consent;
    begin_landing(m.landing);
    begin_guard(m.guard);
    begin_supervision(m.supervision);
    begin_envelope(m.envelope);
    begin_load_watch(IMAGE.load, m.load);
    restart_law(m.law);
    m.readings.target = m.readings.reference = m.first_count = NOT_KNOWN;
    m.readings.kind = STAND;
    m.sent[2] = 1.0;
}

}  // namespace

}  // namespace heave

extern "C" {

size_t heave_controller_size(void) { return sizeof(heave::Memory); }

void *heave_controller_only(void) {
    static heave::Memory only;
    return &only;
}

void heave_controller_begin(void *memory) { heave::begin(*static_cast<heave::Memory *>(memory)); }

void heave_controller_step(void *memory, const HeaveReading *readings, int count, const HeaveWinch *winch, HeaveOrder *order) {
    heave::Memory &m = *static_cast<heave::Memory *>(memory);
    heave::step(m, readings, std::min(count, int(heave::READINGS_MOST)), *winch);
    *order = heave::ordered(m);
}

int heave_controller_request(void *memory, int mode) {
    heave::Memory &m = *static_cast<heave::Memory *>(memory);
    const int events[] = {-1, heave::ON_ASK_STANDBY, heave::ON_ASK_COMPENSATING, -1, -1, -1, -1, heave::ON_ASK_STOPPED,
                          heave::ON_ASK_EMERGENCY_STOP};
    if (mode < 0 || mode > HEAVE_EMERGENCY_STOP || events[mode] < 0) return 0;
    heave::release_attempts({heave::IMAGE.guard, heave::IMAGE.attempts, m.guard, m.attempts});
    m.is_acknowledged = true;
    if (m.order.phase == heave::HELD) m.is_taken_over = false;
    heave::ask(m.proofs, false);
    m.mode.known_fault = int(m.situation.winch_fault);
    return heave::take_event(heave::IMAGE.modes, m.situation, events[mode], m.mode);
}

}
