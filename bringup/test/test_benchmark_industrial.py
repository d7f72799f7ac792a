"""The industrial baseline: what it predicts, what it inverts, and what it does when its sensors fail."""

from __future__ import annotations

import math

import numpy as np
import pytest
from cable_sim_node.winch.command_line import WinchCommand
from cable_sim_node.winch.component import VirtualWinch
from cable_sim_node.winch.parameters import EncoderParameters, WinchParameters
from heave_bringup.benchmark.entrants.industrial import BoomTip, Industrial, Landing, WinchModel
from heave_bringup.benchmark.interface import (
    Command,
    Facts,
    Measurement,
    MruReading,
    Reading,
    SeaFacts,
    SensorFacts,
    Target,
    WinchFacts,
    WinchReading,
)

PERFECT = SensorFacts(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
FACTS = Facts("test", 0.05, 60.0, WinchFacts(0.15, 0.2, 2.0, 2.0, 1.5, -50.0, 50.0), PERFECT, SeaFacts(1.5, 10.0), {})
W = 2.0 * math.pi / 10.0


def wave(time: float, amplitude: float = 0.5) -> MruReading:
    x, v, a = (amplitude * W**k * math.sin(W * time + 0.5 * math.pi * k) for k in range(3))
    return MruReading(time, x, v, a, sequence=round(time / 0.05))


def test_boom_tip_is_predicted_over_the_delay() -> None:
    tip = BoomTip(FACTS)
    for k in range(1200):
        tip.step(0.05 * k, (wave(0.05 * k),))
    predicted, truth = tip.ahead(0.225), wave(0.05 * 1199 + 0.225)
    assert predicted[0] == pytest.approx(truth.heave, abs=5e-4)
    assert predicted[1] == pytest.approx(truth.heave_rate, abs=2e-3)


def test_readings_that_come_late_are_put_where_they_belong() -> None:
    prompt, late = BoomTip(FACTS), BoomTip(FACTS)
    for k in range(1200):
        prompt.step(0.05 * k, (wave(0.05 * k),))
        late.step(0.05 * k, (wave(0.05 * k - 0.1),) if k >= 2 else ())
    assert late.ahead(0.0) == pytest.approx(prompt.ahead(0.0), abs=2e-3)


def test_model_of_the_winch_is_the_winch_whose_facts_are_true() -> None:
    parameters = WinchParameters(encoder=EncoderParameters(resolution=0.0))
    winch, model = VirtualWinch(parameters, tick_period=0.05), WinchModel(FACTS)
    stream = np.random.default_rng(2)
    payouts = []
    ahead = []
    for tick, rate in enumerate(stream.uniform(-0.4, 0.4, 40).repeat(10)):
        ahead.append(model.ahead(winch.state.payout)[0])
        model.step(rate)
        winch.step(tick, WinchCommand(tick + 1, 0.0, rate), 0.0)
        payouts.append(winch.state.payout)
    # what is predicted at t_k is the payout at t_k + 0.2 s, four ticks on; a limit acts a little otherwise in between
    np.testing.assert_allclose(ahead[20:-3], payouts[22 + 1 :][: len(ahead[20:-3])], atol=4e-3)


def loop(readings: bool = True) -> tuple[np.ndarray, list[Command]]:
    """Return the outlet's residual and the commands of a run of 120 s on a sine; the MRU falls silent at 90 s."""
    winch = VirtualWinch(WinchParameters(), tick_period=0.05)
    controller, residual, commands = Industrial(FACTS), [], []
    for k in range(2400):
        t, state = 0.05 * k, winch.state
        said = (wave(t),) if readings or t < 90.0 else ()
        reading = WinchReading(state.encoder_payout, state.encoder_payout_rate, state.brake)
        command = controller.step(Measurement(t, said, (), (), reading, Target()))
        winch.step(k, WinchCommand(k + 1, command.payout, command.payout_rate, command.brake), 0.0)
        residual.append(0.5 * math.sin(W * t) - state.payout)
        commands.append(command)
    return np.array(residual), commands


def test_a_sine_is_followed_to_a_hundredth_with_lag_and_delay_inverted() -> None:
    residual, _ = loop()
    assert float(residual[1200:].std()) < 0.01 * 0.5 / math.sqrt(2.0)


def test_a_silent_motion_reference_unit_is_coasted_over_for_a_second_and_then_the_winch_stands() -> None:
    residual, commands = loop(readings=False)
    assert float(np.abs(residual[1800:1818]).max()) < 0.02
    assert abs(commands[1800 + 60].payout_rate) < 0.3
    assert abs(commands[-1].payout_rate) < 0.01


def test_frozen_and_wild_readings_are_not_believed() -> None:
    tip = BoomTip(FACTS)
    for k in range(800):
        tip.step(0.05 * k, (wave(0.05 * k),))
    before = tip.ahead(0.0)
    spike = MruReading(40.0, 5.0, 0.0, math.nan, sequence=800)
    tip.step(40.0, (spike,))
    assert tip.ahead(0.0)[0] == pytest.approx(wave(40.0).heave, abs=0.01)
    assert abs(tip.ahead(0.0)[0] - before[0]) < 0.05
    for k in range(801, 840):
        tip.step(0.05 * k, (MruReading(0.05 * k, 0.1, 0.2, math.nan, sequence=k),))
    assert tip.ahead(0.2)[1] == 0.0  # nothing heard for more than a second


def test_lowering_ends_where_the_load_cell_says_that_the_unit_stands() -> None:
    landing = Landing(0.05)

    def given(t: float, tension: float, target: Target) -> tuple[float, float]:
        cell = (Reading(t, tension),)
        return landing.bounded(Measurement(t, (), (), cell, WinchReading(0.0, 0.0), target))

    for k in range(400):
        assert given(0.05 * k, 100e3, Target(0.01 * k, 0.2)) == (0.01 * k, 0.2)
    stood = [given(20.0 + 0.05 * k, 50e3, Target(4.0 + 0.01 * k, 0.2))[0] for k in range(200)]
    assert stood[-1] == stood[-50]
    assert 4.0 < stood[-1] < 5.5
    assert given(40.0, 50e3, Target(5.9, -0.2))[0] == stood[-1]
    assert given(41.0, 50e3, Target(3.0, -0.2)) == (3.0, -0.2)


def test_a_fault_of_the_winch_is_acknowledged_by_the_brake_and_then_released() -> None:
    controller = Industrial(FACTS)
    brakes = []
    for k in range(60):
        reading = WinchReading(0.0, 0.0, brake=True, fault=1 if k < 30 else 0)
        brakes.append(controller.step(Measurement(0.05 * k, (wave(0.05 * k),), (), (), reading, Target())).brake)
    assert all(brakes[:20])
    assert not any(brakes[20:])
