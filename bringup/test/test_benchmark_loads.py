"""A load on a rope that neither stretches nor weighs: taut, slack, on the bottom; and the motions above it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from heave_bringup.benchmark.records import HeaveRecord
from heave_bringup.benchmark.worlds.loads import CarriedLoad, HangingLoad, Kinematics, WetLoad, mas409_load
from heave_bringup.benchmark.worlds.motions import HarmonicMotion, RecordedMotion, mas409_sea, sine
from hypothesis import given
from hypothesis import strategies as st

DRY = WetLoad(mass=1000.0, weight=9806.65, drag=0.0, height=math.inf, stiffness=1e6, damping=0.0)
REST = Kinematics(0.0, 0.0, 0.0)


def test_taut_load_moves_with_the_rope_and_pulls_by_newtons_law() -> None:
    load = HangingLoad(DRY, REST)
    for k in range(1, 100):
        t = 0.05 * k
        end = Kinematics(0.3 * (1 - math.cos(t)), 0.3 * math.sin(t), 0.3 * math.cos(t))
        load.step(end, 0.05)
        assert load.state.heave == end.position
        assert load.state.tension == pytest.approx(9806.65 + 1000.0 * end.acceleration, rel=1e-9)


def test_rope_that_drops_faster_than_gravity_goes_slack_and_the_load_falls_freely() -> None:
    load = HangingLoad(DRY, Kinematics(0.0, 0.0, -20.0))
    for k in range(1, 11):
        t = 0.05 * k
        load.step(Kinematics(-10.0 * t * t, -20.0 * t, -20.0), 0.05)
        assert load.state.tension == 0.0
    assert load.state.heave == pytest.approx(-0.5 * 9.80665 * 0.5**2, rel=5e-3)
    for _ in range(20):  # the rope stops; the load catches up and hangs
        load.step(Kinematics(-2.5, 0.0, 0.0), 0.05)
    assert load.state.heave == -2.5
    assert load.state.tension == pytest.approx(9806.65)


def test_landed_load_sinks_in_by_its_weight_over_the_stiffness() -> None:
    wet = mas409_load(1.0)
    # (12.6 t - 2 m^3 of seawater) g
    assert wet.weight == pytest.approx((12_600.0 - 2050.0) * 9.80665)
    load, payout = HangingLoad(wet, REST), 0.0
    for _ in range(600):
        payout = min(payout + 0.05 * 0.1, 1.5)
        load.step(Kinematics(-payout, -0.1 if payout < 1.5 else 0.0, 0.0), 0.05)
    assert load.state.tension == 0.0
    assert load.state.bottom_force == pytest.approx(wet.weight, rel=1e-3)
    assert -1.0 - load.state.heave == pytest.approx(wet.weight / 1.8e6, rel=1e-3)


@given(st.lists(st.floats(-2.0, 2.0), min_size=3, max_size=30))
def test_rope_never_pushes_and_the_load_is_never_below_its_end(speeds: list[float]) -> None:
    load, position, before = HangingLoad(mas409_load(0.5), REST), 0.0, 0.0
    for speed in speeds:
        position += 0.05 * 0.5 * (speed + before)
        load.step(Kinematics(position, speed, (speed - before) / 0.05), 0.05)
        before = speed
        assert load.state.tension >= 0.0
        assert load.state.bottom_force >= 0.0
        assert load.state.heave >= position - 1e-9


def test_carried_load_weighs_the_same_always() -> None:
    load = CarriedLoad(5e4, REST)
    load.step(Kinematics(0.2, 0.1, 1.0), 0.05)
    assert (load.state.heave, load.state.tension) == (0.2, 5e4)


@pytest.mark.parametrize(
    "motion",
    [
        sine(1.2, 10.0, ramp=10.0),
        mas409_sea(3, ramp=10.0),
        HarmonicMotion(np.array([0.5, 1.1]), np.array([1.0, 0.3]), np.array([0.0, 2.0])),
        RecordedMotion(HeaveRecord(np.arange(0.0, 60.0, 0.05), np.sin(0.7 * np.arange(0.0, 60.0, 0.05)), "")),
    ],
)
def test_derivatives_of_motions_are_their_slopes(motion: HarmonicMotion) -> None:
    times = np.array([3.02, 7.01, 9.99, 25.03])  # off the knots of splines
    h = 1e-4
    at, before, after = (motion.at(times + shift, 4) for shift in (0.0, -h, h))
    for order in range(4):
        slope = (after[order] - before[order]) / (2.0 * h)
        # a record's second derivative is straight between its samples, its third is that of a smoother spline
        tolerance = 1e-2 if isinstance(motion, RecordedMotion) else 1e-5
        np.testing.assert_allclose(slope, at[order + 1], rtol=tolerance, atol=tolerance)


def test_sea_of_mas409_has_the_energy_of_its_spectrum_and_grows_from_rest() -> None:
    motion = mas409_sea(5, ramp=10.0)
    assert np.abs(motion.at(np.array([0.0]), 2)).max() == 0.0
    heave = motion.at(np.arange(10.0, 10.0 + 40.0 * math.pi, 0.05), 0)[0]  # two of its periods: it repeats
    # m0 = A/(4 B) = Hs^2/16; the twenty components from 0.1 to 2 rad/s hold all but the tail
    assert float(heave.std()) == pytest.approx(1.7 / 4.0, rel=0.03)
