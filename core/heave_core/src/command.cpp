// The command of a tick: the compensation problem that the law is given, the law's share with that of the mean payout,
// governed, and held within what the last minute of orders was.
#include "laws.h"

namespace heave {

namespace {

double row_of_both(const double *row, const Loop &loop, int states) {
    return dot(states, row, loop.estimate) + dot(states, row, loop.mean_state);
}

// Without a depth sensor the estimate of the unit is no better than the assumed MRU, load cell and cable: fed back in full it
// sends the drum after the errors of all three. What is more than those may be is there, and is to be damped. The swing is
// sqrt(z^2 + a z'^2).
void bound_unseen(const CommandDesign &design, double *x) {
    double &heave = x[design.unit[0]], &rate = x[design.unit[1]];
    const double swing = std::hypot(heave, std::sqrt(design.inertia) * rate);
    if (!(swing > design.largest_unseen)) return;
    const double kept = (design.largest_unseen + std::max(swing - design.unseen_error, 0.0)) / swing;
    heave *= kept;
    rate *= kept;
}

// Compensation of a share of the sea about a mean payout is the plain problem in shifted states: unit heave less
// (1 - share) of the uncompensated one, boom tip and waves times the share. The plant is linear in all of them, so that one
// law serves every authority, which may move at any time without a step in the command. The unit is to follow the mean
// payout stiffly, not to swing after it.
void shift_state(const CommandDesign &design, const Loop &loop, double *x) {
    std::copy(loop.estimate, loop.estimate + design.states, x);
    if (loop.way == BY_TENSION) return;
    double &heave = x[design.unit[0]], &rate = x[design.unit[1]];
    heave -= (1.0 - loop.share) * loop.heave;
    rate -= (1.0 - loop.share) * loop.rate;
    for (int i = 0; i < design.sea_states; i++) x[design.sea[i]] *= loop.share;
    heave += loop.swing;
    rate += loop.swing_rate;
    if (loop.is_unseen != 0.0) bound_unseen(design, x);
    x[design.payout] -= loop.left_over;
    heave += loop.left_over;
    for (int i = 0; i < design.states; i++)  // the unit's own lag is in its swing
        if (i != design.unit[0] && i != design.unit[1]) x[i] -= loop.lead_state[i];
}

// By how much a set-point is beyond the step that is allowed after a change of what is assumed [m/s].
double beyond(const Commanded &on, const CommandState &state, double sent) {
    if (state.easing == 0.0) return 0.0;
    const double more = on.design.more_acceleration * on.winch.tick_period;
    const double allowed = on.design.quicker * state.largest_step + more, step = sent - state.last_sent;
    return step - clip(step, -allowed, allowed);
}

// Least and largest speed of a fade-out: none is larger than in the minute before, and ever less is allowed; the way ends
// where it then ended. Where the last speed is outside, it comes back step by step.
void bound_fade(const Commanded &on, CommandState &state, Wanted &wanted) {
    wanted.least = NOT_KNOWN;
    if (on.loop.fades == 0.0) {
        state.fading = 0.0;
        return;
    }
    const bool waits = on.loop.is_held != 0.0 && state.fading > 0.0;
    state.longest = on.design.longest_fade;
    state.fading = std::min(state.fading + (waits ? 0.0 : on.winch.tick_period), state.longest);
    const double largest = state.largest_speed * (1.0 - state.fading / state.longest);
    const double end = on.design.more_travel * state.largest_travel + on.design.more_room;
    const auto towards = [&](double way) {
        return std::min(largest, approach_speed(std::max(end - way * state.travel, 0.0), on.winch.acceleration, on.winch.lag));
    };
    wanted.least = std::min(-towards(-1.0), state.speed + on.design.stop_step);
    wanted.most = std::max(towards(1.0), state.speed - on.design.stop_step);
}

// Speeds that are ordered, and the travel that they make, over a minute: e' = v - e / minute.
void note_order(const Commanded &on, CommandState &state) {
    const double dt = on.winch.tick_period, kept = 1.0 - dt / on.design.minute, speed = state.value - state.standing;
    if (state.easing == 0.0) state.largest_step = std::max(std::abs(state.sent - state.last_sent), kept * state.largest_step);
    state.last_sent = state.sent;
    state.easing = std::max(state.easing - dt, 0.0);
    state.speed = speed;
    state.travel = kept * state.travel + speed * dt;
    if (state.fading != 0.0) return;
    state.largest_speed = std::max(std::abs(speed), kept * state.largest_speed);
    state.largest_travel = std::max(std::abs(state.travel), kept * state.largest_travel);
}

// The last order, slower by a step: the winch comes to rest whatever is estimated. Where the drum stands under a position
// loop is the way of the orders since the last one that was given by the estimate.
void slow_down(const Commanded &on, CommandState &state, Command &command) {
    if (on.winch.is_first_order) {  // it goes to its last set-point, and stays
        command.standing = state.value;
        command.shaped = state.shaped;
    } else {
        double sent = state.sent - state.standing;
        // of an order that the envelope has replaced its own part goes on
        const bool is_replaced = int(state.shaped) & BY_ENVELOPE;
        const double speed = is_replaced ? gain_at(on.winch, sent) * sent : state.value - state.standing;
        const double slower = std::copysign(std::max(std::abs(speed) - on.design.stop_step, 0.0), speed);
        command.standing = state.standing + on.winch.position_gain * slower * on.winch.tick_period;
        // what is sent falls with it: a servo that needs more than its speed gets less of that too
        sent *= speed != 0.0 ? slower / speed : 0.0;
        command.shaped = 0.0;
        state.value = slower + command.standing;
        state.sent = sent + command.standing;
    }
    command.asked = state.value - on.loop.mean_command;
}

// Pays out more than is asked for where the tension is above the highest one: the excess over the stiffness, in a time.
void give_way(const Commanded &on, Command &command) {
    const double over = on.loop.filtered_tension - on.winch.most_tension;
    if (on.loop.gives_way == 0.0 || on.winch.is_first_order || !(over > 0.0)) return;
    command.asked += over / (on.design.stiffness * on.design.giving_time);
    command.gives_way = 1.0;
}

void govern_command(const Commanded &on, const Problem &problem, CommandState &state, Command &command) {
    Wanted wanted{};
    wanted.command = command.asked + problem.command;
    wanted.payout = command.payout;
    wanted.rate = command.rate;
    wanted.tension = std::isfinite(on.loop.tension) ? on.loop.tension : problem.static_tension;
    wanted.lowest = on.loop.lowest;
    wanted.highest = on.loop.highest;
    bound_fade(on, state, wanted);
    const Governed governed = govern(on.winch, wanted);
    const double less = beyond(on, state, governed.sent);
    state.value = less != 0.0 ? governed.value - less * gain_at(on.winch, less) : governed.value;
    state.sent = governed.sent - less;
    command.shaped = governed.shaped;
}

}  // namespace

// The problem that the law is given, and the command under which the winch would stay where it is.
void pose_problem(const Commanded &on, Problem &problem, Command &command) {
    const CommandDesign &design = on.design;
    const Loop &loop = on.loop;
    const int n = design.states;
    const double payout = dot(n, design.payout_ahead, loop.mean_state), rate = dot(n, design.rate_ahead, loop.mean_state);
    problem.payout = payout + dot(n, design.payout_ahead, loop.lead_state);
    problem.rate = rate + dot(n, design.rate_ahead, loop.lead_state);
    problem.command = loop.mean_command + loop.lead_command;
    problem.static_tension = on.winch.static_tension - design.stiffness * dot(n, design.payout_row, loop.lead_state);
    problem.measured_tension = loop.filtered_tension;
    problem.mru_rate = loop.mru_rate;
    problem.bounds_tension = loop.bounds_tension;
    const double out = speed_by(on.winch, loop.highest) - problem.rate, in = problem.rate - speed_by(on.winch, loop.lowest);
    problem.speed = on.winch.is_first_order ? ANY : std::max(out, in);
    shift_state(design, loop, problem.x);
    command = Command{};
    command.payout = payout + dot(n, design.payout_ahead, loop.estimate);
    command.rate = rate + dot(n, design.rate_ahead, loop.estimate);
    const bool is_first_order = on.winch.is_first_order;
    command.standing = is_first_order ? row_of_both(design.payout_row, loop, n) : on.winch.position_gain * command.payout;
}

// Asks what the mode calls for; returns what Python is asked for.
int ask_command(const Commanded &on, const Law &law, const Problem &problem, LawState &law_state, CommandState &state,
                Command &command) {
    const double gain = on.winch.is_first_order ? 1.0 : on.winch.position_gain;
    switch (int(on.loop.way)) {
        case BY_LAW:
            ask_law(on.winch, law, problem, law_state);
            command.asked = law_state.command;
            command.by_plan = law_state.by_plan;
            command.has_plan = law_state.has_plan;
            return law_state.asks;
        case BY_FADE: command.asked = dot(on.design.states, on.design.fade, problem.x); return 0;
        case BY_SETTLING: command.asked = dot(on.design.states, on.design.settling, problem.x); return 0;
        // the drum stays where it is about the mean payout, which the operator moves
        case BY_PLACE: command.asked = command.standing - gain * problem.payout; return 0;
        case BY_TENSION: return ask_tension(on, problem, state.tension, command);
        default: return 0;
    }
}

// Makes the command of what was asked for.
void make_command(const Commanded &on, const Problem &problem, CommandState &state, Command &command) {
    const int way = int(on.loop.way);
    if (way == BY_BRAKE) {
        state.value = state.sent = command.standing;
    } else if (way == BY_SLOWING) {
        slow_down(on, state, command);
    } else {
        give_way(on, command);
        govern_command(on, problem, state, command);
    }
    state.standing = command.standing;
    state.shaped = command.shaped;
    const bool is_number = std::isfinite(command.asked);
    if (!is_number) state.value = state.sent = command.standing;  // of what is no number, nothing remembers anything
    command.value = state.value;
    command.sent = state.sent;
    command.compensating = state.value - on.loop.mean_command;
    command.mean = state.value - command.compensating;
    if (!is_number) command.sent = NOT_KNOWN;  // the envelope is to see it
    note_order(on, state);
}

}  // namespace heave
