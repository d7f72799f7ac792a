// The move that an operator has asked for, made here from the request alone: bounded in speed and acceleration, the
// acceleration building up over a time; near the target v = min(V, sqrt(a d), d / (4 lag)), so that it does not overshoot.
#include "parts.h"

namespace heave {

// v = min(sqrt(a d), d / (4 T)): half the acceleration is enough to stop after the distance; near its end the lag decides.
double approach_speed(double distance, double acceleration, double lag) {
    return std::min(std::sqrt(acceleration * distance), distance / (4.0 * lag));
}

namespace {

constexpr double ARRIVED = 0.005, AT_REST = 0.002;  // [m], [m/s]: the last millimetres are no motion

}  // namespace

bool is_moving(const Move &move) {
    const int kind = int(move.kind);
    if (kind == DRIVE) return true;
    if (kind == NONE || kind == STAND) return false;
    return std::abs(move.rate) > AT_REST || (kind == GO && std::abs(move.distance) > ARRIVED);
}

// `heave` is the largest of the window: the drum is so far from its mean.
void take_request(const Design &design, State &state, const Readings &readings, double heave) {
    Move &move = state.move;
    if (readings.request == move.request) return;
    move.request = readings.request;
    move.kind = readings.kind;
    const bool is_stated = std::isfinite(readings.speed) && std::isfinite(readings.acceleration);
    const double fastest = design.winch.speed, steepest = design.winch.acceleration;
    move.speed = is_stated ? clip(readings.speed, int(move.kind) == DRIVE ? -fastest : 0.0, fastest) : 0.0;
    move.acceleration = is_stated ? clip(readings.acceleration, 0.0, steepest) : design.envelope.stop_deceleration;
    if (int(move.kind) == STAND) move.rate = move.slope = 0.0;
    if (int(move.kind) != GO) return;
    // what the controller states is taken within what count or depth sensor make of the request
    const double by_count = readings.target - state.position;
    const double own = std::isfinite(readings.reference) ? readings.reference : by_count;
    const double room = design.envelope.move_tolerance + heave;
    const double distance = std::isfinite(readings.distance) ? readings.distance : 0.0;
    move.distance = std::isfinite(own) ? clip(distance, own - room, own + room) : distance;
}

void advance_move(Move &move, double dt, double jerk_time) {
    const double before = move.rate;
    const int kind = int(move.kind);
    if (kind == NONE || kind == STAND) return;
    if (kind == HALT) {
        move.rate = std::copysign(std::max(std::abs(before) - move.acceleration * dt, 0.0), before);
        move.slope = 0.0;
        return;
    }
    const double lag = std::max(jerk_time, 2.0 * dt), to_go = std::abs(move.distance);
    double wanted = 0.0;
    if (kind == DRIVE) wanted = move.speed;
    if (kind == GO) {
        const double approach = approach_speed(to_go, move.acceleration, lag);
        wanted = std::copysign(std::min(move.speed, approach), move.distance);
    }
    const double step = move.acceleration * dt / std::max(jerk_time, dt);
    const double slope = clip((wanted - before) / lag, move.slope - step, move.slope + step);
    move.slope = clip(slope, -move.acceleration, move.acceleration);
    move.rate = before + move.slope * dt;
    const bool is_there = kind == STOP_MOVE || (kind == GO && to_go <= ARRIVED);
    if (is_there && std::abs(before) <= AT_REST && std::abs(move.rate) < AT_REST) {
        move.rate = move.slope = 0.0;
        move.kind = NONE;
    }
    if (kind == GO) move.distance -= 0.5 * (before + move.rate) * dt;
}

}  // namespace heave
