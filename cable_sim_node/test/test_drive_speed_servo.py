"""The speed servo behind the drives' interface is the one of the virtual winch."""

from __future__ import annotations

import numpy as np
import pytest
from cable_sim_node.winch.command_line import WinchCommand
from cable_sim_node.winch.component import VirtualWinch
from cable_sim_node.winch.drives.interface import DriveCommand
from cable_sim_node.winch.drives.speed_servo import SpeedServo
from cable_sim_node.winch.parameters import WinchParameters
from heave_node.interface.codes import WinchLimit


def test_servo_moves_as_the_virtual_winch_does() -> None:
    parameters = WinchParameters(command_delay=0.0, power_limit=60e3)
    winch, servo = VirtualWinch(parameters, tick_period=0.05), SpeedServo(parameters)
    stream = np.random.default_rng(1)
    for tick, rate in enumerate(stream.uniform(-3.0, 3.0, 60).repeat(4)):
        tension = 80e3 + 10e3 * np.sin(0.1 * tick)
        expected = winch.step(tick, WinchCommand(tick + 1, 0.0, rate), tension)
        state = servo.step(DriveCommand(rate), 0.05, tension)
        assert (state.payout, state.payout_rate) == (expected.payout, expected.payout_rate)
        assert int(state.limits) == int(expected.limits_hit)
        assert state.power == expected.power


def test_brake_stops_within_its_deceleration_and_holds() -> None:
    servo = SpeedServo(WinchParameters())
    for _ in range(40):
        before = servo.step(DriveCommand(1.0), 0.05, 50e3)
    for _ in range(20):
        state = servo.step(DriveCommand(1.0, brake=True), 0.05, 50e3)
    assert state.brake
    assert state.payout - before.payout == pytest.approx(before.payout_rate**2 / 3.0, rel=1e-9)
    assert state.limits == WinchLimit.NONE
