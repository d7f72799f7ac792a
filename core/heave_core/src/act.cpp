// The acting half of a tick: the command of the laws, the mean payout, the set-points, the envelope in front of the winch,
// the checks of load and travel, the place that a drive is to follow, and what is noted of the tick.
#include "act.h"

namespace heave {

namespace {

// What the encoder reads at a payout, its jumps included: a drive's position loop counts by it.
double count_at(const ActSeen &seen, double payout) { return seen.scale * (payout + seen.offset); }

// Command with which the winch moves by a payout: its rate, and the lag of the winch ahead.
double command_for(const ActiveWinch &winch, double payout, double rate, double acceleration) {
    if (winch.is_first_order) return payout + rate / winch.position_rate;
    return rate + winch.lag * acceleration + winch.position_gain * payout;
}

// Share of the command that moves the mean payout.
double reference_command(const ActiveWinch &winch, const MeanMotion &motion) {
    const MeanPayout &mean = motion.mean, &carried = motion.carried;
    return command_for(winch, mean.payout + carried.payout, mean.move.rate + carried.move.rate,
                       mean.move.slope + carried.move.slope);
}

// Share of the command with which the drum leads the mean payout u by a u'' + b u': the unit then moves as that does, since
// a z'' + b z' + z = -payout has z = -u. Only where a law moves the drum: in mode manual that goes as the mean payout does.
void lead(const Acting &on) {
    const CommandDesign &design = *on.design;
    const ActiveWinch &winch = *on.winch;
    const Move &move = on.motion->mean.move;
    double &last = on.state->lead, *state = on.motion->lead;
    const double before = last;
    const int way = int(on.loop->way);
    if (way != BY_LAW && way != BY_FADE && way != BY_SETTLING) {
        std::fill_n(state, design.states, 0.0);
        on.loop->lead_command = last = 0.0;
    } else {
        last = design.inertia * move.slope + design.damping * move.rate;
        // its acceleration would take the jerk's derivative: the lag of the winch is not made up for
        on.loop->lead_command = command_for(winch, last, (last - before) / winch.tick_period, 0.0);
    }
    std::copy_n(state, design.states, on.loop->lead_state);
}

// What the command must know of the loop. Where the boom tip is not known the unit is to come to rest, and while it is damped
// for that a fade-out goes on for longer.
void fill_loop(const Acting &on) {
    const ActSeen &seen = *on.seen;
    const Motions &motions = *on.motions;
    Loop &loop = *on.loop;
    const bool knows_tip = seen.knows_tip != 0.0, is_held = knows_tip && seen.compensates != 0.0;
    loop.way = seen.way;
    loop.share = knows_tip ? seen.authority : 0.0;
    loop.heave = !knows_tip ? 0.0 : is_held ? motions.taut : motions.released;
    loop.rate = !knows_tip ? 0.0 : is_held ? motions.taut_rate : motions.released_rate;
    loop.swing = motions.mean_heave;
    loop.swing_rate = motions.mean_rate;
    loop.is_unseen = is_held && seen.has_depth == 0.0;
    loop.left_over = on.motion->left_over.payout;
    lead(on);
    loop.mean_command = reference_command(*on.winch, *on.motion);
    loop.mru_rate = seen.authority * (std::isnan(seen.mru_rate) ? motions.tip_rate : seen.mru_rate);
    loop.tension = seen.tension;
    loop.filtered_tension = seen.filtered_tension;
    // a winch that gives way to more than compensation can keep would be too late for the next wave
    loop.gives_way = seen.bounds_tension != 0.0 || (seen.compensates == 0.0 && seen.fades == 0.0);
    loop.bounds_tension = seen.bounds_tension;
    loop.fades = seen.fades;
    loop.is_held = seen.is_damped != 0.0 && !knows_tip;
    loop.follows_tip = seen.follows_tip;
    loop.unit_stands = seen.unit_stands;
    const bool is_bounded = on.envelope && on.order->lowest < on.order->highest;  // by the envelope's last tick
    loop.lowest = is_bounded ? on.order->lowest : -ANY;
    loop.highest = is_bounded ? on.order->highest : ANY;
}

// The set-points of the command. A servo on its brake is asked for no speed; the model's command counts what the winch's
// position loop makes of the payout set-point as well.
void make_order(const Acting &on) {
    const ActSeen &seen = *on.seen;
    const double sent = on.command->sent, gain = on.winch->position_gain;
    const bool is_braked = seen.brake != 0.0;
    ActDone &done = *on.done;
    const MeanMotion &motion = *on.motion;
    done.moved = advance_motion(on.A, on.B, on.design->states, on.command->mean, is_braked, *on.motion);
    advance_state(on.A, on.B, on.design->states, on.loop->lead_command, on.motion->lead);
    const double mean = motion.mean.payout + motion.left_over.payout + motion.carried.payout;
    const bool is_known = std::isnan(seen.stated_payout);
    const double set_point = done.set_point = is_known ? mean : seen.stated_payout;
    done.depth_set_point = is_known ? motion.mean.payout + motion.left_over.payout : seen.stated_payout;
    if (on.winch->is_first_order) {
        done.own_payout = sent;
        done.own_rate = 0.0;
    } else if (is_braked) {
        done.own_payout = gain > 0.0 ? sent / gain : set_point;
        done.own_rate = 0.0;
    } else {
        done.own_payout = set_point;
        done.own_rate = sent - gain * set_point;
    }
    on.readings->payout = count_at(seen, done.own_payout);
    on.readings->rate = done.own_rate;
    on.readings->brake = seen.brake;
}

// What was sent takes the place of what was asked: estimate, adviser and the next stop go by it.
void take_sent(const Acting &on) {
    const Readings &asked = *on.readings;
    const Order &sent = *on.order;
    Command &command = *on.command;
    CommandState &state = *on.state;
    if (sent.brake != 0.0) {
        command.value = command.sent = command.standing;
        command.shaped = state.shaped = 0.0;
    } else {
        const bool is_whole = std::isfinite(asked.payout) && std::isfinite(asked.rate);
        const double more = on.winch->is_first_order ? sent.payout - asked.payout : sent.rate - asked.rate;
        if (is_whole) {
            command.value += more * gain_at(*on.winch, more);
        } else {
            command.value = command.sent = command.standing + sent.rate;
        }
        state.shaped = int(state.shaped) | BY_ENVELOPE;
        command.shaped = int(command.shaped) | BY_ENVELOPE;
    }
    command.compensating = command.value - command.mean;
    state.value = command.value;
    state.sent = command.sent;
    ActDone &done = *on.done;
    const double more = sent.payout - asked.payout, faster = sent.rate - asked.rate;
    const bool is_known = std::isfinite(more + faster);
    done.own_payout = is_known ? done.own_payout + more : sent.payout;
    done.own_rate = is_known ? done.own_rate + faster : sent.rate;
}

// Speed servos are sent the place of their speed, and the same speed by it.
void send_place(const Acting &on) {
    const ActSeen &seen = *on.seen;
    ActDone &done = *on.done;
    done.payout = on.order->payout;
    done.rate = on.order->rate;
    done.brake = on.order->brake;
    done.mean_payout = count_at(seen, done.set_point);
    if (on.winch->is_first_order) return;
    const bool is_braked = done.brake != 0.0;
    const double gain = on.winch->position_gain;
    const double held = is_braked ? 0.0 : gain * (done.payout - count_at(seen, on.command->payout)), speed = done.rate + held;
    if (!std::isfinite(speed)) return;
    const double drum = on.motions->payout + on.motions->mean_payout;
    const double place = place_at_end(*on.place, on.winch->tick_period, speed, drum, is_braked);
    const double payout = count_at(seen, place);
    done.rate += is_braked ? 0.0 : gain * (done.payout - payout);
    done.payout = payout;
}

void note_kpi(const Acting &on) {
    const ActSeen &seen = *on.seen;
    const Motions &motions = *on.motions;
    const bool knows_tip = seen.knows_tip != 0.0, knows_unit = knows_tip || seen.sees_landing != 0.0;
    const double unit = knows_unit ? motions.unit : NOT_KNOWN, free = knows_tip ? motions.free : NOT_KNOWN;
    const double tip = knows_tip ? motions.tip : NOT_KNOWN;
    add(*on.kpi, *on.kpi_state, on.kpi_rows, {unit, free, tip, motions.payout, motions.total_payout_rate, 0.0, seen.tension, 0.0});
}

}  // namespace

// The place p at the end of a tick: p' = v + (u - p) / leak, the integral of the speed v that is sent, from where the drum u is
// when its brake opens. A drum that follows p through a lag moves as one that follows v through the same lag. The leak takes
// out what adds up where a drive goes by v alone, with another gain.
double place_at_end(Place &place, double tick_period, double rate, double payout, bool is_braked) {
    if (is_braked || std::isnan(place.payout)) place.payout = payout;
    if (is_braked) return payout;
    place.payout += tick_period * (rate + (payout - place.payout) / place.leak);
    place.payout = clip(place.payout, payout - place.reach, payout + place.reach);
    return place.payout;
}

// Poses the problem of the tick.
void pose(const Acting &on) {
    fill_loop(on);
    pose_problem({*on.winch, *on.design, *on.loop}, *on.problem, *on.command);
}

// Makes command and set-points of what was asked for.
void make(const Acting &on) {
    make_command({*on.winch, *on.design, *on.loop}, *on.problem, *on.state, *on.command);
    make_order(on);
}

// Asks for the command of a problem that was posed; returns what Python is asked for first, 0 where it is made.
int answer(const Acting &on) {
    const int asks = ask_command({*on.winch, *on.design, *on.loop}, *on.law, *on.problem, *on.law_state, *on.state, *on.command);
    if (asks == 0) make(on);
    return asks;
}

// The order leaves, within the envelope; what is sent is what all go by.
void leave(const Acting &on) {
    Order &sent = *on.order;
    Readings &asked = *on.readings;
    ActDone &done = *on.done;
    asked.lift_rate = on.motion->carried.move.rate;
    asked.held_tension = on.state->tension.target;
    if (on.envelope) envelope(*on.envelope, *on.envelope_state, asked, sent);
    else {
        sent.payout = asked.payout;
        sent.rate = asked.rate;
        sent.brake = asked.brake;
    }
    const bool is_same = sent.payout == asked.payout && sent.rate == asked.rate && (sent.brake != 0.0) == (asked.brake != 0.0);
    done.is_replaced = on.envelope && !is_same;
    done.load_news = watch_load(*on.load, *on.load_state, on.seen->tension, on.seen->static_tension, on.seen->at_limit != 0.0) |
                     watch_travel(*on.load, *on.load_state, on.command->half_travelled != 0.0, on.command->at_travel != 0.0);
    if (done.is_replaced != 0.0) take_sent(on);
    send_place(on);
    if (on.kpi_rows) note_kpi(on);
}

}  // namespace heave
