// Constant tension: the winch follows the boom tip and corrects what is left of the tension's error slowly. Without the motion
// reference unit tension and drum lead alone: the mean of the tension over the time of a wave down the wire and back, over its
// stiffness, and the mean of the payout at both its ends are the boom tip half that time ago and a constant. A Kalman filter
// with the assumed sea, of a stationary gain that was designed with it, predicts the boom tip from there.
#include "laws.h"

namespace heave {

void note_tension(TensionRecord &record, double tension, double payout) {
    record.newest = (record.newest + 1) % TENSION_TICKS;
    record.count = std::min(record.count + 1, record.kept);
    record.tensions[record.newest] = tension;
    record.payouts[record.newest] = payout;
}

namespace {

int place(const TensionRecord &record, int ticks) { return (record.newest - ticks + TENSION_TICKS) % TENSION_TICKS; }

// Over the window, or over what there is [N]
double mean_tension(const TensionAlone &alone, const TensionRecord &record) {
    double sum = 0.0, weights = 0.0;
    for (int i = 0; i < std::min(alone.window, record.count); i++) {
        sum += alone.weights[i] * record.tensions[place(record, i)];
        weights += alone.weights[i];
    }
    return sum / weights;
}

double along(double value, double target, double step) { return value + clip(target - value, -step, step); }

// The tension that is held, on its way to the one asked for.
double advance_set_point(TensionState &state, double dt) {
    const double step = state.slope * dt;
    return state.value = along(state.value, state.target, step);
}

// What of a correction keeps the bound on travel, which is averaged so that it does not count the waves [m/s].
double bound_travel(const TensionLaw &law, TensionState &state, double correction, double outlet) {
    if (!std::isfinite(state.origin)) state.origin = outlet;
    state.travel += law.travel_share * (outlet - state.origin - state.travel);
    const bool is_used = std::abs(state.travel) >= state.required + state.bound;
    return is_used && correction * state.travel > 0.0 ? 0.0 : correction;
}

}  // namespace

// A reading of the boom tip half a round trip ago, and the constant [m].
double read_tip(const TensionAlone &alone, const TensionRecord &record) {
    const double before = record.payouts[place(record, std::min(alone.trip, record.count - 1))];
    return mean_tension(alone, record) / alone.stiffness + 0.5 * (record.payouts[record.newest] + before);
}

// Goes on from a state of the model: of the sea, and what is left of the reading.
void begin_alone(const double *x, const TensionRecord &record, TensionAlone &alone) {
    const int n = alone.states - 1;
    for (int i = 0; i < n; i++) alone.x[i] = x[alone.sea[i]];
    alone.x[n] = read_tip(alone, record) - dot(n, alone.row, alone.x);
}

// x = A x + g (y - c A x); returns the rate of the boom tip for the next command [m/s].
double follow_tip(const TensionRecord &record, TensionAlone &alone) {
    const int n = alone.states;
    double predicted[ALONE_STATES];
    for (int i = 0; i < n; i++) predicted[i] = dot(n, alone.A + i * n, alone.x);
    const double innovation = read_tip(alone, record) - dot(n, alone.row, predicted);
    for (int i = 0; i < n; i++) alone.x[i] = predicted[i] + alone.gain[i] * innovation;
    return dot(n, alone.rate, alone.x);
}

// Above a unit that hangs tension and drum do not tell the boom tip, and the correction by the mean tension is left.
TensionRate lead_alone(const TensionRecord &record, double set_point, double largest, bool unit_stands, TensionAlone &alone) {
    const double stretch = (mean_tension(alone, record) - set_point) / alone.stiffness;
    const double correction = stretch / (unit_stands ? alone.standing : alone.hanging);
    return {unit_stands ? follow_tip(record, alone) : 0.0, clip(correction, -largest, largest)};
}

// Rate command = predicted rate of the boom tip + (tension - set-point) / (stiffness * time constant). Python is asked for what
// leads alone, once it is needed.
int ask_tension(const Commanded &on, const Problem &problem, TensionState &state, Command &command) {
    const TensionLaw &law = on.design.tension;
    const int n = on.design.states;
    const bool follows = on.loop.follows_tip != 0.0;
    if (!follows && state.has_alone == 0) return NEEDS_TENSION;
    const double *x = problem.x, measured = problem.measured_tension;
    const double newest = std::isfinite(on.loop.tension) ? on.loop.tension : measured;
    note_tension(state.record, newest, dot(n, on.design.payout_row, x) + problem.payout);
    if (state.begins) begin_alone(x, state.record, state.alone);
    state.begins = 0;
    const double share = state.tip_share = along(state.tip_share, follows, law.blend_step);
    if (share == 1.0) state.has_alone = 0;
    const double set_point = advance_set_point(state, on.winch.tick_period);
    const double asked = (measured - set_point) / (on.design.stiffness * law.time_constant);
    const TensionRate with_tip{dot(n, law.tip_rate, x), clip(asked, -law.speed, law.speed)};
    const bool stands = on.loop.unit_stands != 0.0;
    TensionRate alone = with_tip;
    if (state.has_alone) alone = lead_alone(state.record, set_point, on.winch.speed, stands, state.alone);
    const double correction = share * with_tip.correction + (1.0 - share) * alone.correction;
    const double bounded = bound_travel(law, state, correction, dot(n, law.outlet, x) + problem.payout);
    command.at_travel = bounded != correction;
    command.half_travelled = std::abs(state.travel) >= state.required + 0.5 * state.bound;
    command.asked = dot(n, law.standing, x) + share * with_tip.tip + (1.0 - share) * alone.tip + bounded;
    return 0;
}

}  // namespace heave
