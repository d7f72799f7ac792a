"""Time constant and delay of a winch from its set-points and its encoder, on the virtual winch."""

import numpy as np
import pytest
from cable_sim_node.winch.component import VirtualWinch, WinchCommand
from cable_sim_node.winch.parameters import WinchParameters
from heave_node.faults import FaultParameters
from hypothesis import given, settings
from hypothesis import strategies as st
from winch_controller_node.design.design import design_controller
from winch_controller_node.identification.drum_kernel import Drum, drum_record
from winch_controller_node.identification.winch import LateCommands, WinchIdentifier
from winch_controller_node.parameters.controller import WinchControllerParameters

DT = 0.05


@pytest.fixture(scope="module")
def design():
    return design_controller(WinchControllerParameters(), tick_period=DT)


def record_of(winch, commands, gap=()):
    """Drive a winch by rate set-points; yield set-point and encoder at the end of each tick, None in `gap`."""
    winch.step(0, WinchCommand(1))
    for tick, rate in enumerate(commands, start=1):
        state = winch.step(tick, WinchCommand(tick + 1, 0.0, float(rate)))
        yield rate, None if tick in gap else state.encoder_payout


def commands_of(seconds, noise=0.03, size=0.5, seed=1):
    time = np.arange(round(seconds / DT)) * DT
    return size * np.sin(0.7 * time) + noise * np.random.default_rng(seed).standard_normal(len(time))


@settings(max_examples=15, deadline=None)
@given(st.floats(0.05, 0.3), st.floats(0.08, 0.35), st.sampled_from([0.5, 3.0]))
def test_servo_and_delay_are_told_apart_within_and_beyond_the_limits(design, time_constant, delay, size):
    """From a 1 mm encoder; belief 0.15 s and 0.2 s. A size of 3 m/s is beyond the 2 m/s and 1.5 m/s^2 of the winch."""
    identifier = WinchIdentifier(WinchControllerParameters().lag, design)
    winch = VirtualWinch(WinchParameters(time_constant=time_constant, command_delay=delay), tick_period=DT)
    for rate, encoder in record_of(winch, commands_of(20.0, size=size), gap=range(60, 80)):
        identifier.add(0.0, rate, encoder)
    found = identifier.find()
    sigmas = np.sqrt(np.diag(found.covariance))
    assert abs(found.time_constant - time_constant) < 5.0 * sigmas[0] + 0.002
    assert abs(found.delay - delay) < 5.0 * sigmas[1] + 0.002
    assert np.max(sigmas) < 0.02


def test_a_short_or_still_record_tells_nothing_and_changes_nothing(design):
    parameters = WinchControllerParameters()
    identifier = WinchIdentifier(parameters.lag, design)
    assert identifier.find() is None
    for rate, encoder in record_of(VirtualWinch(WinchParameters(time_constant=0.3), tick_period=DT), np.zeros(200)):
        identifier.add(0.0, rate, encoder)
    assert identifier.improved_parameters(parameters) is None


def test_a_position_loop_is_part_of_the_drum():
    """Servo with k_p = 0.5 1/s: the virtual winch's own record, from the same set-points."""
    winch = VirtualWinch(WinchParameters(position_gain=0.5), tick_period=DT)
    commands = commands_of(20.0)
    encoder = np.array([payout for _, payout in record_of(winch, commands)])
    payouts, rates = np.zeros(len(commands) + 10), np.concatenate([np.zeros(10), commands])
    drum = drum_record(payouts, rates, len(commands), Drum(0.15, 0.2, 0.5, 2.0, 1.5), 0.0, 0.0, DT)
    # the encoder rounds to 1 mm; the position loop's steps of 5 ms differ by less
    np.testing.assert_allclose(drum, encoder, atol=1e-3)


def test_a_transport_that_becomes_slower_is_noticed_within_three_ticks_and_said_once():
    """0.2 s more from tick 100 on: the virtual winch says which command it has taken."""
    slower = FaultParameters(kind=("delay",), start=(100 * DT,), duration=(10.0,), magnitude=(0.2,))
    winch = VirtualWinch(WinchParameters(faults=slower), tick_period=DT)
    watch, alarms = LateCommands(DT), {}
    winch.step(0, WinchCommand(1))
    for tick in range(1, 160):
        state = winch.step(tick, WinchCommand(tick + 1, 0.0, 0.1))
        words = watch.update(tick + 1, state.command_sequence, 0.2)
        if words:
            alarms[tick] = words
    # a command of tick 100 was due at the end of tick 103: nothing can be seen before
    assert list(alarms) == [pytest.approx(105, abs=1)]
    assert "later than modelled" in next(iter(alarms.values()))
