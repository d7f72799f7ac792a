// The mode machine: it runs the table of modes that the design holds, and moves authority between its ends.
#include "modes.h"

namespace heave {

namespace {

struct View {
    const ModeDesign &design;
    const Situation &situation;
    const ModeState &state;
};

double well_time(const View &view) { return view.situation.lost != 0.0 ? 0.0 : view.state.well_time; }

// Times the usual wait for which sensors must be good before compensation resumes.
double patience(const View &view) { return std::pow(view.design.loss_growth, std::max(view.state.losses - 1, 0)); }

int known_fault(const View &view) { return std::max(view.state.known_fault, 0); }

bool has_new_fault(const View &view) {
    const int fault = int(view.situation.winch_fault);
    return fault != 0 && (fault != known_fault(view) || view.state.time > view.design.released_time);
}

bool is_settled(const View &view) {
    return well_time(view) >= std::max(view.design.settling_time, view.design.release_time);
}

bool has_faded(const View &view) {
    const double longest = view.design.fade_out_time + view.design.settling_limit;
    const bool is_over = view.situation.is_settled != 0.0 || view.state.time > longest;
    return view.state.authority == 0.0 && is_over && !goes_on_blind(view.situation, view.state);
}

// Whether an event of a tick has happened.
bool happens(int event, const View &view) {
    const Situation &now = view.situation;
    const ModeState &state = view.state;
    switch (event) {
        case ON_WINCH_EMERGENCY_STOP: return now.is_emergency != 0.0 && has_new_fault(view);
        case ON_WINCH_FAULT: return has_new_fault(view);
        case ON_ENVELOPE: return now.envelope != 0.0;
        case ON_WINCH_SILENT: return now.winch_silent != 0.0;
        case ON_SENSOR_LOST: return std::max(state.lost_time, state.coasted) > view.design.coast_time;
        case ON_HARM: return now.harm != 0.0;
        case ON_SENSORS_BACK: return well_time(view) > view.design.back_time * patience(view);
        case ON_SETTLED: return is_settled(view);
        case ON_FADED: return has_faded(view);
        case ON_AT_REST:
            return now.speed < view.design.standstill ||
                   (state.time > view.design.stopping_limit && std::isfinite(now.speed));
        default: return false;
    }
}

bool resumes(const View &view) {
    return view.design.resumes && view.state.may_resume && well_time(view) > view.design.resume_time * patience(view);
}

// Guards of a row that do not hold, bits of ModeGuard.
int missing(int guards, const View &view) {
    const Situation &now = view.situation;
    const ModeState &state = view.state;
    const auto holds = [&](int guard) {
        switch (guard) {
            case IF_WANTED: return state.wants != 0;
            case IF_NO_HARM: return now.harm == 0.0;
            case IF_NO_FAULT: return now.winch_fault == 0.0;
            case IF_NEW_FAULT: return int(now.winch_fault) != known_fault(view);
            case IF_NOT_FOR_WANT_OF_COMMANDS: return now.is_automatic == 0.0;
            case IF_SENSORS_WELL: return state.lost_time == 0.0;
            case IF_GATES_OPEN: return now.gates_closed == 0.0;
            case IF_MAY_HOLD_TENSION: return now.tension_closed == 0.0;
            case IF_BRAKE_HELD: return state.time >= view.design.release_time;
            case IF_HAS_ENCODER: return now.encoder_lost == 0.0;
            case IF_SETTLED_ESTIMATE: return is_settled(view);
            case IF_RESTS_IN_STANDBY: return state.rest == IN_STANDBY;
            case IF_RESTS_STOPPED: return state.rest == IN_STOPPED;
            default: return resumes(view);
        }
    };
    int found = 0;
    for (int guard = 1; guard <= guards; guard <<= 1)
        if ((guards & guard) && !holds(guard)) found |= guard;
    return found;
}

void wait_for_operator(ModeState &state) { state.wants = state.may_resume = 0; }

// The share of the sea that unit and drum show: neither has to go elsewhere first.
double as_shown(const Situation &situation, const ModeState &state) {
    return std::min(situation.shown_authority, state.factor * situation.authority_limit);
}

void act(const ModeDesign &design, const Situation &situation, int action, ModeState &state) {
    switch (action) {
        case DO_WANT_COMPENSATION:
            state.wants = state.may_resume = 1;
            state.losses = 0;
            return;
        case DO_WANT_REST:
            state.wants = 0;
            state.may_resume = 1;
            state.losses = 0;
            return;
        case DO_END_IN_STANDBY: state.rest = IN_STANDBY; return;
        case DO_END_STOPPED: state.rest = IN_STOPPED; return;
        case DO_COMPENSATE_NOTHING: state.authority = 0.0; return;
        case DO_COMPENSATE_ALL: state.authority = state.factor; return;
        case DO_COMPENSATE_AS_SHOWN: state.authority = as_shown(situation, state); return;
        case DO_WAIT_FOR_OPERATOR: return wait_for_operator(state);
        case DO_COUNT_LOSS:
            if (++state.losses > design.most_losses) wait_for_operator(state);
            return;
        default: return;
    }
}

void enter(int mode, ModeState &state) {
    if (mode != IN_COMPENSATING && mode != IN_FADE_OUT) state.authority = 0.0;
    state.mode = mode;
    state.time = 0.0;
    if (mode == IN_COMPENSATING) state.coasted = 0.0;
}

void approach(double target, double step, ModeState &state) {
    state.authority += clip(target - state.authority, -step, step);
}

void count_time(const ModeDesign &design, const Situation &situation, ModeState &state) {
    const double dt = design.tick_period;
    const bool is_lost = situation.lost != 0.0;
    state.time += dt;
    state.lost_time = is_lost ? state.lost_time + dt : 0.0;
    state.coasted = is_lost ? state.coasted + dt : std::max(state.coasted - design.coast_recovery * dt, 0.0);
    if (situation.has_estimate == 0.0 || state.lost_time > design.hiccup) state.well_time = 0.0;
    else if (!is_lost) state.well_time += dt;
}

// Who asks for a mode that moves the winch wants a frozen encoder to be tried again: at rest it cannot show that it is good.
Situation tried(Situation situation, int event) {
    const bool moves = event == ON_ASK_COMPENSATING || event == ON_ASK_CONSTANT_TENSION || event == ON_ASK_MANUAL;
    if (moves && situation.encoder_frozen != 0.0) situation.encoder_lost = 0.0;
    return situation;
}

}  // namespace

// A fade-out goes on for as long as the boom tip is not known: no operator has asked for rest.
bool goes_on_blind(const Situation &situation, const ModeState &state) {
    return situation.is_damped_blind != 0.0 && state.wants;
}

bool is_braked(const ModeState &state) {
    return state.mode == IN_OFF || state.mode == IN_STANDBY || state.mode == IN_STOPPED || state.mode == IN_EMERGENCY_STOP;
}

bool may_resume(const ModeDesign &design, const Situation &situation, const ModeState &state) {
    return resumes({design, situation, state});
}

// Guards that keep the first row of an event from being taken, bits of ModeGuard; -1: there is no such row.
int missing_guards(const ModeDesign &design, const Situation &given, int event, const ModeState &state) {
    const Situation situation = tried(given, event);
    for (int i = 0; i < design.count; i++) {
        const ModeRow &row = design.rows[i];
        if (row.mode == state.mode && row.event == event) return missing(row.guards, {design, situation, state});
    }
    return -1;
}

// An operator who asks for a mode knows of the fault that is there, and the brake acknowledges it.
bool request_mode(const ModeDesign &design, const Situation &situation, int event, ModeState &state) {
    state.known_fault = int(situation.winch_fault);
    return take_event(design, tried(situation, event), event, state);
}

// Takes the first row of an event whose guards hold; returns whether there is one.
bool take_event(const ModeDesign &design, const Situation &situation, int event, ModeState &state) {
    for (int i = 0; i < design.count; i++) {
        const ModeRow &row = design.rows[i];
        if (row.mode != state.mode || row.event != event || missing(row.guards, {design, situation, state})) continue;
        for (const int action : row.actions) act(design, situation, action, state);
        if (row.target != state.mode) enter(row.target, state);
        return true;
    }
    return false;
}

// Advances by a tick; returns the event that was taken, -1: none.
int step_modes(const ModeDesign &design, const Situation &situation, ModeState &state) {
    if (state.known_fault < 0 || situation.winch_fault == 0.0) state.known_fault = int(situation.winch_fault);
    count_time(design, situation, state);
    if (state.mode == IN_FADE_OUT) {
        // a unit that is held at rest is held on once its sensor is back
        if (goes_on_blind(situation, state)) state.time = std::min(state.time, design.fade_out_time);
        else approach(0.0, design.tick_period / design.fade_out_time, state);
    }
    const View view{design, situation, state};
    const bool has_news = situation.lost + situation.winch_fault + situation.harm + situation.envelope != 0.0;
    if (state.mode != IN_COMPENSATING || has_news)
        for (int event = ON_WINCH_EMERGENCY_STOP; event < MODE_EVENTS; event++)
            if (happens(event, view) && take_event(design, situation, event, state)) return event;
    if (state.mode == IN_COMPENSATING) {
        if (state.time > design.forgiven) state.losses = 0;
        state.target = state.factor * situation.authority_limit;
        approach(state.target, design.tick_period / design.fade_in_time, state);
    }
    return -1;
}

}  // namespace heave
