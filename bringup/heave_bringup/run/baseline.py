"""The baseline beside a run: the same scenario and seed under law industrial, in this process."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from heave_bags.analyse.run_record import RunRecord
from heave_bags.signals import RunSignals
from heave_node.parameters import ParameterError
from winch_controller_node.model.lqr import DesignError

from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.run.kappa import scenario_of
from heave_bringup.run.loop_signals import run_signals
from heave_bringup.scenarios import Scenario
from heave_bringup.tables.baseline_law import BASELINE


def baseline_signals(scenario: Scenario) -> RunSignals:
    """Return what a `scenario` comes to under the baseline law.

    Raises DesignError where that law cannot be designed for it.
    """
    parameters: Mapping[str, object] = {
        **scenario.parameters,
        "winch_controller": replace(scenario.parameters["winch_controller"], law=BASELINE),
    }
    loop = loop_parameters(replace(scenario, parameters=parameters))
    return run_signals(ClosedLoop(loop).run(), loop)


def add_baseline(record: RunRecord, bag: Path, given: Scenario | None = None) -> None:
    """Put the baseline of a run into its record; where it cannot be computed, a note says why.

    Parameters
    ----------
    record : of the run
    bag : folder that it was read from, with the scenario in it
    given : scenario of the run, where the bag carries none
    """
    scenario = scenario_of(bag) or given
    if scenario is None:
        record.notes.append("the baseline is unknown: the bag carries no scenario (--scenario names one)")
        return
    if scenario.run.external:
        record.notes.append(f"the baseline is unknown: {scenario.run.external[0]} was not simulated")
        return
    try:
        record.signals.baseline = baseline_signals(scenario)
    except (DesignError, ParameterError, ArithmeticError, ValueError) as error:  # a bag may carry any scenario
        record.notes.append(f"the baseline is unknown: {' '.join(str(error).split())}")
