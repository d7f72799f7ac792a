// The reflex about the encoder, before the readings of a tick: one that is reversed, or suddenly of another scale, is set aside
// within a second, as a loop that uses it is unstable; a smaller error is the adviser's to find. Where a drum does not count
// drive or encoder is named once a third sensor shows which. What is found are bits of ReflexNews.
#include "tick.h"

namespace heave {

namespace {

// Drive or encoder is named by the evidence of the filter that goes by the count, beside the active one that goes by the
// commands; such a filter begins with a count that stands, and ends where count and commands agree again.
int separate(const ReflexDesign &design, ReflexState &state, bool is_frozen, bool is_aside, bool is_braked) {
    if (!is_frozen && !is_aside) {
        if (!state.is_unresolved) state.is_named = 0;
        const int news = state.compares ? COUNT_AGREES : 0;
        state.compares = 0;
        return news;
    }
    if (state.compares) {
        if (std::abs(state.nats) < design.separated) return 0;
        state.is_named = 1;
        if (state.nats > 0.0) state.is_unresolved = 1;
        state.compares = 0;
        return COUNT_JUDGED;
    }
    if (!is_frozen || state.is_named || is_braked) return 0;
    compare_count(state);
    return COUNT_DISPUTED;
}

// An encoder that is lost, or has jumped: what was seen of the drum until then is void.
int watch_count(const Control &on) {
    const ReflexDesign &design = *on.reflex;
    ReflexState &state = *on.reflex_state;
    const SenseState &sense = *on.sense_state;
    const bool is_lost = sense.gates[on.sense->encoder].level == SENSOR_LOST, was_lost = state.lost_ticks >= design.lost_ticks;
    int news = 0;
    state.lost_ticks = is_lost ? state.lost_ticks + 1 : 0;
    if (was_lost) {
        // where the drum is was not known: the depth sensor is not held against the estimate
        reset_mismatch(*on.supervising.guard_state);
        if (!is_lost) news |= ENCODER_FOUND;
    }
    if (on.given->number * design.tick_period - sense.encoder.jumped_at < design.another_count) {
        on.winch_state->drum.readings = 0;
        on.supervising.guard_state->drum_share = 0.0;
        news |= COUNT_STEPPED;
    }
    return news;
}

// An encoder that is to be set aside: where it reads what a nominal winch was ordered, the beliefs are wrong.
int set_aside(const Control &on, const Ordered &ordered) {
    ReflexState &state = *on.reflex_state;
    const DrumWatchDesign &watch = on.winch_watch->drum;
    Ordered nominal = drum_ordered(watch, on.winch_state->drum, {on.drum_rows, on.drum_work}, watch.nominal);
    nominal.share *= on.sense_state->encoder.scale;
    if (reads_true(*on.reflex, nominal)) return BELIEFS_REFUTED;
    state.payout = ordered.payout;
    compare_count(state);
    return ENCODER_REFUTED;
}

}  // namespace

// A third sensor has named the encoder, not the drive.
bool is_count_refuted(const ReflexState &state) { return state.is_named && !state.is_unresolved; }

bool reads_reversed(const ReflexDesign &design, const Ordered &ordered, bool was) {
    if (was) return ordered.share < design.not_reversed;
    return ordered.share < design.reversed && ordered.left < design.straight;
}

// It reads far more than was ordered, or far less, no limit having acted; and if it was so, still does. A limit that acts
// makes a drum go less than it was ordered, never more.
bool reads_suddenly(const ReflexDesign &design, const Ordered &ordered, bool was) {
    const double least = was ? design.not_less : design.less, most = was ? design.not_more : design.more;
    if (least < ordered.share && ordered.share < most) return false;
    return was || (ordered.left < design.straight && (ordered.share >= most || ordered.is_limited == 0.0));
}

bool reads_the_right_way(const ReflexDesign &design, const Ordered &ordered) {
    return ordered.share > design.not_reversed && ordered.left < design.straight;
}

bool reads_true(const ReflexDesign &design, const Ordered &ordered) {
    return std::abs(ordered.share - 1.0) < design.error && ordered.left < design.straight;
}

// A tick in which the winch moves, with what the encoder reads of what was ordered, where a look is due and that is known.
// Returns ENCODER_REFUTED or ENCODER_TRUSTED where another thing is to be done with the encoder from now on. One that has
// gone the right way is set aside once it has been wrong in some looks running: a drum that lags behind turns back late.
int look_at_encoder(const ReflexDesign &design, ReflexState &state, int tick, const Ordered &ordered, bool is_aside) {
    state.moving_time = tick == state.last + 1 ? state.moving_time + design.tick_period : 0.0;
    state.last = tick;
    state.aside_time = is_aside ? state.aside_time + design.tick_period : 0.0;
    if (state.aside_time > design.longest_aside) state.is_unresolved = 1;
    if (tick % design.look_ticks != 0 || std::isnan(ordered.share)) return 0;
    if (reads_the_right_way(design, ordered)) state.was_right = 1;
    state.true_share += design.learnt * (reads_true(design, ordered) - state.true_share);
    const bool goes_back = reads_reversed(design, ordered, is_aside), knows_winch = is_aside || state.true_share > design.known;
    const bool is_wrong = goes_back || (knows_winch && reads_suddenly(design, ordered, is_aside));
    state.looks = is_wrong ? state.looks + 1 : 0;
    if (is_wrong == is_aside || (is_wrong && state.was_right && state.looks < design.looks)) return 0;
    if (is_aside) return ENCODER_TRUSTED;
    state.is_reversed = goes_back;
    state.is_unresolved = state.moving_time < design.beginning && !state.was_right;
    return ENCODER_REFUTED;
}

void compare_count(ReflexState &state) {
    state.compares = 1;
    state.nats = 0.0;
}

int watch_encoder(const Control &on) {
    const ReflexDesign &design = *on.reflex;
    SenseState &sense = *on.sense_state;
    const SensorGate &gate = sense.gates[on.sense->encoder];
    const int mode = on.supervising.mode->mode, number = int(on.given->number);
    const bool is_aside = sense.excluded == on.sense->encoder, is_frozen = gate.level == SENSOR_LOST && gate.reason == FROZEN;
    int news = watch_count(on);
    news |= separate(design, *on.reflex_state, is_frozen, is_aside, is_braked(*on.supervising.mode));
    if (is_count_refuted(*on.reflex_state)) {
        // the drum follows its commands: what was held against it was the count's, and the depth sensor knows where it is
        on.supervising.guard_state->drum_share = 0.0;
        if (on.tick->has_depth != 0.0) on.reflex_state->aside_time = 0.0;
    }
    const bool moves = mode == IN_COMPENSATING || mode == IN_FADE_OUT, is_other_aside = sense.excluded >= 0 && !is_aside;
    if (!moves || on.active->identifies_winch == 0 || is_other_aside) return news;
    Ordered ordered{NOT_KNOWN, 0.0, 0.0, 0.0};
    const DrumWatchDesign &watch = on.winch_watch->drum;
    if (number % design.look_ticks == 0)
        ordered = drum_ordered(watch, on.winch_state->drum, {on.drum_rows, on.drum_work}, watch.assumed);
    const int found = look_at_encoder(design, *on.reflex_state, number, ordered, is_aside);
    if (found == ENCODER_TRUSTED) {
        sense.excluded = -1;
        resume(sense.encoder, on.tick->motions.payout + on.tick->motions.mean_payout);
        reset_mismatch(*on.supervising.guard_state);
        news |= ENCODER_FOUND;
    }
    return found == ENCODER_REFUTED ? news | set_aside(on, ordered) : news;
}

}  // namespace heave
