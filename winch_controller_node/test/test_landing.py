"""Landing: whether the unit stands, told from depth readings alone; touchdown and lift-off."""

import numpy as np
import pytest
from winch_controller_node.estimation.loop_tick import Sensed
from winch_controller_node.parameters.laws import TensionLawParameters
from winch_controller_node.supervision.landing import FallRate, Landing, LandingEvent
from winch_controller_node.supervision.modes import Mode, ModeOutput

NOISE = 0.02
"""Depth sensor of the benchmarks: 2 cm, 10 Hz."""


def watched(depth_of, seed=1, end=3.0):
    watch, noise = FallRate(), np.random.default_rng(seed)
    for time in np.arange(0.0, end, 0.1):
        watch.add(float(time), depth_of(time) + NOISE * noise.standard_normal())
    return watch


@pytest.mark.parametrize("rate", [0.2, 0.5, 1.0])
def test_a_unit_on_the_bottom_stands_and_one_that_is_lowered_does_not(rate):
    for seed in range(20):
        assert watched(lambda time: 600.0, seed).shows_standing(rate)
        assert not watched(lambda time: 600.0 + rate * time, seed).shows_standing(rate)


def test_a_swing_unloads_the_cable_where_the_unit_falls_with_the_winch():
    """x = A cos(w t) about the mean: the cable is least loaded at the top of the swing, where x' = 0 about the mean."""
    amplitude, omega, rate = 1.0, 0.4, 1.0
    for seed in range(20):
        watch = watched(lambda time: rate * time - amplitude * np.cos(omega * (time - 3.0)), seed)
        assert watch.value == pytest.approx(rate, abs=0.3)
        assert not watch.shows_standing(rate)


def test_the_speed_is_that_of_the_last_second_only():
    watch = watched(lambda time: 600.0 + min(time, 1.5), end=3.0)
    assert abs(watch.value) < 0.1


def test_without_readings_nothing_is_known_and_the_tension_decides():
    assert FallRate().shows_standing(0.5)


LOWERING = ModeOutput(Mode.COMPENSATING, "", 1.0, brake=False)
HOLDING = ModeOutput(Mode.CONSTANT_TENSION, "", 0.0, brake=False)


def sensed(*, depths=(), innovation=None, has_depth=True):
    return Sensed(
        payout=0.0,
        mru_rate=0.0,
        tension=1.0,
        filtered_tension=1.0,
        depths=tuple(depths),
        depth_heave=None,
        depth_innovation=innovation,
        has_depth=has_depth,
        has_encoder=True,
        innovations={},
        lost={},
        faults=(),
    )


def landed():
    landing = Landing(TensionLawParameters())
    landing.observe(sensed(depths=[(0.1 * k, 600.0) for k in range(12)], innovation=5.0))
    assert landing.update(sensed(), 0.3, LOWERING, 0.2) is LandingEvent.TOUCHDOWN
    return landing


def test_a_unit_lands_once_and_hangs_again_only_when_it_is_lifted():
    landing = landed()
    assert landing.unit_stands
    assert landing.update(sensed(), 0.3, LOWERING, 0.2) is None
    assert landing.update(sensed(), 1.1, HOLDING, 0.0) is None
    landing.begin_lift_off()
    assert landing.update(sensed(), 0.9, HOLDING, 0.0) is None
    assert landing.update(sensed(), 1.1, HOLDING, 0.0) is LandingEvent.LIFTED_OFF
    assert not landing.unit_stands
    assert landing.update(sensed(), 1.1, HOLDING, 0.0) is None


@pytest.mark.parametrize(
    ("share", "mode", "rate", "innovation"),
    [
        (0.7, LOWERING, 0.2, 5.0),
        (0.3, HOLDING, 0.2, 5.0),
        (0.3, LOWERING, 0.0, 5.0),
        (0.3, LOWERING, 0.2, 2.0),
        (0.3, ModeOutput(Mode.COMPENSATING, "", 0.4, brake=False), 0.2, 5.0),
    ],
    ids=["carried", "not compensating", "not lowered", "where a hanging unit would be", "little authority"],
)
def test_what_is_no_landing(share, mode, rate, innovation):
    landing = Landing(TensionLawParameters())
    landing.observe(sensed(depths=[(0.1 * k, 600.0) for k in range(12)], innovation=innovation))
    assert landing.update(sensed(), share, mode, rate) is None


def test_without_a_depth_sensor_the_tension_alone_tells():
    landing = Landing(TensionLawParameters())
    assert landing.update(sensed(has_depth=False), 0.3, LOWERING, 0.2) is LandingEvent.TOUCHDOWN
