"""The runs of a campaign: pure components in worker processes, no ROS."""

from __future__ import annotations

import math
import multiprocessing
import os
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, field

import numpy as np
from heave_bags.analyse import kpi_set
from heave_bags.analyse.depth_programme import take_out_programme
from heave_bags.analyse.events import COMPENSATES, OFF
from heave_bags.signals import RunSignals, Signal
from heave_node.numerics.arrays import Array
from heave_node.parameters import ParameterError

from heave_bringup.campaign.plan import Campaign, Case
from heave_bringup.closed_loop import ClosedLoop, LoopParameters, LoopRecord, loop_parameters
from heave_bringup.scenarios import Scenario, load_scenario


@dataclass(frozen=True)
class CaseResult:
    """What a case came to: its KPIs, or why it failed.

    Attributes
    ----------
    case : what was run
    kpis : figures of merit by key
    failure : why it could not be run; "" where it could
    compensating : share of the time after the transient in which the winch compensated or held a tension; NaN under
        law off
    """

    case: Case
    kpis: dict[str, float] = field(default_factory=dict)
    failure: str = ""
    compensating: float = math.nan

    @property
    def is_lost(self) -> bool:
        """Return whether compensation was given up, or the unit moves more than uncompensated."""
        return self.compensating < 1.0 or self.kpis["unit_sigma_m"] > self.kpis["uncompensated_sigma_m"]


def run_cases(campaign: Campaign, cases: Sequence[Case], processes: int | None) -> Iterator[CaseResult]:
    """Run every case and yield the results as they come.

    Parameters
    ----------
    campaign : that the cases are of
    cases : to be run
    processes : number of worker processes; None takes one per processor, 1 runs them here

    Every case's parameters are checked before the first one runs; raises ParameterError for the first that is wrong.
    """
    scenarios = [_scenario(campaign, case) for case in cases]
    if processes == 1:
        for scenario, case in zip(scenarios, cases, strict=True):
            yield _run_case(scenario, case)
        return
    workers = min(len(cases), processes or os.cpu_count() or 1)
    with ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn")) as pool:
        pending = [pool.submit(_run_case, scenario, case) for scenario, case in zip(scenarios, cases, strict=True)]
        for finished in as_completed(pending):
            yield finished.result()


def _scenario(campaign: Campaign, case: Case) -> Scenario:
    settings = campaign.settings_of(case)
    scenario = load_scenario(campaign.scenario, settings=settings)
    run = scenario.run
    if run.duration <= run.transient:
        source = next((setting.source for setting in settings if setting.name == "duration"), str(scenario.path))
        raise ParameterError(
            f"{source}: duration = {run.duration:g} s leaves nothing after the transient of {run.transient:g} s"
        )
    return scenario


def _run_case(scenario: Scenario, case: Case) -> CaseResult:
    parameters = loop_parameters(scenario)
    try:
        record = ClosedLoop(parameters).run()
    except Exception as error:  # one case that cannot be run must not end the others; it is named in the table
        return CaseResult(case, failure=" ".join(str(error).split()) or type(error).__name__)
    kpis = kpi_set.evaluate(run_signals(record, parameters), scenario.run.transient, scenario.run.duration)
    return CaseResult(case, kpis, compensating=_compensating(record, scenario))


def _compensating(record: LoopRecord, scenario: Scenario) -> float:
    if not scenario.moves_winch:
        return math.nan
    after = record.column("time") >= scenario.run.transient
    return float(np.mean([mode in COMPENSATES for mode, counts in zip(record.modes, after, strict=True) if counts]))


def _working(record: LoopRecord, time: Array) -> Signal:
    """Return when the controller compensated or held a tension; empty under law off."""
    modes = np.asarray(record.modes)
    return Signal() if np.all(modes == OFF) else Signal(time, np.isin(modes, COMPENSATES).astype(float))


def run_signals(record: LoopRecord, parameters: LoopParameters) -> RunSignals:
    """Return the signals that KPIs are computed from, as a bag of the same run would give them.

    Parameters
    ----------
    record : of the run
    parameters : that it was made with
    """
    time, plant = record.column("time"), parameters.plant

    def signal(name: str) -> Signal:
        return Signal(time, record.column(name))

    signals = RunSignals(
        unit_heave=signal("unit"),
        uncompensated_heave=signal("uncompensated"),
        boom_tip_heave=signal("boom_tip"),
        payout=signal("payout"),
        payout_rate=signal("payout_rate"),
        payout_acceleration=signal("payout_acceleration"),
        tension=signal("top_tension"),
        uncompensated_tension=signal("uncompensated_tension"),
        slack=Signal(time, (record.column("slack_segments") > 0.0).astype(float)),
        winch_limited=Signal(time, (record.column("limits_hit") != 0.0).astype(float)),
        compensating=_working(record, time),
        static_tension=Signal(time[:1], record.column("top_tension")[:1]),
        speed_limit=parameters.winch.speed_limit,
        acceleration_limit=parameters.winch.acceleration_limit,
    )
    weight = plant.cable.weight_in_fluid(plant.water_density, plant.gravity)
    take_out_programme(signals, signal("depth_set_point"), weight)
    return signals
