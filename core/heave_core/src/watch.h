// What is watched beside the loop: landing, figures of merit, drum and link, nominal load; alarms of load, rope and winch.
#pragma once

#include "look.h"
#include "servo.h"

namespace heave {

// kpi.cpp; `rows` has the place that the design says
void add(const KpiDesign &design, KpiState &state, KpiRow *rows, KpiRow row);
void summarise(const KpiDesign &design, const KpiState &state, const KpiRow *rows, KpiWindow &window);

// A straight line through readings: its slope, and the standard error of that, per second.
struct Slope {
    double value, error;
    bool is_known;
};

// trend.cpp: the newest readings
void add(Trend &trend, double time, double value);
bool has_stood(const Trend &trend, double window);
double mean_of(const Trend &trend, double window);
Slope slope_of(const Trend &trend, double window, double least_readings, double filled);

// Inputs of the landing detector at a tick.
struct LandingSeen {
    double time, tension, is_weighed;  // [s]; at the top, NaN: none [N]; the load cell has been read, and is not lost
    double mean_payout;                     // of the drum [m]
    double hanging_depth, hanging_stretch;  // of a unit that only hangs, about that at rest [m]; of its cable [m]
    double innovation;        // of the depth sensor, over its standard deviation; NaN: none
    double filtered_tension;  // low-passed [N]
    double sees_landing, has_depths;  // a depth sensor is there, neither lost nor excluded; it has read in this tick
    double compensates;               // the winch follows the mean payout
};

// landing.cpp: where the unit is between hanging and standing
void begin_landing(LandingState &state);
void observe_landing(const LandingDesign &design, LandingState &state, const LandingSeen &seen);
void judge_landing(const LandingDesign &design, LandingState &state, const LandingSeen &seen);

// Rows of the drum watch, and numbers to work on: 7 for each row that is kept.
struct DrumRecord {
    DrumRow *rows;
    double *work;
};

// What an encoder reads of what a drum was ordered.
struct Ordered {
    double share, left;  // times as much, NaN: not known; standard deviation of the rest over that of the readings
    double payout;       // where the drum should be by now, did it start where it was read [m]
    double is_limited;   // the winch reports that it was at a limit meanwhile
};

// drum_watch.cpp: orders and encoder of the last seconds
void add(const DrumWatchDesign &design, DrumWatchState &state, const DrumRecord &record, const DrumRow &row);
void reset_drum(const DrumWatchDesign &design, DrumWatchState &state, const DrumRecord &record, double payout);
double drum_error(const DrumWatchDesign &design, const DrumWatchState &state, const DrumRecord &record);
Ordered drum_ordered(const DrumWatchDesign &design, const DrumWatchState &state, const DrumRecord &record, const Servo &drum);

// What the winch reports at a tick, and the order of the last one: number, set-points [m], [m/s], brake.
struct WinchSeen {
    double has_state, taken;   // it has reported; number of the command that it has taken
    double at_end, is_limited; // at the end of its payout no model of it holds; another limit acts
    double given, payout, rate, brake;  // NaN: none was given
    double reading, tension;   // of the encoder, accepted [m], and at the top [N]; NaN: none
};

// winch_watch.cpp: whether the winch does what is predicted of it, and takes commands in time
void note_command(const LinkDesign &design, LinkState &state, double *minute, int given, int taken, double modelled);
void note_silence(const LinkDesign &design, LinkState &state, bool has_state, double untaken);
void watch_winch(const WinchWatchDesign &design, WinchWatchState &state, const DrumRecord &record, double *minute,
                 const WinchSeen &seen);

// nominal_load.cpp: the unit under a locked drum, moved by the raw motion reference unit
void begin_nominal_load(NominalLoadState &state);
void advance_nominal_load(const NominalLoadDesign &design, NominalLoadState &state);
void read_nominal_load(const NominalLoadDesign &design, NominalLoadState &state, double time, double heave, double rate);

// load_watch.cpp: tension, rope and winch; they return bits of LoadNews
bool begins(double &away, double quiet_time, double tick_period, bool is_there);
void begin_load_watch(const LoadWatchDesign &design, LoadWatchState &state);
int watch_load(const LoadWatchDesign &design, LoadWatchState &state, double tension, double static_tension, bool is_at_limit);
int watch_travel(const LoadWatchDesign &design, LoadWatchState &state, bool is_half, bool is_at_end);

}  // namespace heave
