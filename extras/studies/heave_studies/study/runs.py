"""One case of a study: pure components in this process, no ROS; its figures, its verdict, why it was lost."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from heave_bags.analyse import kpi_set
from heave_bags.analyse.events import COMPENSATES
from heave_bags.analyse.verdict import Judged, Verdict
from heave_bags.signals import RunSignals, Signal
from heave_bringup.closed_loop import ClosedLoop, LoopRecord, loop_parameters
from heave_bringup.run.criteria import refuse_unknown
from heave_bringup.run.loop_signals import run_signals
from heave_bringup.scenarios import Scenario, load_scenario
from heave_bringup.stored_scenario import stored_sections, stored_title
from heave_node import kpi
from heave_node.errors import one_line
from heave_node.interface.alarm import Severity
from heave_node.numerics.arrays import Array
from heave_node.parameters import ParameterError
from heave_node.scenario import sections_text
from numpy.typing import NDArray

from heave_studies.study.cost import JUDGE, LOOP, START, Meter
from heave_studies.study.plan import Case, Study

BOUND = "kappa"
"""Figure that needs bounds, seconds of work: computed only where a criterion asks for it."""

WITH_THE_END = 0.2
"""Time after compensation ended within which an alarm still counts as its reason [s]."""
ANNOUNCED = kpi.WORSE_WINDOW
"""A minute is announced by an alarm that came in it, or within so long before it [s]."""
LEAST = Severity.MEDIUM
"""Severity from which on an alarm announces."""


class Minute(NamedTuple):
    """A minute of a run."""

    ratio: float  # s(z) / s(z_off) [-]; NaN: no minute counts
    start: float = math.nan  # of it [s]


NO_MINUTE = Minute(math.nan)


SEED = re.compile(r"^    seed: \d+$", re.MULTILINE)
"""The seed of a run in the text of its scenario, of which the run's own section is the first."""


@dataclass(frozen=True)
class Task:
    """A case that is ready to run, here or in another process."""

    case: Case  # of the study
    scenario: Scenario  # checked
    has_adviser: bool = True  # the adviser takes part
    alike: Task | None = field(default=None, repr=False, compare=False)  # one before it, which has another seed alone

    @cached_property
    def text(self) -> str:
        """All active values as a scenario file has them: what repeats the case."""
        if self.alike is not None:  # to write them takes longer than a screened lift
            return SEED.sub(f"    seed: {self.scenario.run.seed}", self.alike.text, count=1)
        return sections_text(stored_sections(self.scenario), title=stored_title(self.scenario))

    @property
    def values(self) -> str:
        """All active values, in a form that is quick to make: it distinguishes one case from another."""
        one = self.scenario
        if self.alike is not None:
            return repr((self.alike.case.number, one.run.seed))
        return repr((one.run, dict(one.parameters), one.wanted, dict(one.quality_of_service), one.changed))


@dataclass(frozen=True)
class CaseResult:
    """What a case came to: its KPIs, or why it failed."""

    case: Case  # what was run
    kpis: Mapping[str, float] = field(default_factory=dict)  # figures of merit by key
    failure: str = ""  # why it could not be run; "" where it could
    # share of the time after the transient in which the winch compensated or held a tension [-]; NaN under law off
    compensating: float = math.nan
    reason: str = ""  # why it was lost; "" where it was not
    missed: tuple[str, ...] = ()  # breaches and criteria that it does not meet, one line each
    # those of `missed` that fail any run, see `heave_bags.analyse.verdict.Verdict.breaches`
    breaches: tuple[str, ...] = ()
    minute: Minute = NO_MINUTE  # the worst minute that no alarm announced
    cost: Mapping[str, float] = field(default_factory=dict)  # processor time by part [s]
    is_screened: bool = False  # it is of a batch of lifts under a fixed law, see `heave_studies.batch`
    flag: str = ""  # why no screening could have it, where one was asked for

    @property
    def is_lost(self) -> bool:
        """Return whether compensation was given up, or the unit moves more than uncompensated."""
        return bool(self.reason)

    def to_plain(self) -> dict[str, Any]:
        """Return it as plain data, without its case."""
        names = (one.name for one in fields(self) if one.name != "case")
        return {name: getattr(self, name) for name in names} | {"kpis": dict(self.kpis)}


