// The controller on memory of its own: the tick of tick.cpp, and between its stages what a node does in Python.
#include "controller.h"

#include "image.h"
#include "tick.h"

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
    SupervisionSeen supervision_seen;
    Supervised decided;
    ActSeen act_seen;
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
    Given given;
    Active active;
    ReflexState reflex;  // nothing is found by it here
    Controlled controlled;
    double first_count;         // read before the payout is known [m]; NaN: none
    int number, cause, latched; // of the tick; of the envelope; for which it has taken over, 0: it has not
    bool has_begun;
    Work work;
};

Supervising supervising(Memory &m) {
    return {&IMAGE.sense, &m.sense, &m.tick, &IMAGE.supervision, &m.supervision, &m.supervision_seen, &m.decided, &IMAGE.landing,
            &m.landing, &IMAGE.guard, &m.guard, &m.verdict, &IMAGE.attempts, &m.attempts, &IMAGE.modes, &m.mode, &m.situation};
}

Acting acting(Memory &m) {
    return {&m.act_seen, &m.tick.motions, &IMAGE.winch, &IMAGE.command, &m.loop, &IMAGE.law, &m.problem, &m.law,
            &m.command_state, &m.command, IMAGE.A, IMAGE.B, &m.motion, IMAGE.has_envelope ? &IMAGE.envelope : nullptr,
            &m.envelope, &m.readings, &m.order, &m.place, &IMAGE.load, &m.load, nullptr, nullptr, nullptr, &m.controlled.acted};
}

Control controlled(Memory &m) {
    Work &work = m.work;
    return {&m.given, &m.active, work.delivered, &IMAGE.sense, &m.filter, &IMAGE.look, &m.sense, &m.filter_state, &m.look,
            work.found, work.observed, work.readings, work.said, work.by_measurement, work.depths, &m.tick,
            &IMAGE.proofs, &m.proofs, &work.proofs, &IMAGE.winch_watch, &m.winch_watch, m.drum_rows, work.drum, m.minute,
            nullptr, &m.reflex, &m.controlled, supervising(m), acting(m)};
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

// What comes at a tick.
void take_in(Memory &m, const HeaveReading *readings, int count, const HeaveWinch &winch) {
    for (int i = 0; i < count; i++) {
        const HeaveReading &one = readings[i];
        m.work.delivered[i] = {one.sensor, one.time, one.value, one.rate, one.roll, one.pitch, one.status, 0.0, NOT_KNOWN, one.sigma,
                               one.rate_sigma};
    }
    Given &given = m.given;
    given.number = m.number;
    given.readings = count;
    given.has_winch = winch.is_new;
    m.active.has_begun = begin_at_count(m, winch);
    m.active.stated_payout = m.has_begun ? NOT_KNOWN : m.first_count;
    given.cause = m.latched;
    if (!winch.is_new) return;
    given.winch_time = winch.time;
    given.encoder = winch.payout;
    given.encoder_rate = winch.rate;
    given.brake = winch.brake;
    given.fault = winch.fault;
    given.command = winch.sequence;
    given.limits_hit = winch.limits_hit;
}

// Does what follows from what was decided.
void follow_decision(Memory &m) {
    const int before = int(m.decided.before), mode = int(m.decided.mode);
    if (mode != before) change_mode(m, before, mode);
    // a landed load asks for constant tension, which is not made here
    if (int(m.decided.happened) & UNIT_EVENT) take_event(IMAGE.modes, m.situation, ON_ASK_STOPPED, m.mode);
}

// Without a plan the governor alone keeps the limits of the winch.
void do_without_plan(Memory &m) {
    m.law.has_plan = m.law.plan_age = 0;
    std::fill_n(m.law.correction, int(FOLLOWED), 0.0);
    follow_plan(IMAGE.winch, IMAGE.law, m.problem, m.law);
    m.command.asked = m.law.command;
}

HeaveOrder ordered(const Memory &m) {
    const ActDone &done = m.controlled.acted;
    const double lowered = m.motion.mean.payout + m.motion.left_over.payout;
    const double depth = m.has_begun || std::isnan(m.first_count) ? lowered : m.first_count;
    return {done.payout, done.rate, done.mean_payout, depth, done.brake != 0.0, m.number, m.mode.mode, int(m.decided.gates),
            m.controlled.authority, int(m.tick.lost_sensors), m.attempts.harm, m.cause, int(m.decided.happened), int(m.controlled.asks),
            int(done.load_news)};
}

void step(Memory &m, const HeaveReading *readings, int count, const HeaveWinch &winch) {
    m.number++;
    take_in(m, readings, count, winch);
    const Control on = controlled(m);
    for (int stage = control(on, SENSE); stage != DONE; stage = control(on, stage)) {
        if (stage == DECIDE) follow_sea(m);
        if (stage == POSE) follow_decision(m);
        if (stage == MAKE) do_without_plan(m);
    }
    const int cause = int(m.order.cause);
    if (cause != 0 && cause != m.cause) m.latched = cause;
    m.cause = cause;
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
    m.active = IMAGE.active;
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
    m.readings.acknowledged = 1.0;
    if (m.order.phase == heave::HELD) m.latched = 0;
    heave::ask(m.proofs, false);
    m.mode.known_fault = int(m.situation.winch_fault);
    return heave::take_event(heave::IMAGE.modes, m.situation, events[mode], m.mode);
}

}
