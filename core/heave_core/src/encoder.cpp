// The gate of the drum encoder: what it reads is held against the way that the drum was sent. Jumps are taken off.
#include "sense.h"

namespace heave {

namespace {

// The way that the drum should have turned until a time, linear between ticks.
double travel_until(const StepLimits &limits, const EncoderGate &encoder, double time) {
    const int kept = int(limits.travel_ticks), newest = int(encoder.count) - 1, oldest = std::max(0, newest + 1 - kept);
    if (newest < 0) return 0.0;
    int after = newest;
    while (after > oldest && encoder.times[(after - 1) % kept] > time) after--;
    const double end = encoder.times[after % kept], total = encoder.totals[after % kept];
    if (after == oldest || time >= end) return total;
    const double start = encoder.times[(after - 1) % kept], before = encoder.totals[(after - 1) % kept];
    return before + (total - before) / (end - start) * (time - start);
}

void thaw(EncoderGate &encoder) { encoder.still = encoder.unseen = encoder.path = encoder.is_frozen = 0.0; }

// Whether an encoder that seemed frozen, or would have, has only taken up the play of its gear: it stood still since the
// drum turned round, for no longer than a gear takes, and counts on the way that the drum goes now. One that froze just
// there, and counts on from where it stood, looks the same: so much it may be off.
bool takes_up_play(const SenseDesign &design, EncoderGate &encoder, double step, double expected) {
    const double unseen = encoder.unseen, way = std::abs(unseen);
    const bool is_like_play = unseen * encoder.turned < 0.0 && unseen * step > 0.0 && way > design.steps.play &&
                              way <= design.steps.largest_play && std::abs(step - expected) <= design.health.encoder_step;
    if (is_like_play) encoder.play = std::max(encoder.play, way);
    return is_like_play;
}

// Whether the encoder is frozen: the drum should have turned. A drum that turns back, and is slow for a moment, takes no
// proof away.
bool watch_still(const SenseDesign &design, EncoderGate &encoder, double step, double expected, bool is_driven) {
    if (step != 0.0 || !(is_driven || encoder.is_frozen != 0.0)) {
        if (step != 0.0) encoder.turned = step;
        thaw(encoder);
        return false;
    }
    const StepLimits &limits = design.steps;
    encoder.unseen += expected;
    encoder.path += std::abs(expected);
    encoder.still += std::abs(expected) > limits.moving_speed * design.tick_period;
    const bool has_turned_round = encoder.unseen * encoder.turned < 0.0;
    const double allowed = has_turned_round ? std::max(limits.play, limits.beyond_play * encoder.play) : limits.play;
    if (encoder.still >= design.health.frozen_samples && std::abs(encoder.unseen) > allowed) encoder.is_frozen = 1.0;
    return encoder.is_frozen != 0.0;
}

// Look for jumps and for a drum that turns unseen. What goes on as before does not jump: whether the drum does so is known
// by what the winch was sent. The estimate of its rate goes by the count, and comes to rest with one that is frozen.
int status_of(const SenseDesign &design, EncoderGate &encoder, double time, double value, double rate, double sent_rate,
              bool is_driven) {
    const bool can_be = std::isfinite(value) && is_in_range(design.sensors[design.encoder], &value, 1);
    if (!can_be || !std::isfinite(time)) return GOOD;
    const double last_time = encoder.time, last = encoder.value;
    encoder.time = time;
    encoder.value = value;
    if (std::isnan(last_time)) return GOOD;
    const double elapsed = std::max(time - last_time, design.tick_period), step = value - last;
    const double ticks = elapsed / design.tick_period, way = rate * elapsed;
    const bool is_play = takes_up_play(design, encoder, step, way);
    const bool is_thawing = encoder.is_frozen != 0.0 && step != 0.0 && !is_play;
    double expected = way, tolerance = design.health.encoder_step;
    if (is_thawing) {
        expected = encoder.unseen + way;
        tolerance += design.steps.known_unseen * encoder.path;
    } else if (ticks >= design.steps.at_once) {
        // in a gap the drum may have been off its model in each tick
        expected = travel_until(design.steps, encoder, time) - travel_until(design.steps, encoder, last_time);
        tolerance *= ticks;
    }
    const bool is_frozen = watch_still(design, encoder, step, sent_rate * elapsed, is_driven);
    const double error = step - expected, before = encoder.speed;
    encoder.speed = step / elapsed;
    const bool is_other = is_thawing || std::abs(step - before * elapsed) > tolerance;
    if (!(std::abs(error) > tolerance && is_other)) return is_frozen ? FROZEN : GOOD;
    const bool is_back = std::abs(error + encoder.jump) <= tolerance;  // as after a spike: where it was at first
    encoder.jump = is_back ? -encoder.jump : error;
    encoder.offset += encoder.jump;
    return JUMP;
}

}  // namespace

void begin_encoder(EncoderGate &encoder) {
    encoder.offset = encoder.jump = encoder.as_read = encoder.play = encoder.speed = encoder.turned = encoder.held = encoder.count = 0.0;
    encoder.scale = 1.0;
    encoder.jumped_at = -INFINITE;
    encoder.last_payout = encoder.time = NOT_KNOWN;
    thaw(encoder);
}

// Note the way that the drum should have turned since the last tick, whether a reading comes or not.
void pass_tick(const StepLimits &limits, EncoderGate &encoder, double now, double way) {
    const int kept = int(limits.travel_ticks), place = int(encoder.count);
    const double total = place > 0 ? encoder.totals[(place - 1) % kept] : 0.0;
    encoder.times[place % kept] = now;
    encoder.totals[place % kept] = total + way;
    encoder.count += 1.0;
}

// The payout that a reading says, jumps taken off; NaN where it may not be used.
double judge_encoder(const SenseDesign &design, SensorGate &gate, EncoderGate &encoder, double now, double time,
                     double reading, double expected_rate, double sent_rate, bool is_driven) {
    const double value = reading / encoder.scale;
    const int status = status_of(design, encoder, time, value, expected_rate, sent_rate, is_driven);
    if (!judge(design.health, design.sensors[design.encoder], gate, now, time, &value, 1, status)) {
        if (status == JUMP) {
            encoder.jumped_at = now;
            gate.good_needed = design.steps.shown_ticks;
        }
        return NOT_KNOWN;
    }
    const double payout = value - encoder.offset;
    if (std::isfinite(encoder.last_payout)) encoder.as_read += encoder.scale * (payout - encoder.last_payout);
    else encoder.as_read = payout;
    return encoder.last_payout = payout;
}

// The encoder reads so many times as much as it was taken to, and the last payout was another one.
void rescale(EncoderGate &encoder, double factor, double payout) {
    encoder.scale *= factor;
    encoder.last_payout = payout;
    if (std::isnan(encoder.time)) return;
    encoder.value /= factor;
    encoder.speed /= factor;
    encoder.offset = encoder.value - payout;
}

// An encoder that was set aside counts as before any jump, if that is nearer to where the drum is by the commands: what has
// jumped may be back.
void resume(EncoderGate &encoder, double payout) {
    if (std::abs(encoder.value - payout) < std::abs(encoder.value - encoder.offset - payout)) encoder.offset = 0.0;
}

// Take a frozen encoder for good until the drum turns unseen again; the drum stands where it got to.
void trust(EncoderGate &encoder) {
    encoder.offset -= encoder.unseen;
    thaw(encoder);
}

}  // namespace heave