def result_of(case: Case, plain: Mapping[str, Any]) -> CaseResult:
    """Return the result of a `case` from the `plain` data of it."""
    given: dict[str, Any] = {name: tuple(value) if isinstance(value, list) else value for name, value in plain.items()}
    given["minute"] = Minute(*given.get("minute", NO_MINUTE))
    return CaseResult(case, **given)


def make_tasks(study: Study, cases: Sequence[Case]) -> list[Task]:
    """Return the `cases` of a `study` with their parameters; raise ParameterError for the first that is wrong."""
    firsts: dict[str, Task] = {}
    return [_task(study, case, firsts) for case in cases]


def _task(study: Study, case: Case, firsts: dict[str, Task]) -> Task:
    """Return the task of a `case`; `firsts` are those before it that no other one before has but for the seed."""
    known = repr((case.is_nominal, case.settings))
    if known not in firsts:
        firsts[known] = Task(case, _scenario(study, case), study.has_adviser)
        return firsts[known]
    first = firsts[known]
    scenario = replace(first.scenario, run=replace(first.scenario.run, seed=case.seed))
    return Task(case, scenario, study.has_adviser, first)


def _scenario(study: Study, case: Case) -> Scenario:
    """Return the scenario of a `case`, checked."""
    settings = study.settings_of(case)
    scenario = load_scenario(study.scenario_of(case), settings=settings)
    run = scenario.run
    if run.duration <= run.transient:
        source = next((setting.source for setting in settings if setting.name == "duration"), str(scenario.path))
        raise ParameterError(
            f"{source}: duration = {run.duration:g} s leaves nothing after the transient of {run.transient:g} s; "
            "make it longer, or all.transient shorter"
        )
    for criterion in scenario.wanted:
        refuse_unknown(criterion, f"{study.path}: wanted")
    return scenario


def run_task(task: Task) -> CaseResult:
    """Run the case of a `task`; one that cannot be run says why, and harms no other."""
    meter = Meter()
    try:
        with meter.of(START):
            loop = ClosedLoop(loop_parameters(task.scenario), has_adviser=task.has_adviser)
        meter.watch(loop)
        with meter.of(LOOP):
            record = loop.run()
        return judge(task, record, loop.plant.largest_strain, meter)
    except Exception as error:  # one case that cannot be run must not end the others; it is named in the table
        return CaseResult(task.case, failure=one_line(error))


def judge(task: Task, record: LoopRecord, strain: float, meter: Meter) -> CaseResult:
    """Return what the case of a `task` came to.

    Parameters
    ----------
    task : that was run
    record : of its run
    strain : largest of the cable [-]
    meter : of its cost
    """
    case, scenario, parameters = task.case, task.scenario, loop_parameters(task.scenario)
    with meter.of(JUDGE):
        signals = run_signals(record, parameters)
        _add_bounds(signals, record, scenario)
        kpis = kpi_set.evaluate_run(signals, scenario.run.transient, scenario.run.duration)
        minute = silent_minute(record, signals, scenario.run.transient)
    modes = _time_in_modes(record, scenario)
    share = sum(modes.get(mode, 0.0) for mode in COMPENSATES) if scenario.moves_winch else math.nan
    judged = tuple(Judged(criterion, kpis[criterion.kpi]) for criterion in scenario.wanted)
    verdict = Verdict(judged, (), modes, share, strain=strain, loads=signals.load_checks())
    reason, (failures, breaches) = lost_because(record, scenario, kpis), (verdict.failures, verdict.breaches)
    return CaseResult(case, kpis, "", share, reason, tuple(failures), tuple(breaches), minute, meter.seconds)


