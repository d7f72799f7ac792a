"""The swing that a stop leaves is reported with its size, period and decay."""

import math
from dataclasses import replace

import numpy as np
import pytest
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.scenarios import load_scenario
from heave_node.interface.alarm import Severity
from scipy.integrate import solve_ivp
from winch_controller_node.core.supervision.after_stop import decay_of
from winch_controller_node.model.blocks import CableModel


@pytest.mark.parametrize(
    ("swing", "cable"),
    [
        (0.5, CableModel(a=7.2, b=0.02)),
        (1.4, CableModel(a=7.2, b=0.001, drag=0.05)),
        (0.4, CableModel(a=1.1, b=0.002, drag=0.22)),
        (0.2, CableModel(a=0.13, b=0.01)),
    ],
)
def test_period_and_half_life_are_those_of_the_equation_solved_by_scipy(swing, cable):
    def motion(_, state):
        z, v = state
        return v, -(z + max(cable.b, cable.drag * abs(v)) * v) / cable.a

    decay = decay_of(swing, cable)
    solved = solve_ivp(motion, (0.0, 1.3 * decay.half), (swing, 0.0), rtol=1e-7, atol=1e-9, max_step=0.1)
    amplitude = np.hypot(solved.y[0], math.sqrt(cable.a) * solved.y[1])
    assert np.interp(decay.half, solved.t, amplitude) == pytest.approx(0.5 * swing, rel=0.05)
    falling = solved.t[1:][(solved.y[0][1:] < 0.0) & (solved.y[0][:-1] >= 0.0)]
    assert np.mean(np.diff(falling)) == pytest.approx(decay.period, rel=0.02)


def test_an_undamped_swing_never_halves():
    assert decay_of(1.0, CableModel(a=1.0, b=0.0)).half == math.inf


def stopped(seed, seconds, *, stop_at, moves=False):
    """Return the alarms of a loop that an emergency stop of the winch ends, and its record from then on."""
    loop = ClosedLoop(replace(loop_parameters(load_scenario("b3_deep_900")), seed=seed))
    alarms, rows = [], []
    while loop.tick * 0.05 < stop_at + seconds:
        time = loop.tick * 0.05
        if moves and abs(time - (stop_at - 5.0)) < 0.02:
            loop.controller.move_to_payout(10.0)
        if abs(time - stop_at) < 0.02:
            loop.winch.faults.inject("emergency_stop", start=time, duration=1.0)
        outputs, row = loop.step()
        alarms += [alarm for alarm in outputs.alarms if time > stop_at]
        rows += [row] if time > stop_at + 2.0 else []
    return {alarm.name: alarm for alarm in alarms}, np.array(rows)


@pytest.mark.slow
def test_after_an_emergency_stop_the_operator_is_told_by_how_much_the_load_swings_and_for_how_long():
    """By truth: unit less the one that was never compensated swings by so much, about where the drum has stopped."""
    alarms, rows = stopped(4, 40.0, stop_at=75.0)
    told = alarms["LOAD_SWINGS"]
    assert told.severity is Severity.HIGH
    off = rows[:, 2] - rows[:, 3]
    true = 0.5 * np.ptp(off[: round(told.values["period"] / 0.05)])
    assert told.values["swing"] == pytest.approx(true, rel=0.15)
    assert "Request compensating" in str(told)


@pytest.mark.slow
def test_a_move_that_a_fault_has_ended_is_told_at_the_severity_of_a_load_that_hangs_in_the_waves():
    alarms, _ = stopped(1, 3.0, stop_at=50.0, moves=True)
    assert alarms["MOVE_LOST"].severity is Severity.HIGH
    assert "MOVE_ENDED" not in alarms
