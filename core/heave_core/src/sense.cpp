// What is known of the loop at a tick: readings through their gates, into the estimator's terms, through the filter, and
// what they say of sensors, tension, boom tip and sea.
#include "sense.h"

namespace heave {

namespace {

// Readings of a tick that have passed their gates, as they come.
struct Found {
    Observed *rows;
    int count;
};

bool is_taken(const Core &core, int sensor) { return core.design.sensors[sensor].is_used && sensor != core.state.excluded; }

// A sensor in use that has jumped must agree with all others before it is used again.
void exclude_first(const Core &core, int sensor) {
    const bool excludes = core.design.excludes_jumped && core.design.sensors[sensor].is_used;
    if (excludes && core.state.excluded < 0) core.state.excluded = sensor;
}

Observed &add(const Core &core, Found &found, double number, int row, double value, const Stamp &stamp, double sigma) {
    const bool is_used = is_taken(core, core.design.measured[row].sensor);
    Observed &observed = found.rows[found.count++];
    observed = {number, stamp.tick, double(row), value, 0.0, stamp.offset, sigma, double(is_used), NOT_KNOWN, 0.0, 0.0, value};
    return observed;
}

// Heave and heave rate; a lever arm's error adds pitch and roll, and their rates.
void take_mru(const Core &core, double number, const Delivered &reading, Found &found) {
    const SenseDesign &design = core.design;
    MruSteps &steps = core.state.mru;
    const Stamp stamp = stamp_of(design, reading.time);
    const int heave = design.sensors[design.mru].measured, rate = heave + 1;
    const double last = steps.attitude_time, elapsed = reading.time - last;
    const double turned = reading.pitch - steps.pitch, rolled = reading.roll - steps.roll;
    steps.attitude_time = reading.time;
    steps.roll = reading.roll;
    steps.pitch = reading.pitch;
    double sigma = add_noise(design.health, design.measured[heave], core.state.noises[heave], reading.value, reading.sigma);
    Observed &level = add(core, found, number, heave, reading.value, stamp, sigma);
    level.lever_x = -reading.pitch;
    level.lever_y = reading.roll;
    if (!(elapsed > 0.0)) return;
    core.state.mru_rate = reading.rate;
    if (std::isnan(reading.rate)) return;
    sigma = add_noise(design.health, design.measured[rate], core.state.noises[rate], reading.rate, reading.rate_sigma);
    Observed &turning = add(core, found, number, rate, reading.rate, stamp, sigma);
    turning.lever_x = -turned / elapsed;
    turning.lever_y = rolled / elapsed;
}

// Rates of the drum [m/s]: as estimated, which goes by its count, and by what was sent alone, where only the mean payout moves.
struct DrumRate {
    double expected, sent;
};

DrumRate drum_rate(const Core &core, const LookAt &given) {
    const LookDesign &rows = core.look;
    const double *mean = core.motion.state, *x = core.filter_state.x;
    DrumRate rate{rows.through * (given.compensating + given.mean), rows.through * given.mean};
    for (int j = 0; j < rows.order; j++) {
        rate.expected += rows.payout_rate[j] * (x[j] + mean[j]);
        rate.sent += rows.payout_rate[j] * mean[j];
    }
    if (given.compensating != 0.0) rate.sent = rate.expected;
    return rate;
}

// Whether the drum should go as it is ordered: a winch that holds it does not, for as long as its brake takes to open.
bool should_turn(const SenseDesign &design, const LookAt &given, EncoderGate &encoder) {
    const double ordered = std::abs(given.compensating + given.mean);
    if (given.is_driven != 0.0 || ordered == 0.0) encoder.held = 0.0;
    else if (ordered > design.steps.moving_speed) encoder.held += design.tick_period;
    return given.is_driven != 0.0 || encoder.held > design.steps.release_time;
}

void take_encoder(const Core &core, const LookAt &given, double now, const DrumRate &rate, Found &found, Tick &tick) {
    const SenseDesign &design = core.design;
    EncoderGate &encoder = core.state.encoder;
    pass_tick(design.steps, encoder, now, rate.expected * design.tick_period);
    tick.encoder_payout = tick.counted = NOT_KNOWN;
    if (given.has_winch == 0.0) return;
    const double payout = judge_encoder(design, core.state.gates[design.encoder], encoder, now, given.winch_time, given.encoder,
                                        rate.expected, rate.sent, should_turn(design, given, encoder));
    tick.encoder_payout = payout;
    if (!std::isfinite(given.winch_time)) return;
    const Stamp stamp = stamp_of(design, given.winch_time);
    tick.counted = given.encoder / encoder.scale - encoder.offset;
    tick.count_tick = stamp.tick;
    tick.count_offset = stamp.offset;
    if (std::isnan(payout) || !is_taken(core, design.encoder)) return;
    Observed &observed = add(core, found, given.number, design.sensors[design.encoder].measured, payout, stamp, NOT_KNOWN);
    observed.value = encoder.as_read;
}

double depth_noise(const Core &core) {
    const int row = core.design.sensors[core.design.depth].measured;
    return core.design.measured[row].has_noise ? core.state.noises[row].sigma : 0.0;
}

// A scalar reading: gated, about its zero, in the sign of the model. On a unit that stands it says nothing of a hanging one.
void take_scalar(const Core &core, const LookAt &given, double now, const Delivered &reading, const Room &room, Found &found,
                 Tick &tick) {
    const SenseDesign &design = core.design;
    SenseState &state = core.state;
    const int sensor = int(reading.sensor);
    const Sensor &assumed = design.sensors[sensor];
    SensorGate &gate = state.gates[sensor];
    if (!assumed.is_watched || !judge(design.health, assumed, gate, now, reading.time, &reading.value, 1, GOOD)) return;
    double read = reading.value;
    if (sensor == design.depth) {
        read = take_off(design.steps, state.jumps, reading.time, read, depth_noise(core));
        if (state.jumps.is_unproved != 0.0) exclude_first(core, sensor);
    }
    if (std::isnan(read)) return take_back(design.health, gate, JUMP, true);
    if (sensor == design.load_cell) state.tension = read;
    const double value = assumed.sign * (read - zero_of(design, state, sensor, read));
    if (sensor == design.depth) {
        state.unit_heave = value;
        double *depth = room.depths + 2 * int(tick.depth_count++);
        depth[0] = reading.time;
        depth[1] = read;
    }
    const int row = assumed.measured;
    const Measured &measured = design.measured[row];
    const double sigma = measured.has_noise ? add_noise(design.health, measured, state.noises[row], value, NOT_KNOWN) : NOT_KNOWN;
    if (given.unit_stands == 0.0) add(core, found, given.number, row, value, stamp_of(design, reading.time), sigma);
}

// The gates: what was delivered becomes what is observed.
void observe(const Core &core, const LookAt &given, const Delivered *delivered, const DrumRate &rate, const Room &room,
             Found &found, Tick &tick) {
    const SenseDesign &design = core.design;
    const double now = given.number * design.tick_period;
    const int count = int(given.readings);
    int i = 0;
    for (; i < count && delivered[i].sensor == design.mru; i++) {
        if (!design.sensors[design.mru].is_used || !admits_mru(design, core.state, now, delivered[i])) continue;
        if (core.state.mru.is_unproved != 0.0) exclude_first(core, design.mru);
        take_mru(core, given.number, delivered[i], found);
    }
    take_encoder(core, given, now, rate, found, tick);
    for (; i < count; i++) take_scalar(core, given, now, delivered[i], room, found, tick);
    for (int sensor = 0; sensor < SENSORS; sensor++)
        if (design.sensors[sensor].is_watched) tick_gate(design.health, design.sensors[sensor], core.state.gates[sensor], now);
}

// What is observed, cross-checks first, and what of it the filter takes, in its terms; returns how many that are.
int put_in_terms(const Core &core, const Found &found, const Room &room, Tick &tick) {
    const int unit_heave = core.design.sensors[core.design.depth].measured;
    int count = 0, observed = 0;
    tick.depth_heave = NOT_KNOWN;
    for (const double is_used : {0.0, 1.0})
        for (int i = 0; i < found.count; i++) {
            if (found.rows[i].is_used != is_used) continue;
            Observed &row = room.observed[observed++] = found.rows[i];
            row.share = share_of(core.design, core.state, core.look, row);
            if (is_used == 0.0) continue;
            room.readings[count] = in_terms(core.design, row);
            if (row.row == unit_heave) tick.depth_heave = room.readings[count].value;
            count++;
        }
    tick.observed_count = observed;
    return count;
}

void take_in(const Core &core, const LookAt &given, int count, const Room &room) {
    sort_readings(room.readings, count);
    const FilterTick step{given.number, given.compensating, double(count)};
    run_filter(core.filter, core.filter_state, &step, 1, room.readings, room.said);
    for (int i = 0; i < MEASUREMENTS; i++) room.by_measurement[i] = {NOT_KNOWN, NOT_KNOWN, NOT_KNOWN, 0.0};
    for (int i = 0; i < count; i++) room.by_measurement[int(room.readings[i].which)] = room.said[i];
}

// Take back the samples of which the filter refused a reading, and note what innovations say; one that came too late to be
// compared says nothing against the sensor. Readings inconsistent for long, or that go on from those before, are no spikes.
int learn(const Core &core, const Room &room) {
    const SenseDesign &design = core.design;
    bool is_refused[SENSORS] = {}, is_spike[SENSORS] = {};
    for (int row = 0; row < MEASUREMENTS; row++) {
        const Measured &measured = design.measured[row];
        if (measured.sensor >= 0 && measured.which >= 0 && measured.is_compared)
            add_innovation(design.watches, design.tick_period, core.state.noises[row], room.by_measurement[measured.which].nis);
    }
    const int news = watch_consistency(design, core.state);
    for (int row = 0; row < MEASUREMENTS; row++) {
        const Measured &measured = design.measured[row];
        if (measured.sensor < 0 || measured.which < 0 || measured.sensor == design.encoder) continue;
        const Said &said = room.by_measurement[measured.which];
        if (said.accepted != 0.0 || !std::isfinite(said.nis)) continue;
        is_refused[measured.sensor] = true;
        const SensorNoise &noise = core.state.noises[row];
        is_spike[measured.sensor] |= noise.mean <= design.watches.inconsistent && stands_out(measured, noise, said.innovation);
    }
    for (int sensor = 0; sensor < SENSORS; sensor++)
        if (is_refused[sensor]) take_back(design.health, core.state.gates[sensor], SPIKE, is_spike[sensor]);
    return news;
}

void note_tension(const Core &core, const LookAt &given, const Delivered *delivered) {
    SenseState &state = core.state;
    if (!std::isfinite(state.tension)) return;
    bool is_new = false;
    for (int i = 0; i < int(given.readings); i++) is_new |= delivered[i].sensor == core.design.load_cell;
    if (is_new) filter_tension(core.design.watches, state.mean_tension, state.tension);
    if (state.gates[core.design.load_cell].level == SENSOR_LOST) return;
    const double place = core.motion.mean.payout + core.motion.left_over.payout + core.motion.carried.payout;
    add_tension(core.design.watches, core.design.tick_period, state.mean_tension, state.tension, place, given.unit_stands != 0.0);
}

// Bits of a double that hold the causes: a status of a sensor's own beyond is one with all others.
constexpr int LAST_CAUSE = 52;

// Whether a sensor that is lost is lost for another cause than was reported of it: each is reported once until it is well
// again. A reading refused among others is no cause, nor is the jump of one that was frozen, or stood with its drum.
bool has_new_cause(const Health &health, SensorGate &gate) {
    const bool is_sure = gate.reason == FROZEN || gate.reason == STALE || gate.reason == DELAYED;
    if (gate.level != SENSOR_LOST) gate.causes = 0.0;
    if (gate.level != SENSOR_LOST || !(is_sure || gate.bad_in_a_row >= health.bad_in_a_row)) return false;
    const int64_t causes = int64_t(gate.causes), cause = int64_t(1) << std::min(int(gate.reason), LAST_CAUSE);
    gate.causes = double(causes | cause);
    const bool goes_on = gate.reason == JUMP && (causes & int64_t(1) << FROZEN) != 0;
    return (causes & cause) == 0 && !goes_on;
}

// Which sensors have become worse in this tick, or have another noise or interval than the nominal one.
int watch_sensors(const Core &core) {
    const SenseDesign &design = core.design;
    int news = 0;
    for (int sensor = 0; sensor < SENSORS; sensor++) {
        SensorGate &gate = core.state.gates[sensor];
        // a reading that is refused is said to be one alone once the next is not; a jump that is taken off, at once
        const bool is_told = gate.good_in_a_row > 0.0 || (gate.reason == JUMP && sensor != design.mru);
        const double level = gate.level == SENSOR_SUSPECT && !is_told ? gate.reported : gate.level;
        const bool is_lost_anew = has_new_cause(design.health, gate);
        int found = level > gate.reported || is_lost_anew ? SENSOR_WORSE : 0;
        gate.reported = level;
        if (design.sensors[sensor].is_watched && is_slow(design.health, gate.interval)) found |= SENSOR_SLOW;
        gate.news = found;
        news |= found;
    }
    for (int row = 0; row < MEASUREMENTS; row++)
        if (design.measured[row].has_noise && has_worse_noise(design.health, design.measured[row], core.state.noises[row]))
            news |= NOISE_HIGH;
    return news;
}

// Motions of boom tip, drum and units; the simulated units go on from the estimated one where the boom tip was not known.
// The driving noise of the filter follows the sea that moves the boom tip; returns whether it is to be another one.
bool move_units(const Core &core, const LookAt &given, const Room &room, Tick &tick) {
    const SenseDesign &design = core.design;
    SenseState &state = core.state;
    const bool knew_tip = state.knows_tip != 0.0, is_excluded = state.excluded == design.mru;
    watch_tip(design.watches, design.tick_period, state, state.gates[design.mru].level == SENSOR_LOST, is_excluded);
    const LookInputs inputs{given.compensating, given.mean, state.knows_tip, double(state.knows_tip != 0.0 && !knew_tip)};
    look(core.look, core.look_state, inputs, {core.filter_state.x, core.motion.state, core.filter_state.P}, tick.motions);
    if (!knew_tip || is_excluded) return false;
    const int which = design.measured[design.sensors[design.mru].measured + 1].which;
    if (which >= 0 && std::isfinite(room.by_measurement[which].nis))
        note_innovation(design.sea, design.tick_period, state.sea, room.by_measurement[which].nis, room.by_measurement[which].sigma);
    return update_sea(design.sea, design.tick_period, state.sea, {tick.motions.tip, tick.motions.tip_rate});
}

// What the sensors say after all.
void report(const Core &core, const Room &room, Tick &tick) {
    const SenseDesign &design = core.design;
    const SenseState &state = core.state;
    const int depth = design.measured[design.sensors[design.depth].measured].which;
    tick.mru_rate = state.mru_rate;
    tick.tension = state.tension;
    tick.filtered_tension = state.mean_tension.filtered;
    tick.tension_mean = state.mean_tension.value;
    tick.tension_sigma = std::sqrt(state.mean_tension.variance);
    tick.tension_time = state.mean_tension.count * design.tick_period;
    tick.depth_noise = depth_noise(core);
    tick.depth_innovation = NOT_KNOWN;
    if (depth >= 0 && std::isfinite(room.by_measurement[depth].nis))
        tick.depth_innovation = room.by_measurement[depth].innovation / room.by_measurement[depth].sigma;
    tick.has_depth = depth >= 0 && state.gates[design.depth].level != SENSOR_LOST;
    tick.sees_landing = tick.has_depth != 0.0 && state.excluded != design.depth;
    tick.has_encoder = state.gates[design.encoder].accepted > 0.0;
    tick.knows_sea = waves_of(design.sea, state.sea) >= design.first_waves;
    tick.is_sea_refuted = state.sea.mean_nis > design.refuted;
    tick.disagree_time = state.disagree_time;
    tick.knows_tip = state.knows_tip;
    tick.missing_push = core.filter_state.missing_push;
    int lost = 0;
    for (int sensor = 0; sensor < SENSORS; sensor++) lost |= int(state.gates[sensor].level == SENSOR_LOST) << sensor;
    tick.lost_sensors = lost;
}

}  // namespace

void begin_sense(const SenseDesign &design, SenseState &state) {
    state.excluded = -1;
    state.shares = state.newest_share = 0;
    state.first_heave = state.mru_rate = state.unit_heave = state.disagree_time = state.is_unexplained = state.tip_lost = 0.0;
    state.tension = NOT_KNOWN;
    state.tip_back = design.watches.back_time;
    state.knows_tip = 1.0;
    for (int i = 0; i < SENSORS; i++) begin_gate(design.health, design.sensors[i], state.gates[i]);
    for (int i = 0; i < MEASUREMENTS; i++) begin_noise(design.measured[i], state.noises[i]);
    begin_steps(state.mru);
    begin_jumps(state.jumps);
    begin_encoder(state.encoder);
    begin_sea(state.sea);
    begin_mean(state.mean_tension);
}

// The share of the next command that moves the mean payout: its rate, and the lag of the winch ahead.
double mean_command(const SenseDesign &design, const MeanMotion &motion) {
    const double payout = motion.mean.payout + motion.carried.payout, rate = motion.mean.move.rate + motion.carried.move.rate;
    if (design.is_first_order) return payout + rate / design.position_rate;
    return rate + design.lag * (motion.mean.move.slope + motion.carried.move.slope) + design.position_gain * payout;
}

// The sensing half of a tick.
void look_at(const Core &core, const LookAt &given, const Delivered *delivered, const Room &room, Tick &tick) {
    remember_share(core.state, given.number, core.motion.state, core.look.order);
    const DrumRate rate = drum_rate(core, given);
    tick.number = given.number;
    tick.compensating = given.compensating;
    tick.mean = given.mean;
    tick.depth_count = 0.0;
    Found found{room.found, 0};
    observe(core, given, delivered, rate, room, found, tick);
    take_in(core, given, put_in_terms(core, found, room, tick), room);
    for (int i = 0; i < int(tick.observed_count); i++) {
        const int which = core.design.measured[int(room.observed[i].row)].which;
        if (room.observed[i].is_used != 0.0) room.observed[i].nis = room.by_measurement[which].nis;
    }
    int news = learn(core, room);
    note_tension(core, given, delivered);
    if (move_units(core, given, room, tick)) news |= SEA_CHANGED;
    tick.news = news | watch_sensors(core);
    tick.mean_command = mean_command(core.design, core.motion);
    tick.left_over = core.motion.left_over.payout;
    report(core, room, tick);
}

}  // namespace heave
