// The C interface. Sizes and the number of the layout are asked for by whoever loads the library, before anything else.
#include "act.h"
#include "modes.h"
#include "pass.h"
#include "proofs.h"
#include "sense.h"
#include "supervise.h"
#include "tick.h"

extern "C" {

long long heave_core_layout() { return heave::LAYOUT; }

long long heave_core_size(int structure) {
    const int count = sizeof heave::STRUCTURE_SIZES / sizeof *heave::STRUCTURE_SIZES;
    return structure >= 0 && structure < count ? heave::STRUCTURE_SIZES[structure] : 0;
}

// A tick, from a stage of it on, on addresses that Python fills once; returns the stage at which it is to be called again.
int heave_core_tick(const heave::Control *on, int from) { return heave::control(*on, from); }

// The envelope begins: the brake is on, and nothing was read yet.
void heave_core_begin(heave::State *state) { heave::begin_envelope(*state); }

// The envelope alone for a tick: raw readings and the controller's order in, the order that leaves out.
void heave_core_envelope(const heave::Design *design, heave::State *state, const heave::Readings *readings, heave::Order *order) {
    heave::envelope(*design, *state, *readings, *order);
}

// Begin: the filter knows nothing yet.
void heave_core_filter_begin(const heave::Filter *filter, heave::FilterState *state) { heave::begin_filter(*filter, *state); }

// A run of ticks of the filter with their readings; each leaves what it said.
void heave_core_filter(const heave::Filter *filter, heave::FilterState *state, const heave::FilterTick *ticks, int count,
                       const heave::Reading *readings, heave::Said *said) {
    heave::run_filter(*filter, *state, ticks, count, readings, said);
}

// A pass over a record: state x (n, c) and P (n, n) in place, work (n, c + 2 n), innovations (m, c) over the standard
// deviation that was predicted, and its square (m,).
void heave_core_pass(const heave::Pass *pass, const heave::PassTick *ticks, const double *commands,
                     const heave::PassReading *readings, const double *rows, const double *values, double *x, double *P,
                     double *work, double *innovations, double *variances) {
    heave::run_pass(*pass, ticks, {readings, rows, values, innovations, variances}, commands, x, P, work);
}

// Readings of the encoder under set-points, of each of several drums, (count, ticks).
void heave_core_servo(const heave::ServoRun *run, const double *sent, const heave::Servo *servos,
                      const heave::ServoStart *starts, int count, double *readings) {
    const heave::SetPoints points = heave::set_points(sent, run->sent);
    for (int i = 0; i < count; i++)
        heave::servo_record(*run, points, servos[i], starts[i], run->ticks, readings + i * run->ticks);
}

// Motions of a tick again, after the state has jumped; the jumps of the simulated units.
void heave_core_look_again(const heave::LookDesign *design, const heave::LookState *state, const heave::LookInputs *inputs,
                           const double *estimate, const double *mean_state, heave::Motions *motions) {
    heave::find_motions(*design, *state, *inputs, {estimate, mean_state, nullptr}, *motions);
}

void heave_core_look_begin_share(const heave::LookDesign *design, heave::LookState *state) { heave::begin_share(*design, *state); }

void heave_core_look_continue_shadow(const heave::LookDesign *design, heave::LookState *state, double heave, double rate) {
    heave::continue_shadow(*design, *state, {heave, rate});
}

void heave_core_look_continue_hanging(const heave::LookDesign *design, heave::LookState *state, double heave, double rate) {
    heave::continue_at(design->cable, state->hanging, {heave, rate});
}

void heave_core_look_take_unit(const heave::LookDesign *design, heave::LookState *state, double heave, double rate) {
    heave::take_unit(*design, *state, {heave, rate});
}

// The guard: the demand under another design, the jumps.
void heave_core_guard_demand(const heave::GuardDesign *design, const heave::GuardState *state, heave::Verdict *verdict) {
    heave::judge_demand(*design, state->demand, *verdict);
}

void heave_core_guard_begin(heave::GuardState *state) { heave::begin_guard(*state); }

void heave_core_guard_allow_resumption(const heave::GuardDesign *design, heave::GuardState *state) { heave::allow_resumption(*design, *state); }

void heave_core_guard_reset_mismatch(heave::GuardState *state) { heave::reset_mismatch(*state); }

void heave_core_landing_begin(heave::LandingState *state) { heave::begin_landing(*state); }

// What the rolling window holds.
void heave_core_kpi(const heave::KpiDesign *design, const heave::KpiState *state, const heave::KpiRow *rows, heave::KpiWindow *window) {
    heave::summarise(*design, *state, rows, *window);
}

// The drum watch: a tick, a drum at rest.
void heave_core_drum_add(const heave::DrumWatchDesign *design, heave::DrumWatchState *state, heave::DrumRow *rows, double *work, const heave::DrumRow *row) {
    heave::add(*design, *state, {rows, work}, *row);
}

void heave_core_drum_reset(const heave::DrumWatchDesign *design, heave::DrumWatchState *state, heave::DrumRow *rows, double *work, double payout) {
    heave::reset_drum(*design, *state, {rows, work}, payout);
}

// Who is silent.
void heave_core_link_silence(const heave::LinkDesign *design, heave::LinkState *state, int has_state, double untaken) {
    heave::note_silence(*design, *state, has_state, untaken);
}

// The largest speed from which half an acceleration is enough to stop after a distance.
double heave_core_approach_speed(double distance, double acceleration, double lag) {
    return heave::approach_speed(distance, acceleration, lag);
}

// A law without a plan, away from the limits.
void heave_core_restart_law(heave::LawState *state) { heave::restart_law(*state); }

// Asks a law for its command; returns 1 where Python is to make the plan, whose correction `heave_core_follow_plan` follows.
int heave_core_ask_law(const heave::ActiveWinch *winch, const heave::Law *law, const heave::Problem *problem, heave::LawState *state) {
    heave::ask_law(*winch, *law, *problem, *state);
    return state->asks;
}

void heave_core_follow_plan(const heave::ActiveWinch *winch, const heave::Law *law, const heave::Problem *problem, heave::LawState *state) {
    heave::follow_plan(*winch, *law, *problem, *state);
}

void heave_core_load_begin(const heave::LoadWatchDesign *design, heave::LoadWatchState *state) { heave::begin_load_watch(*design, *state); }

// The mode machine: a tick, which returns the event that was taken, -1: none; an event of an operator or the load, which
// returns 1 where a row was taken.
int heave_core_modes_event(const heave::ModeDesign *design, const heave::Situation *situation, int event, heave::ModeState *state) {
    return heave::take_event(*design, *situation, event, *state);
}

int heave_core_modes_request(const heave::ModeDesign *design, const heave::Situation *situation, int event, heave::ModeState *state) {
    return heave::request_mode(*design, *situation, event, *state);
}

int heave_core_modes_missing(const heave::ModeDesign *design, const heave::Situation *situation, int event, const heave::ModeState *state) {
    return heave::missing_guards(*design, *situation, event, *state);
}

// Attempts: an operator asks, a belief has been corrected.
void heave_core_attempts_release(const heave::GuardDesign *guard, const heave::AttemptDesign *design, heave::GuardState *guard_state, heave::AttemptState *state) {
    heave::release_attempts({*guard, *design, *guard_state, *state});
}

double heave_core_attempts_largest(const heave::AttemptDesign *design, const heave::AttemptState *state) {
    return heave::largest_residual(*design, *state);
}

int heave_core_attempts_awaits(const heave::AttemptDesign *design, const heave::AttemptState *state) {
    return heave::awaits_operator(*design, *state);
}

void heave_core_attempts_explain(heave::AttemptState *state) { heave::explain_attempt(*state); }

void heave_core_supervision_begin(heave::SupervisionState *state) { heave::begin_supervision(*state); }

void heave_core_supervision_reset_sea(heave::SupervisionState *state) { heave::begin_highest_tension(*state); }

// Proofs before the brake opens: begin; an operator asks for a mode.
void heave_core_proofs_begin(const heave::ProofDesign *design, heave::ProofState *state) { heave::begin_proofs(*design, *state); }

void heave_core_proofs_ask(heave::ProofState *state, int consent) { heave::ask(*state, consent); }

// The mean payout in motion: a tick of it, whether it moves, the ticks of its move that are left, and a tick of the loop's own
// answer to it with the model x' = A x + B u.
int heave_core_advance_mean(heave::MeanPayout *mean) { return heave::advance_mean(*mean); }

int heave_core_is_moving(const heave::MeanPayout *mean) { return heave::is_moving(mean->move); }

int heave_core_ticks_to_go(const heave::MeanPayout *mean, int longest) { return heave::ticks_to_go(*mean, longest); }

int heave_core_advance_motion(const double *A, const double *B, heave::MeanMotion *motion, int states, double command, int is_braked) {
    return heave::advance_motion(A, B, states, command, is_braked, *motion);
}

// What is sensed: begin; jumps.
void heave_core_sense_begin(const heave::SenseDesign *design, heave::SenseState *state) { heave::begin_sense(*design, *state); }

// A filter beside takes in the same tick, with a command as it takes it; it may be compared with the active one.
void heave_core_second(const heave::SenseDesign *design, const heave::Filter *filter, const heave::LookDesign *look,
                       const heave::MeanMotion *motion, heave::SenseState *state, heave::FilterState *filter_state,
                       heave::LookState *look_state, heave::Observed *found, heave::Observed *observed, heave::Reading *readings,
                       heave::Said *said, heave::Said *by_measurement, double *depths, const heave::Tick *tick, double command,
                       int compares, heave::Second *second) {
    heave::step_second({*design, *filter, *look, *motion, *state, *filter_state, *look_state},
                       {found, observed, readings, said, by_measurement, depths}, *tick, command, compares, *second);
}

void heave_core_restart_consistency(heave::SenseState *state) { heave::restart_consistency(*state); }

void heave_core_restart_tension(heave::SenseState *state) { heave::restart_tension(state->mean_tension); }

// The sea: begin; a tick, which returns 1 where its height has changed enough; an innovation of the heave rate; height and waves.
void heave_core_sea_begin(heave::SeaSeen *sea) { heave::begin_sea(*sea); }

int heave_core_sea(const heave::SeaDesign *design, double tick_period, heave::SeaSeen *sea, double heave, double rate) {
    return heave::update_sea(*design, tick_period, *sea, {heave, rate});
}

void heave_core_sea_innovation(const heave::SeaDesign *design, double tick_period, heave::SeaSeen *sea, double nis, double sigma) {
    heave::note_innovation(*design, tick_period, *sea, nis, sigma);
}

double heave_core_sea_waves(const heave::SeaDesign *design, const heave::SeaSeen *sea) { return heave::waves_of(*design, *sea); }

void heave_core_restart_steps(heave::SenseState *state) { state->mru.time = heave::NOT_KNOWN; }

void heave_core_rescale_encoder(heave::SenseState *state, double factor, double payout) { heave::rescale(state->encoder, factor, payout); }

void heave_core_trust_encoder(heave::SenseState *state) { heave::trust(state->encoder); }

}
