"""The electric drive: its loop against the exact linear solution, its motor's curve, its anti-windup and its brake."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from cable_sim_node.winch.drives.interface import DriveCommand
from heave_drives.electric import ElectricDrive
from heave_drives.parameters import ElectricDriveParameters, FrictionParameters, MotionParameters
from heave_node.interface.codes import WinchLimit
from scipy.linalg import expm

TICK = 0.05
SMOOTH = ElectricDriveParameters(
    motion=MotionParameters(payout_minimum=-500.0, payout_maximum=500.0),
    friction=FrictionParameters(viscous=3e3),
    torque_limit=1e6,
    motoring_power_limit=1e9,
    regeneration_power_limit=1e9,
    acceleration_limit=1e6,
)
RADIUS = 0.5 + 0.047 / 2.0


def run(drive: ElectricDrive, rate: float, seconds: float, tension: float, brake: bool = False) -> np.ndarray:
    """Return payout, rate and acceleration after each tick."""
    rows = []
    for _ in range(round(seconds / TICK)):
        state = drive.step(DriveCommand(rate, brake=brake), TICK, tension)
        rows.append((state.payout, state.payout_rate, state.payout_acceleration))
    return np.array(rows)


def test_loop_without_limits_is_its_linear_system() -> None:
    p, tension, load = SMOOTH, 50e3, 52e3
    mass = (p.drum_inertia + p.gear_ratio**2 * p.motor_inertia) / RADIUS**2
    ratio, gain = p.gear_ratio / RADIUS, p.bandwidth * mass
    # states: payout, rate, reference, integral, torque; inputs: set-point, tension
    a, b = np.zeros((5, 5)), np.zeros((5, 2))
    a[0, 1] = 1.0
    a[1] = [0.0, -3e3 / mass, 0.0, 0.0, ratio / mass]
    b[1, 1] = 1.0 / mass
    a[2, 2], b[2, 0] = -1.0 / p.reference_time, 1.0 / p.reference_time
    a[3, 1:3] = np.array([-gain, gain]) / p.integral_time
    asked = mass * a[2] + np.array([0.0, -gain, gain, 1.0, 0.0])
    a[4] = asked / ratio / p.torque_time_constant
    a[4, 4] -= 1.0 / p.torque_time_constant
    b[4, 0] = mass * b[2, 0] / ratio / p.torque_time_constant
    step = expm(np.block([[a, b], [np.zeros((2, 7))]]) * TICK)
    x = np.array([0.0, 0.0, 0.0, -tension, -tension / ratio])
    drive = ElectricDrive(p, tension=tension)
    for rate in (0.8, 0.8, 0.8, -0.5, -0.5, 0.1, 0.1, 0.1, 0.1):
        state = drive.step(DriveCommand(rate), TICK, load)
        x = step[:5, :5] @ x + step[:5, 5:] @ [rate, load]
        assert state.payout == pytest.approx(x[0], rel=1e-4, abs=1e-7)
        assert state.payout_rate == pytest.approx(x[1], rel=1e-4, abs=1e-6)
        assert drive.instruments()["motor_torque_nm"] == pytest.approx(x[4], rel=1e-3, abs=0.1)
    assert state.limits == WinchLimit.NONE


def test_error_of_the_integration_falls_with_the_fourth_power_of_the_substep(monkeypatch: pytest.MonkeyPatch) -> None:
    def payout(substep: float) -> float:
        monkeypatch.setattr("heave_drives.electric.SUBSTEP", substep)
        return float(run(ElectricDrive(SMOOTH, tension=50e3), 0.8, 0.3, 50e3)[-1, 0])

    exact = payout(0.01)
    assert (payout(0.4) - exact) / (payout(0.2) - exact) == pytest.approx(16.0, rel=0.25)


def test_hauling_is_at_constant_torque_then_at_constant_power() -> None:
    tension = 100e3
    motion = MotionParameters(speed_limit=6.0, payout_minimum=-500.0, payout_maximum=500.0)
    p = dataclasses.replace(
        SMOOTH, motion=motion, torque_limit=3000.0, motoring_power_limit=300e3, friction=FrictionParameters()
    )
    drive = ElectricDrive(p, tension=tension)
    mass = (p.drum_inertia + p.gear_ratio**2 * p.motor_inertia) / RADIUS**2
    corner = 300e3 / (3000.0 * p.gear_ratio / RADIUS)
    rows = run(drive, -6.0, 12.0, tension)
    slow = (rows[:, 1] < -0.1 * corner) & (rows[:, 1] > -0.9 * corner)
    assert slow.sum() > 3
    # M v' = T - tau G/rho
    np.testing.assert_allclose(rows[slow, 2], (tension - 3000.0 * p.gear_ratio / RADIUS) / mass, rtol=1e-3)
    # where all power goes into lifting, v = P/T
    assert rows[-1, 1] == pytest.approx(-300e3 / tension, rel=1e-3)
    assert drive.state.limits & WinchLimit.POWER
    torque = drive.instruments()["motor_torque_nm"]
    assert drive.state.supply_power == pytest.approx(300e3 + p.copper_loss * (torque / 3000.0) ** 2, rel=1e-6)


def test_a_load_beyond_the_torque_is_followed_by_no_more_overshoot_than_any_step() -> None:
    p = dataclasses.replace(SMOOTH, torque_limit=1500.0)  # holds 115 kN
    drive = ElectricDrive(p, tension=50e3)
    overhauled = run(drive, -0.5, 3.0, 130e3)
    assert overhauled[-1, 1] > 0.0  # the load runs away with the drum, slowly
    assert drive.state.limits & WinchLimit.TORQUE
    freed = run(drive, -0.5, 6.0, 50e3)
    assert freed[-1, 1] == pytest.approx(-0.5, rel=1e-3)
    assert freed[:, 1].min() > -0.5 * 1.25


def test_reference_keeps_the_acceleration_limit() -> None:
    p = dataclasses.replace(SMOOTH, acceleration_limit=0.4, friction=FrictionParameters())
    rows = run(ElectricDrive(p, tension=50e3), 1.0, 2.0, 50e3)
    assert np.abs(rows[:, 2]).max() <= 0.4 * 1.06  # the loop itself overshoots a little
    np.testing.assert_allclose(rows[10:40, 2], 0.4, rtol=1e-2)


def test_brake_stops_with_its_deceleration_holds_and_lets_go_without_a_drop() -> None:
    drive = ElectricDrive(ElectricDriveParameters(), tension=80e3)
    before = run(drive, 1.2, 3.0, 80e3)[-1]
    rows = run(drive, 1.2, 2.0, 80e3, brake=True)
    assert drive.state.brake
    assert rows[-1, 0] - before[0] == pytest.approx(before[1] ** 2 / (2.0 * 1.5), rel=1e-3)
    run(drive, 0.0, 2.0, 95e3, brake=True)  # the load changes meanwhile
    held = drive.state.payout
    released = run(drive, 0.0, 3.0, 95e3)
    assert np.abs(released[:, 0] - held).max() < 1e-3


def test_tension_fed_forward_leaves_less_of_a_jump_in_load() -> None:
    slack = [
        np.abs(
            run(ElectricDrive(dataclasses.replace(SMOOTH, tension_feed_forward=f), tension=50e3), 0.0, 3.0, 70e3)[:, 0]
        ).max()
        for f in (0.0, 1.0)
    ]
    assert slack[1] < 0.1 * slack[0]
