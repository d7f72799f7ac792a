// What is watched beside the loop: landing, and the rolling window of the figures of merit.
#pragma once

#include "parts.h"

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

// landing.cpp: where the unit is between hanging and standing
void begin_landing(LandingState &state);
void observe_landing(const LandingDesign &design, LandingState &state, const LandingSeen &seen);
void judge_landing(const LandingDesign &design, LandingState &state, const LandingSeen &seen);

}  // namespace heave
