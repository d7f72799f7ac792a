"""Constant tension above a unit that stands on the bottom, while the motion reference unit is silent."""

import numpy as np
import pytest
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.scenarios import load_scenario

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
    assert not any("saturated" in words for _, words in alone.alarms)
    assert np.std(tension_in_the_gap(alone)) < 0.5 * np.std(tension_in_the_gap(held))
