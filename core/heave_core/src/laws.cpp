// The laws. A linear one is u = m v - G x, with the share that the unit's own error may ask for bounded: less feedback of the
// unit only takes damping away from a plant that is stable by itself, whatever the error. A constrained one is u = -G x + c
// with the smallest correction c that keeps the winch's limits over a horizon; Python is asked for it (a quadratic programme)
// only where the limits shape the plan. At the limits G spares the command; away from them it slides back to the free gain.
#include "laws.h"

namespace heave {

namespace {

// What the mean payout takes of the acceleration when the command takes effect [m/s^2]
double acceleration_taken(const ActiveWinch &winch, const Problem &problem) {
    return (problem.command - (problem.rate + winch.position_gain * problem.payout)) / winch.lag;
}

double unit_share(const Law &law, const double *x) {
    return -(law.gain[law.unit[0]] * x[law.unit[0]] + law.gain[law.unit[1]] * x[law.unit[1]]);
}

// Whether the winch comes near its limits in following the boom tip, or in holding a unit that is far off, or did of late: a
// sea at the limits comes in groups.
bool are_near(const ActiveWinch &winch, const Law &law, const double *x, double unit_use, LawState &state) {
    const double speed = std::abs(dot(law.states, law.near_speed, x)) / speed_under(winch, winch.static_tension);
    const double acceleration = std::abs(dot(law.states, law.near_acceleration, x)) / winch.acceleration;
    state.near_share = std::max({speed, acceleration, unit_use, law.near_kept * state.near_share});
    state.is_near = state.near_share > (state.is_near ? law.near_ends : law.near_begins);
    return state.is_near;
}

// Whether the rows of the plan keep their bounds without a correction
bool keeps_bounds(const Law &law, const LawState &state) {
    for (int i = 0; i < law.ends[PLAN_KINDS - 1]; i++)
        if (!(state.planned[i] <= state.upper[i] && state.planned[i] >= state.lower[i])) return false;
    return true;
}

// A plan may ask for more than the acceleration limit at the start of a tick, to gain over all of it what the limit allows;
// noise alone should not. The drum does not accelerate under `standing`, but for the mean payout's motion.
double spared(const ActiveWinch &winch, const Law &law, const Problem &problem, double value) {
    const double taken = acceleration_taken(winch, problem) * winch.lag;
    const double standing = dot(law.states, law.standing, problem.x) - taken;
    const double step = (1.0 - law.spared) * winch.acceleration * winch.lag;
    return clip(value, standing - step, standing + step);
}

// Rows of the plan without a correction; the law's numbers are by state. Returns the largest tension about the static one [N].
double plan_freely(const Law &law, const double *x, LawState &state) {
    const int rows = law.ends[PLAN_KINDS - 1];
    std::fill(state.planned, state.planned + rows, 0.0);
    for (int j = 0; j < law.states; j++) {
        const double *column = law.rows + j * rows;
        for (int i = 0; i < rows; i++) state.planned[i] += column[i] * x[j];
    }
    const double *tensions = state.planned + law.ends[PLANNED_PAYOUT], *end = state.planned + rows;
    const double highest = tensions < end ? *std::max_element(tensions, end) : 0.0;
    for (int i = 0; i < rows; i++) state.planned[i] += state.seen[i];
    return std::max(highest, 0.0);
}

}  // namespace

// Rows of the plan without a correction, and their bounds, the mean payout's share taken off.
void bound_plan(const ActiveWinch &winch, const Law &law, const Problem &problem, LawState &state) {
    const int *ends = law.ends, rows = ends[PLAN_KINDS - 1];
    const double swing = plan_freely(law, problem.x, state);
    const double under = std::isfinite(winch.power) ? speed_under(winch, problem.static_tension + swing) : winch.speed;
    const double taken = acceleration_taken(winch, problem);
    const double asked = problem.command - winch.position_gain * problem.payout, fixed = problem.static_tension;
    const double none = std::numeric_limits<double>::infinity(), most = problem.bounds_tension ? winch.most_tension : none;
    const double middle[] = {-problem.rate, -taken, -asked};
    const double width[] = {under, winch.linear_step / winch.lag, winch.reach * under};
    const double about[] = {problem.speed, none, winch.reach * problem.speed};  // the mean payout, of the envelope
    for (int i = 0, kind = 0; i < rows; i++) {
        while (i >= ends[kind]) kind++;
        if (kind < PLANNED_PAYOUT) {
            state.lower[i] = std::max(middle[kind] - width[kind], -about[kind]);
            state.upper[i] = std::min(middle[kind] + width[kind], about[kind]);
        } else if (kind == PLANNED_PAYOUT) {
            const double mean = problem.payout + problem.rate * law.times[i - ends[PLANNED_SET_POINT]];
            state.lower[i] = winch.lowest - mean;
            state.upper[i] = winch.highest - mean;
        } else {
            state.lower[i] = winch.least_tension > 0.0 ? winch.least_tension - fixed : -none;
            state.upper[i] = most - fixed;
        }
    }
}

// The command of the constrained law: with the correction that was planned, or none.
void follow_plan(const ActiveWinch &winch, const Law &law, const Problem &problem, LawState &state) {
    double value = state.correction[state.since_solution] + state.seen_now + state.freedom * state.seen_free;
    for (int i = 0; i < law.states; i++)
        value -= (law.constrained[i] + state.freedom * law.free_less_constrained[i]) * problem.x[i];
    state.command = state.has_plan ? value : spared(winch, law, problem, value);
    state.asks = 0;
    state.since_solution = (state.since_solution + 1) % law.solve_ticks;
}

namespace {

// Solves when it is time: without a correction where all bounds are kept so, else Python is asked for one.
void ask_constrained(const ActiveWinch &winch, const Law &law, const Problem &problem, LawState &state) {
    state.by_plan = 1;
    if (state.since_solution > 0) {
        state.plan_age += 1;
        return follow_plan(winch, law, problem, state);
    }
    bound_plan(winch, law, problem, state);
    if (!keeps_bounds(law, state)) {
        state.freedom = 0.0;
        state.asks = NEEDS_PLAN;
        return;
    }
    state.freedom = 1.0 - law.kept * (1.0 - state.freedom);
    state.has_plan = state.plan_age = 0;
    std::fill(state.correction, state.correction + FOLLOWED, 0.0);
    follow_plan(winch, law, problem, state);
}

void ask_feedback(const ActiveWinch &winch, const Law &law, const Problem &problem, LawState &state) {
    const double share = unit_share(law, problem.x), largest = law.unit_share * std::min(winch.speed, problem.speed);
    if (law.plans && are_near(winch, law, problem.x, std::abs(share) / (law.unit_share * winch.speed), state))
        return ask_constrained(winch, law, problem, state);
    state.command = -dot(law.states, law.gain, problem.x) - share + clip(share, -largest, largest);
}

}  // namespace

void ask_law(const ActiveWinch &winch, const Law &law, const Problem &problem, LawState &state) {
    state.asks = state.by_plan = 0;
    switch (law.kind) {
        case LINEAR_LAW:
            state.command = law.reading_share * problem.mru_rate - dot(law.states, law.gain, problem.x);
            break;
        case FEEDBACK_LAW: ask_feedback(winch, law, problem, state); break;
        case CONSTRAINED_LAW: ask_constrained(winch, law, problem, state); break;
        case NO_LAW: state.command = 0.0; break;
        default: state.asks = NEEDS_LAW;
    }
}

// Without a plan, and away from the limits.
void restart_law(LawState &state) {
    state = LawState{};
    state.freedom = 1.0;
}

}  // namespace heave
