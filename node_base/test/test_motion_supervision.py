"""What a drum is stopped for, and that lag and delay of a sound one are not."""

import math

import numpy as np
import pytest
from heave_node.winch.motion_supervision import SLIPPED, DrumReading, MotionSupervision

TIME, STEP = 1.0, 0.05


def found(drum_at, duration=12.0):
    """Return time and words of what is found first."""
    supervision = MotionSupervision(TIME)
    for now in np.arange(0.0, duration, STEP):
        words = supervision.look(float(now), drum_at(float(now)))
        if words:
            return float(now), words
    return math.nan, ""


def wave(now):
    return 0.4 * math.sin(2.0 * math.pi * now / 6.0)


def test_a_sound_drum_of_half_a_second_of_delay_and_lag_is_let_be():
    _, words = found(lambda now: DrumReading(wave(now), False, 0.0, wave(now - 0.5), 0.0), 60.0)
    assert words == ""


@pytest.mark.parametrize(
    ("drum_at", "words", "after"),
    [
        (lambda now: DrumReading(wave(now), False, 0.0, -wave(now), 0.0), "the drum turns against the command", TIME),
        (lambda now: DrumReading(wave(now), False, 0.0, 0.0, 0.0), "the drum stands against the command", TIME),
        (lambda now: DrumReading(0.0, False, 0.0, 0.0, 1.0), "the brake does not open", TIME),
        (lambda now: DrumReading(0.0, True, 0.0, 0.0, 0.0), "the brake does not engage", TIME),
        (lambda now: DrumReading(0.0, True, 0.5 * now**2, 0.2 + now, 0.0), "the drum does not stop", TIME),
        (lambda now: DrumReading(0.0, True, 0.12 * now, 0.12, 0.0), "the drum does not stop", TIME),
        (lambda now: DrumReading(0.0, True, 0.05 * now, 0.05, 1.0), "the brake does not hold", SLIPPED / 0.05),
        (lambda now: DrumReading(0.0, True, 0.02 * now, 0.02, math.nan), "the brake does not hold", SLIPPED / 0.02),
    ],
)
def test_each_rule_is_found_within_its_time(drum_at, words, after):
    now, told = found(drum_at)
    assert told.startswith(words)
    # an order is one from 0.05 m/s on, which a wave of 0.4 m/s reaches in 0.12 s
    assert after < now <= after + 0.12 + 2.0 * STEP + 1e-9


@pytest.mark.parametrize(
    ("rate", "words"),
    [
        (0.015, ""),
        (0.008, "the drum stands against the command"),
        (-0.008, "the drum stands against the command"),
        (-0.015, "the drum turns against the command"),
    ],
)
def test_a_drum_slower_than_a_centimetre_a_second_stands_and_a_faster_one_turns(rate, words):
    """Either way round."""
    assert found(lambda now: DrumReading(0.4, False, 0.0, rate, 0.0))[1] == words
    assert found(lambda now: DrumReading(-0.4, False, 0.0, -rate, 0.0))[1] == words


@pytest.mark.parametrize(
    ("moved", "words"),
    [(0.9, "the brake does not hold: the drum has moved by +0.90 m"), (-1.5, "it moved unseen, or its count was lost")],
)
def test_a_drum_that_is_found_more_than_a_metre_away_was_not_seen_to_slip(moved, words):
    supervision = MotionSupervision(TIME)
    assert not supervision.look(0.0, DrumReading(0.0, True, 20.0, 0.0, 1.0))
    assert words in supervision.look(STEP, DrumReading(0.0, True, 20.0 + moved, 0.0, 1.0))


def test_without_a_time_nothing_is_supervised():
    supervision = MotionSupervision(0.0)
    assert not any(supervision.look(now, DrumReading(1.0, False, 0.0, -1.0, 1.0)) for now in np.arange(0.0, 5.0, STEP))


