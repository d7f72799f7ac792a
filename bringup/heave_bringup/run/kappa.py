"""The bounds in kappa for a recorded run: the best that its sensors and delay, and its winch, would have allowed."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
from heave_bags.analyse.run_record import RunRecord
from heave_bags.mcap.bounds import load_yaml
from heave_bags.mcap.reader import Bag
from winch_controller_node.design.bounds import BOUND_STEP, WinchLimits, actuator_bound
from winch_controller_node.design.design import design_controller
from winch_controller_node.design.prediction import estimation_bound
from winch_controller_node.model.lqr import DesignError

from heave_bringup.scenarios import Scenario, load_scenario

LONGEST = 400.0
"""Part of the record that the clairvoyant plans over [s]: its standard deviation is known to a few per cent then."""


def add_bounds(record: RunRecord, bag: Path, given: Scenario | None = None) -> None:
    """Put the bounds of a run into its record; where they cannot be computed kappa stays unknown, and a note says why.

    Parameters
    ----------
    record : of the run
    bag : folder that it was read from, with the scenario in it
    given : scenario of the run, where the bag carries none
    """
    scenario = _scenario_of(bag) or given
    if scenario is None or not scenario.moves_winch:
        return
    if record.end <= scenario.run.transient:
        return  # the start-up is no measure of the controller
    try:
        s_est, s_act = _bounds(record, scenario)
    except (DesignError, ArithmeticError, ValueError) as error:  # a bag may carry any scenario, and any motion
        record.notes.append(f"kappa is unknown: {' '.join(str(error).split())}")
        return
    record.signals.sensor_bound, record.signals.actuator_bound = s_est, s_act


def _bounds(record: RunRecord, scenario: Scenario) -> tuple[float, float]:
    parameters = scenario.parameters["winch_controller"]
    winch = scenario.parameters["virtual_winch"]
    design = design_controller(parameters, tick_period=scenario.run.tick_period)
    tip = record.signals.boom_tip_heave.window(record.start, min(record.end, record.start + LONGEST))
    if tip.size < 2:
        raise DesignError("the bag holds no motion of the boom tip")
    time = np.arange(tip.time[0], tip.time[-1], BOUND_STEP)
    heave = np.interp(time, tip.time, tip.value - tip.value.mean())
    stroke = min(-winch.payout_minimum, winch.payout_maximum)
    limits = WinchLimits(winch.speed_limit, winch.acceleration_limit, stroke)
    return estimation_bound(design), actuator_bound(design.cable, limits, heave, BOUND_STEP)


def _scenario_of(bag: Path) -> Scenario | None:
    """Return the scenario that the bag carries; None where it carries none that this version can read."""
    for name, content in Bag(bag).attachments.items():
        if name.endswith((".yaml", ".yml")):
            return _parsed(content)
    return None


def _parsed(content: bytes) -> Scenario | None:
    """Return a scenario from the bytes of its file; None if they are none that this version can read."""
    try:
        load_yaml(content)  # held to bounds, since it comes from a file that anyone may have written
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "scenario.yaml"
            path.write_bytes(content)
            return load_scenario(str(path))
    except ValueError:  # ParameterError among them
        return None
