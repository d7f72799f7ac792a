// The envelope, the last part of a tick: Design, State, Readings and Order are its own; the whole tick is in tick.cpp.
// Nothing in this library allocates, throws or reads a clock.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "layout.h"

namespace heave {

constexpr double NOT_KNOWN = std::numeric_limits<double>::quiet_NaN();
constexpr double INFINITE = std::numeric_limits<double>::infinity(), ANY = INFINITE;

inline double clip(double value, double lower, double upper) { return std::min(std::max(value, lower), upper); }

// Whether a count came: one in which a step is lost in rounding is none.
inline bool count_came(const Bounds &bounds, const Readings &readings) {
    constexpr double ROUNDING = 1e-9;
    return std::abs(readings.count) * ROUNDING <= bounds.count_step;
}

// Travel of a tick: of the nominal drum, and of the asked move, which the drum follows after its delay.
struct Travelled {
    double drum, move;  // [m]
    bool is_braked;     // the order that acts has the brake on
};

// drum.cpp: the nominal drum
Travelled advance_drum(const Design &design, State &state, double load);
double way_since(const Design &design, const State &state, double age);
void take_way(const Design &design, State &state, double way, double sent, double time);
void count_way(const Design &design, State &state, double step, double sent, double time);
void forget_strokes(State &state);
double stroke_limit(const Bounds &bounds, const State &state);
double step_of_count(const Bounds &bounds, const State &state);
void watch_strokes(const Design &design, State &state);
void rest_drum(State &state);
void watch_brake(const Design &design, State &state, const Readings &readings, bool is_braked);
double payout_ahead(const Design &design, const State &state, double load);
double speed_of(const Winch &winch, double payout, double rate, double ahead);
double set_point_of(const Winch &winch, double speed);
void set_speed(const Winch &winch, double speed, double ahead, double &payout, double &rate);

// move.cpp: the move that an operator has asked for
void take_request(const Design &design, State &state, const Readings &readings, double heave);
void advance_move(Move &move, double dt, double jerk_time);
bool is_moving(const Move &move);
double approach_speed(double distance, double acceleration, double lag);

// ship.cpp: what ship, drum and load cell did
struct Ship {
    double rate, heave;  // largest of the window [m/s], [m]
    double filling;      // of the window, 0 to 1
};
void observe_mru(const Design &design, State &state, const Readings &readings);
Ship ship_of(const Design &design, const State &state);
bool has_load(const Design &design, const State &state);
double drift_limit(const Design &design, const State &state);
void watch_depth(const Design &design, State &state, const Readings &readings);
void confirm_count(const Design &design, State &state);
int observe_count(const Design &design, State &state, const Readings &readings, const Travelled &travelled);
double load_step(const Design &design, State &state, const Readings &readings, const Ship &ship);
double observe_load(const Design &design, State &state, const Readings &readings);

// envelope.cpp
void begin_envelope(State &state);
void envelope(const Design &design, State &state, const Readings &readings, Order &order);

}  // namespace heave
