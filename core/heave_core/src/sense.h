// What a tick senses: gates, noise, the estimator's terms, consistency, tension and sea. See sense_table.py.
#pragma once

#include "look.h"

namespace heave {

// The larger of two; the second may be no number.
inline double larger(double value, double other) { return other > value ? other : value; }

// sensor_gate.cpp: what one sensor shows alone
void begin_gate(const Health &health, const Sensor &sensor, SensorGate &gate);
bool is_in_range(const Sensor &sensor, const double *values, int count);
bool judge(const Health &health, const Sensor &sensor, SensorGate &gate, double now, double time, const double *values,
           int count, double status);
void refuse(const Health &health, SensorGate &gate, int reason);
void take_back(const Health &health, SensorGate &gate, int reason, bool is_news);
void tick_gate(const Health &health, const Sensor &sensor, SensorGate &gate, double now);
double largest_age(const Health &health, const Sensor &sensor, const SensorGate &gate);

// noise.cpp: noise and rate of a sensor, from its readings alone
double median(int count, const double *values);
void begin_noise(const Measured &measured, SensorNoise &noise);
double add_noise(const Health &health, const Measured &measured, SensorNoise &noise, double value, double stated);
bool stands_out(const Measured &measured, const SensorNoise &noise, double innovation);
bool has_worse_noise(const Health &health, const Measured &measured, SensorNoise &noise);
void begin_interval(const Health &health, const Sensor &sensor, OwnInterval &interval);
void add_interval(const Health &health, const Sensor &sensor, OwnInterval &interval, double value);
bool is_slow(const Health &health, OwnInterval &interval);

// steps.cpp: jumps that a motion reference unit or a depth sensor makes
void begin_steps(MruSteps &steps);
bool is_off(const StepLimits &limits, MruSteps &steps, const Delivered &reading, double noise);
bool admits_mru(const SenseDesign &design, SenseState &state, double now, const Delivered &reading);
void begin_jumps(DepthJumps &jumps);
double take_off(const StepLimits &limits, DepthJumps &jumps, double time, double depth, double noise);

// encoder.cpp
void begin_encoder(EncoderGate &encoder);
void pass_tick(const StepLimits &limits, EncoderGate &encoder, double now, double way);
double judge_encoder(const SenseDesign &design, SensorGate &gate, EncoderGate &encoder, double now, double time,
                     double reading, double expected_rate, double sent_rate, bool is_driven);
void rescale(EncoderGate &encoder, double factor, double payout);
void trust(EncoderGate &encoder);
void resume(EncoderGate &encoder, double payout);

// terms.cpp: a gated reading in the estimator's terms
struct Stamp {
    double tick, offset;  // nearest tick, and how much later than that, in ticks
};
Stamp stamp_of(const SenseDesign &design, double time);
void remember_share(SenseState &state, double tick, const double *mean_state, int order);
double share_of(const SenseDesign &design, const SenseState &state, const LookDesign &look, const Observed &observed);
double zero_of(const SenseDesign &design, SenseState &state, int sensor, double value);
Reading in_terms(const SenseDesign &design, const Observed &observed);
void sort_readings(Reading *readings, int count);

// sea.cpp: the sea that moves the boom tip
void begin_sea(SeaSeen &sea);
double height_ratio(const SeaDesign &design, const SeaSeen &sea);
void note_innovation(const SeaDesign &design, double tick_period, SeaSeen &sea, double nis, double sigma);
bool update_sea(const SeaDesign &design, double tick_period, SeaSeen &sea, const Motion &tip);
double waves_of(const SeaDesign &design, const SeaSeen &sea);

// watches.cpp: consistency, tension, boom tip
void add_innovation(const Watches &watches, double tick_period, SensorNoise &noise, double nis);
void restart_consistency(SenseState &state);
int watch_consistency(const SenseDesign &design, SenseState &state);
void begin_mean(MeanTension &mean);
void restart_tension(MeanTension &mean);
void add_tension(const Watches &watches, double tick_period, MeanTension &mean, double tension, double place, bool stands);
void filter_tension(const Watches &watches, MeanTension &mean, double tension);
void watch_tip(const Watches &watches, double tick_period, SenseState &state, bool is_lost, bool is_excluded);

// Inputs of the sensing half of a tick.
struct LookAt {
    double number, compensating, mean;  // of the tick; shares of the active command: what compensates, what moves the mean
    double unit_stands, readings;       // 1: the unit stands on the seabed; number of the readings delivered
    double has_winch, winch_time, encoder, is_driven;  // 1: it has reported; stamp [s], count [m]; 1: it follows its commands
};

// sense.cpp: a tick
struct Core {
    const SenseDesign &design;
    const Filter &filter;
    const LookDesign &look;
    const MeanMotion &motion;
    SenseState &state;
    FilterState &filter_state;
    LookState &look_state;
};
struct Room {
    Observed *found, *observed;  // of a reading two, and one of the encoder
    Reading *readings;
    Said *said, *by_measurement;
    double *depths;  // stamp and depth
};
void step_second(const Core &core, const Room &room, const Tick &tick, double command, bool compares, Second &second);
void begin_sense(const SenseDesign &design, SenseState &state);
double mean_command(const SenseDesign &design, const MeanMotion &motion);
void look_at(const Core &core, const LookAt &given, const Delivered *delivered, const Room &room, Tick &tick);

}  // namespace heave
