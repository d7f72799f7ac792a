"""Constant tension above a unit that stands on the bottom: which one, and without the motion reference unit."""

from unittest import mock

import numpy as np
import pytest
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.scenarios import load_scenario
from winch_controller_node.core.supervision.modes import ModeError

DT = 0.05
LOST, FOUND = 85.0, 145.0
"""When the motion reference unit falls silent, and speaks again [s]."""

SHORTER = {
    "b7_landing": (
        "cable_sim.seabed.depth=580.0",
        "winch_controller.programme.move_payouts=[14.0]",
        "winch_controller.programme.move_speeds=[0.25]",
        "winch_controller.programme.mode_times=[]",
        "winch_controller.programme.modes=[]",
        "wave_vessel.ramp=20.0",
    ),
    "b13_landing_soft": (),
}
"""Settings with which the unit stands 20 s before."""


def landed(name, *settings):
    """Return the loop of a shipped landing, begun at once, with a law that works little."""
    common = ("all.duration=150.0", "winch_controller.law=lqg", "winch_controller.programme.move_times=[20.0]")
    return ClosedLoop(loop_parameters(load_scenario(name, settings=[*common, *SHORTER[name], *settings])))


def tension_in_the_gap(record):
    """Return the tension from 5 s after the loss on [N]."""
    time = record.column("time")
    return record.column("top_tension")[(time > LOST + 5.0) & (time < FOUND)]


@pytest.mark.parametrize("name", SHORTER)
def test_a_landed_unit_without_mru_has_less_than_half_of_the_tension_swing_of_a_brake(name):
    """A loop that follows the tension as it is read swings at the wire's first axial mode, more than a brake does."""
    fault = {"kind": "gap", "start": LOST, "duration": FOUND - LOST, "magnitude": 0.0}
    alone = landed(name, *(f"wave_vessel.mru.faults.{key}=[{value}]" for key, value in fault.items())).run()
    loop = landed(name)
    step = loop.controller.step

    def braked(tick, measured):
        outputs = step(tick, measured)
        order = outputs.order._replace(payout_rate=0.0, brake=True) if tick * DT > LOST else outputs.order
        return outputs._replace(order=order)

    loop.controller.step = braked
    held = loop.run()
    assert set(alone.modes[round(LOST / DT) :]) == {"constant_tension"}
    assert "WINCH_SATURATED" not in {alarm.name for _, alarm in alone.alarms}
    assert np.std(tension_in_the_gap(alone)) < 0.5 * np.std(tension_in_the_gap(held))


BRAKED, ASKED = 80.0, 100.0
"""When a landed unit is put on the brake, and from when on constant tension is asked for [s]."""


def on_the_brake(name):
    """Return the loop of a shipped landing whose unit stands below a brake until `ASKED`."""
    loop = landed(name, "all.duration=170.0")
    for tick in range(round(ASKED / DT)):
        if tick == round(BRAKED / DT):
            loop.controller.set_mode("standby")
        loop.step()
    assert loop.controller.mode.value == "standby"
    return loop


def tension_taken(controller):
    """Return the tension that constant tension would hold were it asked for now without one [N]."""
    with (
        mock.patch.object(controller.modes, "request"),
        mock.patch.object(controller, "_hold_tension") as hold,
    ):
        controller.set_mode("constant_tension")
    return hold.call_args.args[0]


@pytest.mark.parametrize("name", SHORTER)
def test_constant_tension_without_a_tension_holds_the_mean_over_waves_at_whatever_instant_it_is_asked_for(name):
    """A brake holds the landed unit in waves: the mean of the cable's tension over a minute is the present mean."""
    loop = on_the_brake(name)
    taken, tension = [], []
    for tick in range(round(60.0 / DT)):
        tension.append(loop.step()[1][7])
        if tick % 20 == 0:
            taken.append(tension_taken(loop.controller))
    mean, swing = np.mean(tension), np.std(tension)
    # of a wave of 9 s a mean over 15 s leaves 2/(w t), 0.19 of the amplitude, and groups of waves differ
    assert np.max(np.abs(taken - mean)) < 0.35 * np.sqrt(2.0) * swing
    assert abs(np.mean(taken[30:]) - mean) < 0.1 * swing


def test_constant_tension_without_a_tension_waits_for_a_mean_and_says_for_how_long():
    controller = on_the_brake("b7_landing").controller
    controller._estimation.restart_tension()
    with pytest.raises(ModeError, match=r"for 10 s more, .*state the tension to hold"):
        controller.set_mode("constant_tension")
    controller.set_mode("constant_tension", 40e3)
    assert controller.mode.value == "constant_tension"


def test_a_unit_that_stands_without_a_landing_is_known_by_the_mean_tension_over_waves():
    """It may have been set down with the controller off."""
    loop = on_the_brake("b7_landing")
    controller = loop.controller
    controller._supervisor.landing.unit_stands = False
    for _ in range(round(controller._supervisor._load.swing_time / DT) - 1):
        loop.step()
        with pytest.raises(ModeError, match="suspended"):
            controller.set_mode("constant_tension", 40e3)
    for _ in range(round(10.0 / DT)):
        loop.step()
    with pytest.raises(ModeError, match="of the load on average"):
        controller.ask_for_mode("compensating")
    controller.set_mode("constant_tension", 40e3)
    assert controller.mode.value == "constant_tension"
    assert "lifting off" in controller.set_mode("compensating")
