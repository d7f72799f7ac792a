"""The pump-controlled drive: the published state space exactly, then its valves, limits and variable motors."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from cable_sim_node.winch.drives.interface import DriveCommand
from heave_drives.parameters import MotionParameters, PumpDriveParameters
from heave_drives.published import zinage_drive
from heave_drives.pump_controlled import PumpDrive
from heave_node.interface.codes import WinchLimit
from scipy.linalg import expm

LONG = MotionParameters(speed_limit=10.0, overspeed=0.0, payout_minimum=-500.0, payout_maximum=500.0)


def published_matrices() -> tuple[np.ndarray, np.ndarray]:
    """Return A and B of x = (swash, pressure, reel speed, reeled length) as Zinage & Somayajula print them."""
    k_b, v_c, d_p, d_m, w_p, t_p = 1.8e9, 2e-3, 40e-6, 4e-6, 45.0, 1.0
    ratio, r, eta, j_w, d, m = 200.0, 0.5, 0.65, 150.0, 1e4, 1000.0
    a = np.zeros((4, 4))
    a[0, 0] = -1.0 / t_p
    a[1, 0] = -2.0 * k_b / v_c * d_p * w_p
    a[1, 2] = 2.0 * k_b / v_c * d_m * ratio / r
    a[2, 1] = -r * d_m * ratio * eta / (j_w + m * r**2)
    a[2, 2] = -d / (j_w + m * r**2)
    a[3, 2] = 1.0
    return a, np.array([1.0 / t_p, 0.0, 0.0, 0.0])


def test_poles_of_the_published_winch() -> None:
    poles = np.sort_complex(np.linalg.eigvals(published_matrices()[0]))
    np.testing.assert_allclose(poles, [-12.5 - 41.4216j, -12.5 + 41.4216j, -1.0, 0.0], atol=1e-4)


@pytest.mark.parametrize("duration", [0.001, 0.002, 0.05])
def test_published_winch_is_its_state_space(duration: float) -> None:
    a, b = published_matrices()
    exact = expm(np.block([[a, b[:, None]], [np.zeros((1, 5))]]) * duration)
    drive, x = PumpDrive(zinage_drive()), np.zeros(4)
    stream = np.random.default_rng(3)
    for u in stream.uniform(-1.0, 1.0, 40).repeat(5):  # the swash stays inside its range
        drive.step(DriveCommand(payout_rate=1.125 * u), duration, 0.0)
        x = exact[:4, :4] @ x + exact[:4, 4] * u
    seen = drive.instruments()
    got = np.array([seen["swash"], seen["pressure_pa"] * 1e-7, drive.state.payout_rate, drive.state.payout])
    np.testing.assert_allclose(got, x * [1.0, 1e-7, 1.0, 1.0], rtol=1e-9, atol=1e-12)


def test_an_input_of_two_hundred_times_full_swash_drives_the_lag_and_the_swash_ends_at_full() -> None:
    drive = PumpDrive(zinage_drive())
    state = drive.step(DriveCommand(payout_rate=1e6), 0.004, 0.0)
    # x = 200 (1 - exp(-t/1 s))
    assert drive.instruments()["swash"] == pytest.approx(200.0 * (1.0 - np.exp(-0.004)), rel=1e-9)
    assert state.limits & WinchLimit.SPEED
    for _ in range(100):
        state = drive.step(DriveCommand(payout_rate=1e6), 0.05, 0.0)
        assert drive.instruments()["swash"] <= 1.0
    assert state.limits & WinchLimit.FLOW
    assert state.payout_rate == pytest.approx(1.125, rel=1e-9)  # Q/A = 1.8e-3/1.6e-3


def test_static_load_is_held_and_leakage_made_good() -> None:
    p = PumpDriveParameters()
    drive = PumpDrive(p, tension=60e3)
    for _ in range(100):
        state = drive.step(DriveCommand(0.0), 0.05, 60e3)
    assert abs(state.payout) < 1e-4
    pressure = drive.instruments()["pressure_pa"]
    assert pressure == pytest.approx(60e3 / p.area, rel=1e-3)
    assert state.supply_power == pytest.approx(p.leakage * pressure**2, rel=0.01)  # all that the pump gives


def test_set_point_is_met_under_load_without_error() -> None:
    drive = PumpDrive(dataclasses.replace(PumpDriveParameters(), motion=LONG), tension=60e3)
    for _ in range(200):
        state = drive.step(DriveCommand(0.5), 0.05, 70e3)
    assert state.payout_rate == pytest.approx(0.5, rel=1e-4)


def test_relief_valves_end_the_pressure() -> None:
    p = dataclasses.replace(PumpDriveParameters(), relief_pressure=15e6, motion=LONG)
    drive = PumpDrive(p, tension=60e3)
    for _ in range(40):
        state = drive.step(DriveCommand(0.0), 0.05, 150e3)  # needs 30 MPa
        assert abs(drive.instruments()["pressure_pa"]) <= 15e6
    assert state.limits & WinchLimit.PRESSURE
    assert state.payout_rate > 0.1  # the load pulls the rope out


def test_power_limit_bounds_what_the_pump_gives() -> None:
    p = dataclasses.replace(PumpDriveParameters(), power_limit=30e3, motion=LONG)
    drive = PumpDrive(p, tension=60e3)
    powers = []
    for _ in range(200):
        state = drive.step(DriveCommand(-1.2), 0.05, 60e3)
        powers.append(state.supply_power)
    assert max(powers) <= 30e3 * (1.0 + 1e-9)
    assert state.limits & WinchLimit.POWER
    assert -0.5 < state.payout_rate < -0.25  # 30 kW/60 kN less what leaks and rubs


def test_variable_motors_give_speed_for_force() -> None:
    fixed = dataclasses.replace(PumpDriveParameters(), motion=LONG)
    variable = dataclasses.replace(fixed, motor_minimum=0.4)
    speeds = []
    for p in (fixed, variable):
        drive = PumpDrive(p, tension=20e3)
        for _ in range(300):
            state = drive.step(DriveCommand(2.0 * p.full_speed), 0.05, 20e3)
        speeds.append(state.payout_rate)
    assert speeds[0] == pytest.approx(fixed.full_speed, rel=0.02)
    assert speeds[1] == pytest.approx(2.0 * fixed.full_speed, rel=0.02)


def test_a_load_that_the_relief_valves_cannot_hold_is_refused() -> None:
    with pytest.raises(ValueError, match=r"the relief valves open at 3.5e\+07 Pa"):
        PumpDrive(PumpDriveParameters(), tension=1e6)