@pytest.mark.parametrize(("is_open", "engaged"), [(0.0, 1.0), (math.nan, math.nan)], ids=["brake switch", "none"])
def test_a_sound_drum_that_is_braked_and_released_again_and_again_is_let_be(is_open, engaged):
    """It follows for 4 s, slows down at 0.5 m/s^2, and holds."""

    def drum_at(now):
        phase = now % 8.0
        if phase < 4.0:
            return DrumReading(0.4, False, 0.0, 0.4, is_open)
        rate = max(0.4 - 0.5 * (phase - 4.0), 0.0)
        return DrumReading(0.4, True, 0.0, rate, is_open if rate else engaged)

    assert found(drum_at, 60.0)[1] == ""


def test_what_lasts_is_told_again_after_the_time_and_what_has_passed_begins_anew():
    supervision, standing = MotionSupervision(TIME), DrumReading(0.4, False, 0.0, 0.0, 0.0)
    told = [float(now) for now in np.arange(0.0, 3.2, STEP) if supervision.look(float(now), standing)]
    # longer than the time, from the first look and from the one after the first time it was reported
    assert told == pytest.approx([TIME + STEP, 2.0 * TIME + 3.0 * STEP], abs=STEP + 1e-9)
    assert supervision.found == "the drum stands against the command"
    interrupted = MotionSupervision(TIME)
    for step in range(120):
        rate = 0.4 if step % 18 == 0 else 0.0
        assert not interrupted.look(STEP * step, DrumReading(0.4, False, 0.0, rate, 0.0))


def test_a_slip_is_told_each_time_the_drum_has_moved_by_as_much_again_either_way():
    supervision, told = MotionSupervision(TIME), []
    for step in range(200):
        words = supervision.look(step * STEP, DrumReading(0.0, True, -0.001 * step, -0.02, 1.0))
        told += [words] if words else []
    # 0.2 m in steps of a millimetre, and 0.05 m are reported once they are passed
    assert told == ["the brake does not hold: the drum has moved by -0.05 m"] * 3


def test_what_was_found_last_was_a_slip_or_was_not():
    supervision = MotionSupervision(TIME)
    assert (supervision.found, supervision.is_slipping) == ("", False)
    for step in range(3):
        supervision.look(step * STEP, DrumReading(0.0, True, 0.03 * step, 0.6, 1.0))
    assert supervision.is_slipping
    for step in range(30):
        supervision.look(1.0 + step * STEP, DrumReading(0.4, False, 0.06, 0.0, 0.0))
    assert (supervision.found, supervision.is_slipping) == ("the drum stands against the command", False)


def test_a_position_that_is_not_known_is_no_slip_and_what_moved_meanwhile_is_none_either():
    supervision = MotionSupervision(TIME)
    for step, payout in enumerate([0.0, math.nan, 3.0, 3.01]):
        assert supervision.look(step * STEP, DrumReading(0.0, True, payout, 0.0, 1.0)) == ""


@pytest.mark.parametrize(("brake", "speed", "is_held"), [(1.0, 0.5, True), (0.0, 0.005, False)])
def test_a_drum_is_held_as_its_brake_says_and_not_as_its_speed_looks(brake, speed, is_held):
    """An engaged brake that slips fast does not hold; one that says it is open is not the one to blame for a creep."""
    supervision = MotionSupervision(1e3)
    told = [
        supervision.look(now, DrumReading(0.0, True, speed * now, speed, brake)) for now in np.arange(0.0, 60.0, STEP)
    ]
    assert any("does not hold" in words for words in told) is is_held


@pytest.mark.parametrize("speed", [0.08, 0.1, 0.12, 0.3])
def test_a_drum_that_has_stood_and_sinks_past_a_brake_that_says_open_is_found_by_its_way(speed):
    """At 0.1 m/s it is too fast to be held and too slow not to stop, by an encoder that reads in steps of 2 cm/s."""

    def drum_at(now):
        payout = round(speed * max(now - 2.0, 0.0), 3)
        rate = (payout - round(speed * max(now - STEP - 2.0, 0.0), 3)) / STEP
        return DrumReading(0.0, True, payout, rate, 0.0 if now > 2.0 else 1.0)

    now, words = found(drum_at)
    assert words.startswith("the brake does not engage: the drum has moved by +0.0")
    assert now - 2.0 <= (SLIPPED + 1e-3) / speed + 2.0 * STEP
