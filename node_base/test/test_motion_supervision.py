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
        (lambda now: DrumReading(0.0, True, 0.5 * now**2, now, 0.0), "the drum does not stop", TIME),
        (lambda now: DrumReading(0.0, True, 0.05 * now, 0.05, 1.0), "the brake does not hold", SLIPPED / 0.05),
        (lambda now: DrumReading(0.0, True, 0.02 * now, 0.02, math.nan), "the brake does not hold", SLIPPED / 0.02),
    ],
)
def test_each_rule_is_found_within_its_time(drum_at, words, after):
    now, told = found(drum_at)
    assert told.startswith(words)
    # an order is one from 0.05 m/s on, which a wave of 0.4 m/s reaches in 0.12 s
    assert after < now <= after + 0.12 + 2.0 * STEP + 1e-9


def test_without_a_time_nothing_is_supervised():
    supervision = MotionSupervision(0.0)
    assert not any(supervision.look(now, DrumReading(1.0, False, 0.0, -1.0, 1.0)) for now in np.arange(0.0, 5.0, STEP))
