"""The whole loop on winches with their physics, which the controller takes for the simple servo of `system.winch`."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from heave_bringup.closed_loop import ClosedLoop, LoopRecord, loop_parameters
from heave_bringup.scenarios import load_scenario

QUICK = ("cable_sim.segments=5", "winch_controller.law=lqg")
KNOWN_LAG = ("winch_controller.lag.adaptation=false", "winch_controller.winch.time_constant=0.1")
"""Friction and leakage change the pump drive's speed by some per cent, from which its lag cannot be distinguished."""
SETTLED = 60.0
"""From here on the sea is at its height and compensation active [s]."""

WEAK = "virtual_winch.pump_controlled.pump_displacement=20e-6"
"""A drive that holds the load, but is about half as fast as b4 asks for."""


def run(scenario: str, *settings: str, duration: float) -> LoopRecord:
    parameters = loop_parameters(load_scenario(scenario, settings=settings))
    return ClosedLoop(dataclasses.replace(parameters, duration=duration)).run()


def share_left(record: LoopRecord) -> float:
    """Return the unit's motion over that of the uncompensated one."""
    return record.unit_sigma(SETTLED) / record.uncompensated_sigma(SETTLED)


@pytest.mark.parametrize(
    "drive",
    ["electric", *(pytest.param(name, marks=pytest.mark.long) for name in ("pump_controlled", "valve_controlled"))],
)
@pytest.mark.slow
def test_a_drive_with_its_physics_compensates_as_the_servo_does(drive):
    """The servo leaves 2 %: `b2_calm_300` with it, the controller and the sensors being the same."""
    known = KNOWN_LAG if drive == "pump_controlled" else ()
    record = run("b2_calm_300", *QUICK, *known, f"virtual_winch.drive={drive}", duration=100.0)
    assert set(record.modes[round(SETTLED / 0.05) :]) == {"compensating"}
    assert share_left(record) < 0.05


@pytest.mark.long
def test_a_pump_too_weak_for_the_sea_moves_the_unit_no_more_than_none():
    """The guard copes: what the drive does not give the controller learns, or it gives up."""
    record = run("b4_limit_900_tp10", *QUICK, "virtual_winch.drive=pump_controlled", WEAK, duration=600.0)
    assert np.mean(record.column("limits_hit", after=SETTLED) != 0.0) > 0.02
    assert share_left(record) <= 1.02


@pytest.mark.long
def test_a_valve_a_third_as_large_as_the_sea_asks_for_moves_the_unit_no_more_than_none():
    """Its speed ends at 0.45 m/s by the flow that it lets through, which the winch does not call a speed limit."""
    small = "virtual_winch.valve_controlled.valve.rated_flow=4e-3"
    record = run("b4_limit_900_tp10", "virtual_winch.drive=valve_controlled", small, duration=300.0)
    assert share_left(record) <= 1.02


@pytest.mark.long
@pytest.mark.parametrize("scenario", ["drive_electric_900", "drive_pump_300", "drive_valve_300"])
def test_the_shipped_scenarios_of_drives_keep_what_they_want(scenario):
    record = run(scenario, duration=300.0)
    assert set(record.modes[round(SETTLED / 0.05) :]) == {"compensating"}
    assert share_left(record) < 0.1
