"""Inputs of the plant pass unchanged where they are there, and are bridged without jumps where they are not."""

from __future__ import annotations

import math

import numpy as np
import pytest
from cable_sim_node.inputs import CLOSING_TIME, LONGEST_EXTRAPOLATION, BridgedInput, NewestMotion, ShadowPayout
from heave_node.numerics.kinematics import PointMotion

TICK = 0.05
OMEGA = 0.6


def heave(tick: int) -> PointMotion:
    phase = OMEGA * tick * TICK
    return PointMotion(
        tick * TICK,
        np.array([0.0, 0.0, 1.5 * (1.0 - math.cos(phase))]),
        np.array([0.0, 0.0, 1.5 * OMEGA * math.sin(phase)]),
        np.array([0.0, 0.0, 1.5 * OMEGA**2 * math.cos(phase)]),
    )


def follow(missing: set[int], ticks: int = 2000) -> tuple[BridgedInput, np.ndarray, np.ndarray]:
    signal = BridgedInput("boom_tip", np.zeros(3), tick_period=TICK)
    positions, velocities = [], []
    for tick in range(ticks):
        signal.advance(None if tick in missing else heave(tick))
        positions.append(signal.position[2])
        velocities.append(signal.velocity[2])
    return signal, np.array(positions), np.array(velocities)


def test_complete_signal_passes_bit_for_bit() -> None:
    _, positions, velocities = follow(set())
    assert positions.tolist() == [heave(tick).position[2] for tick in range(2000)]
    assert velocities.tolist() == [heave(tick).velocity[2] for tick in range(2000)]


@pytest.mark.parametrize("missing", [{100}, set(range(100, 105)), set(range(100, 200)), {100, 102, 103, 110}])
def test_missing_values_are_bridged_without_a_jump_and_counted(missing: set[int]) -> None:
    signal, positions, velocities = follow(missing)
    assert signal.missing == len(missing)
    assert signal.missing_in_a_row == 0
    # Consistent motion: each step of position is the mean of its end velocities, to the curvature of the signal.
    np.testing.assert_allclose(np.diff(positions), 0.5 * TICK * (velocities[1:] + velocities[:-1]), atol=2e-3)
    assert np.abs(np.diff(velocities)).max() / TICK < 2.0
    true = np.array([heave(tick).position[2] for tick in range(2000)])
    late = max(missing) + int(30 * CLOSING_TIME / TICK)
    assert np.abs(positions - true)[late:].max() < 1e-6


def test_values_that_are_not_finite_count_as_missing() -> None:
    signal = BridgedInput("payout", np.zeros(1), tick_period=TICK)
    signal.advance(PointMotion(0.0, np.array([math.nan]), np.zeros(1), np.zeros(1)))
    signal.advance(PointMotion(0.0, np.zeros(1), np.array([math.inf]), np.zeros(1)))
    assert signal.missing == 2
    assert np.isfinite(signal.position).all()
    assert np.isfinite(signal.velocity).all()


def test_silent_signal_comes_to_rest() -> None:
    signal, _, velocities = follow(set(range(100, 2000)))
    assert abs(velocities[-1]) < 1e-6
    assert signal.missing_in_a_row == 1900


def test_start_in_full_motion_is_taken_up_smoothly() -> None:
    signal = BridgedInput("boom_tip", np.zeros(3), tick_period=TICK)
    offset = np.array([0.0, 0.0, 2.0])
    velocities = []
    for tick in range(2000):
        motion = heave(tick)
        motion.position += offset
        signal.advance(motion)
        velocities.append(signal.velocity[2])
        if tick == 0:
            assert abs(signal.position[2]) < 0.02
    assert np.abs(np.diff(velocities)).max() / TICK < 2.0
    assert signal.position[2] == pytest.approx(heave(1999).position[2] + 2.0, abs=1e-6)


def test_shadow_payout_follows_the_programme_smoothly_and_rests_without_one() -> None:
    shadow = ShadowPayout(tick_period=TICK)
    for _ in range(100):
        shadow.advance(None)
    assert (shadow.payout, shadow.rate) == (0.0, 0.0)
    for tick in range(2000):
        shadow.advance(0.5 * tick * TICK)
    assert shadow.rate == pytest.approx(0.5, rel=1e-3)
    # A critically damped follower lags a ramp by twice its time constant.
    assert 0.5 * 1999 * TICK - shadow.payout == pytest.approx(2.0 * 0.5, rel=0.05)
    for _ in range(1000):
        shadow.advance(None)
    assert shadow.rate == pytest.approx(0.0, abs=1e-9)


def test_newest_motion_is_given_as_it_is_at_its_own_time_and_carried_forward_until_it_is_too_old() -> None:
    newest = NewestMotion()
    assert newest.at(1.0) is None
    motion = PointMotion(1.0, np.array([2.0]), np.array([0.5]), np.array([-0.2]))
    newest.put(motion)
    assert newest.at(1.0) is motion
    later = newest.at(1.2)
    assert later is not None
    # x + v t + a t^2/2 and v + a t.
    assert later.position[0] == pytest.approx(2.0 + 0.5 * 0.2 - 0.1 * 0.2**2)
    assert later.velocity[0] == pytest.approx(0.46)
    assert newest.at(1.0 + LONGEST_EXTRAPOLATION + 0.01) is None