def _add_bounds(signals: RunSignals, record: LoopRecord, scenario: Scenario) -> None:
    """Put in what kappa is counted from, where it is wanted."""
    if not scenario.moves_winch or BOUND not in {criterion.kpi for criterion in scenario.wanted}:
        return
    from winch_controller_node.design.bounds import BOUND_STEP  # noqa: PLC0415 - seconds to load, seldom needed
    from winch_controller_node.model.lqr import DesignError  # noqa: PLC0415

    from heave_studies.kappa import bounds_of  # noqa: PLC0415

    tip = Signal(record.column("time"), record.column("boom_tip")).window(scenario.run.transient, scenario.run.duration)
    time = np.arange(tip.time[0], tip.time[-1], BOUND_STEP)
    try:
        bounds = bounds_of(scenario, np.interp(time, tip.time, tip.value), BOUND_STEP)
    except (DesignError, ArithmeticError, ValueError):  # no bound, and kappa stays unknown, as for a bag
        return
    signals.sensor_bound, signals.actuator_bound = bounds


def _time_in_modes(record: LoopRecord, scenario: Scenario) -> dict[str, float]:
    """Return the share of the time that is judged by mode, the largest first [-]."""
    modes = Counter(record.modes[np.searchsorted(record.column("time"), scenario.run.transient) :])
    return {mode: count / modes.total() for mode, count in modes.most_common()}


def lost_because(record: LoopRecord, scenario: Scenario, kpis: Mapping[str, float]) -> str:
    """Return why a case was lost: when compensation ended, and the last alarm before; "" where it was not.

    Parameters
    ----------
    record, scenario : of the run
    kpis : its figures
    """
    if not scenario.moves_winch:
        return ""
    time, ahead = record.column("time"), scenario.run.transient
    works = np.isin(record.modes, COMPENSATES)
    out = np.flatnonzero(~works & (time >= ahead))
    if not out.size:
        is_worse = kpis["unit_sigma_m"] > kpis["uncompensated_sigma_m"]
        return "the unit moves more than uncompensated" if is_worse else ""
    begun = np.flatnonzero(works)
    share = f"active {100.0 * float(np.mean(works[time >= ahead])):.1f} % of the time"
    if not begun.size:
        when, words = float(time[-1]), f"compensation never began (mode {record.modes[-1]})"
    elif begun[0] > out[0]:
        when = float(time[begun[0]])
        words = f"compensation began only at {when:.2f} s, {share}"
    else:
        end = int(begun[begun < out[0]][-1]) + 1
        when = float(time[end])
        words = f"compensation ended at {when:.2f} s (mode {record.modes[end]}), {share}"
    alarms = [alarm for at, alarm in record.alarms if at <= when + WITH_THE_END]
    return f"{words}: {alarms[-1]}" if alarms else words


def silent_minute(record: LoopRecord, signals: RunSignals, transient: float) -> Minute:
    """Return the worst minute of a run in which compensation was active throughout and that no alarm announced.

    Parameters
    ----------
    record, signals : of the run
    transient : time before which no minute begins [s]
    """
    heave, off = signals.unit_heave, signals.uncompensated_heave
    starts, ratios = kpi.window_ratios(heave.time, heave.value, off.at(heave), transient, floor=kpi.WORSE_FLOOR)
    counts = silent(record, starts) & np.isfinite(ratios)
    if not counts.any():
        return NO_MINUTE
    worst = int(np.where(counts, ratios, -1.0).argmax())
    return Minute(float(ratios[worst]), float(starts[worst]))


def silent(record: LoopRecord, starts: Array) -> NDArray[np.bool_]:
    """Return which minutes of a `record`, by their `starts` [s], were of compensation and not announced, shape (n,)."""
    time = record.column("time")
    rests = time[~np.isin(record.modes, COMPENSATES)]
    loud = np.array([at for at, alarm in record.alarms if alarm.severity >= LEAST])

    def any_in(events: Array, before: float) -> NDArray[np.bool_]:
        events = np.sort(events)
        first, after = np.searchsorted(events, [starts - before, starts + kpi.WORSE_WINDOW])
        return np.asarray(after > first)

    return np.asarray(~any_in(rests, 0.0) & ~any_in(loud, ANNOUNCED))
