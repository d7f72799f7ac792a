"""An acceptance test as a study: each step is run, and leaves its files in the folder."""

from __future__ import annotations

import hashlib
import json
import math
import platform
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from pathlib import Path

import pandas
from heave_bags.analyse.verdict import FAILED, PASSED, Judged, required_words
from heave_bags.errors import BagError
from heave_bags.record.provenance import git_commit, versions
from heave_bags.report.figure import BOOM_TIP, CM, KN, PAYOUT, UNCOMPENSATED, UNIT, Figure, line
from heave_bags.signals import Signal
from heave_bringup.errors import CommandError
from heave_bringup.network import ANOTHER_RUN, set_up_transport
from heave_bringup.progress import ProgressLine
from heave_bringup.scenarios import Scenario, load_scenario
from heave_bringup.settings import make_setting, parse_setting
from heave_bringup.stored_scenario import stored_sections, stored_title
from heave_devices.bench.limits import Limits
from heave_devices.bench.set_signal import WinchTest
from heave_devices.bench.winch import VirtualPart, WinchPart, run_winch
from heave_devices.maps.device_map import DeviceMap
from heave_node.loads.strength import LEAST, Strength, strengths
from heave_node.numerics.constants import LARGEST_STRAIN
from heave_node.parameters import ParameterError
from heave_node.scenario import sections_text

from heave_studies.accept import measured as figures
from heave_studies.accept.measured import RESIDUALS, Measured, Nominal, of_winch
from heave_studies.accept.procedure import Head, Procedure, RunTest, Step, read_procedure, refuse_late
from heave_studies.accept.runs import run_loop, scenario_of
from heave_studies.study.case_file import CASE, SCENARIO, digest_of
from heave_studies.study.workers import FAILURE, Job, Plain

NOT_DONE = "not done"
"""State of a step that was not run, or could not be."""


@dataclass(frozen=True)
class StepResult:
    """What became of a step."""

    step: Step  # of the procedure
    judged: tuple[Judged, ...] = ()  # its criteria
    breaches: tuple[str, ...] = ()  # what fails any run, in words
    failure: str = ""  # why it could not be done; "": it could
    values: Mapping[str, float] = field(default_factory=dict)  # every figure that is known
    measured: Measured | None = None  # its signals; None: it was not done
    file: Path | None = None  # what it left, a bag or a table; None: nothing
    digest: str = ""  # of that file
    part: str = ""  # what it was run against, in words

    @property
    def state(self) -> str:
        """The verdict in a word: passed, FAILED, or not done."""
        if self.failure or self.measured is None:
            return NOT_DONE
        return PASSED if not self.breaches and all(one.is_met for one in self.judged) else FAILED

    @property
    def failures(self) -> list[str]:
        """What is missed, in words."""
        if self.state == NOT_DONE:
            return [f"{NOT_DONE}: {self.failure or 'interrupted'}"]
        return [*self.breaches, *(str(one) for one in self.judged if not one.is_met)]

    def to_plain(self) -> dict[str, object]:
        """Return it as plain data: what the table, the page and a machine have of it."""
        signal = getattr(self.step.test, "signal", None)
        done = [signal.words if signal else "", f"event: {self.step.event.words}" if self.step.event else ""]
        return {
            "step": self.step.name,
            "what": self.step.what,
            "done": [*(words for words in done if words), *self.breaches],
            "state": self.state,
            "part": self.part,
            "failure": self.failure,
            "criteria": [one.to_json() for one in self.judged],
            "cells": [[*cells(one), "met" if one.is_met else FAILED] for one in self.judged],
            "failures": self.failures if self.state != PASSED else [],
            "residuals": {key: self.values.get(key, math.nan) for key in RESIDUALS},
            "notes": list(self.measured.notes) if self.measured else [],
            "figures": [asdict(one) for one in figures_of(self.measured)] if self.measured else [],
            "file": self.file.name if self.file else None,
            "sha256": self.digest or None,
            "began": time.time(),
        }


def facts_of(procedure: Procedure, scenario: str) -> dict[str, str]:
    """Return what identifies an acceptance test.

    Parameters
    ----------
    procedure : that was run
    scenario : text of its scenario with all values
    """
    known = versions()
    return {
        "procedure": f"{procedure.path.name}, SHA-256 {hashlib.sha256(procedure.text).hexdigest()}",
        "scenario": f"{procedure.scenario} with all values, SHA-256 {hashlib.sha256(scenario.encode()).hexdigest()}",
        "software": ", ".join(f"{name} {version}" for name, version in known.items()),
        "commit": git_commit() or "unknown",
        "host": f"{platform.node()}, {platform.system()} {platform.machine()}",
    }


def cells(judged: Judged) -> tuple[str, str, str]:
    """Return title, required and reached of a criterion that was `judged`."""
    definition = judged.definition
    title = definition.title if definition else judged.criterion.kpi
    return title, required_words(judged.criterion, judged.known), judged.got


def figures_of(one: Measured) -> list[Figure]:
    """Return the figures of what a step left: `one`."""
    run, ordered = one.run, one.ordered_rate
    rates = [("measured", run.payout_rate, PAYOUT), ("ordered", ordered, UNCOMPENSATED)]
    motions = [
        ("boom tip", run.boom_tip_heave, BOOM_TIP),
        ("payout", run.payout, PAYOUT),
        ("unit, off", run.uncompensated_heave, UNCOMPENSATED),
        ("unit", run.unit_heave, UNIT),
    ]
    found = [_drawn(one, "Payout rate", "payout rate [m/s]", rates, 1.0)] if ordered.value.any() else []
    if run.boom_tip_heave.size or run.unit_heave.size:
        about = [(name, Signal(of.time, of.value - of.value.mean()) if of.size else of, c) for name, of, c in motions]
        found.append(_drawn(one, "Motions about their means", "motion [cm]", about, CM))
        if run.tension.size:
            found.append(_drawn(one, "Top tension", "tension [kN]", [("tension", run.tension, UNIT)], KN))
    elif run.payout.size and not found:
        found.append(_drawn(one, "Payout", "payout [m]", [("payout", run.payout, PAYOUT)], 1.0))
    return found


def _drawn(
    measured: Measured, title: str, axis: str, traces: Sequence[tuple[str, Signal, str]], scale: float
) -> Figure:
    lines = [line(Signal(of.time, scale * of.value), name, colour) for name, of, colour in traces if of.size]
    shapes = [
        {"type": "line", "x0": at, "x1": at, "yref": "paper", "y0": 0, "y1": 1, "line": {"dash": "dot", "width": 1}}
        for at in (measured.event, measured.stop)
        if math.isfinite(at)
    ]
    layout = {"xaxis": {"title": {"text": "time [s]"}}, "yaxis": {"title": {"text": axis}}, "shapes": shapes}
    caption = "Dotted: the event, and the drum at rest." if shapes else ""
    return Figure(title, caption, lines, layout, height=260, is_over_time=False)


DETAIL = "detail"
"""Column with all that a step gave, as JSON, in its first row."""


@dataclass(frozen=True)
class Parts:
    """What is tested in the place of virtual parts."""

    winch: DeviceMap | None = None  # map of a real winch; None: the virtual one of the scenario
    external: tuple[str, ...] = ()  # real parts in runs, as `external_settings` takes them
    is_on_network: bool = False  # nodes on other hosts may join

    @property
    def are_real(self) -> bool:
        """Whether a real part takes part: it does not do the same twice."""
        return bool(self.winch or self.external)

    @property
    def words(self) -> dict[str, str]:
        """What is tested, by name."""
        winch = f"real, by map {self.winch.name}" if self.winch else "virtual"
        replaced = {"real in runs": ", ".join(self.external)} if self.external else {}
        return {"winch": winch, **replaced}


class Acceptance:
    """An acceptance test, as the engine takes it (`heave_studies.study.engine.Kind`): a job for each step.

    Parameters
    ----------
    head : of the file of the procedure
    parts : what is tested
    settings : changes of the scenario on the command line, PLACE=VALUE each
    scenario : that takes the place of the procedure's; "": none does
    only : names of the steps to be run; empty: all
    folder : that takes what the steps leave

    Attributes
    ----------
    procedure : read and checked, with the steps to be run
    nominal : the winch as it should be
    facts : what identifies the test, by name

    Raises ParameterError, in one line, for what is wrong with the procedure or its scenarios, before anything is run.
    """

    is_local = True
    is_open = False

    def __init__(
        self, head: Head, parts: Parts, settings: Sequence[str], scenario: str, only: Sequence[str], folder: Path
    ) -> None:
        where = str(head.path)
        changes = [*(make_setting(place, value, where) for place, value in head.settings.items()),
                   *map(parse_setting, settings)]  # fmt: skip
        self._scenario = load_scenario(scenario or head.scenario, settings=changes)
        winch = self._scenario.parameters["winch_controller"].winch
        self.nominal = Nominal(winch.speed_limit, winch.acceleration_limit, winch.command_delay + winch.time_constant)
        procedure = read_procedure(head, _limits_of(self._scenario))
        given = {text.partition("=")[0]: parse_setting(text).value for text in settings}
        names = [step.name for step in procedure.steps]
        if wrong := next((name for name in only if name not in names), ""):
            raise ParameterError(f"{where}: ask: step: no such step: {wrong}; steps: {', '.join(names)}")
        self.procedure = replace(
            procedure,
            scenario=scenario or procedure.scenario,
            settings={**procedure.settings, **given},
            steps=tuple(step for step in procedure.steps if not only or step.name in only),
        )
        self._parts, self._folder = parts, folder
        for step in procedure.steps:
            if isinstance(step.test, RunTest):
                refuse_late(step.event, self._loop(step, step.test).run.duration, f"{where}: {step.name}: event")
        self._text = sections_text(stored_sections(self._scenario), title=stored_title(self._scenario))
        self.facts = {**parts.words, **facts_of(self.procedure, self._text)}

    @property
    def name(self) -> str:
        """What its table and page are called."""
        return self.procedure.title

    @property
    def identity(self) -> str:
        """What identifies its results: procedure, scenario, and what was tested."""
        return repr((self.procedure.text, [one.name for one in self.procedure.steps], self._text, self._parts.words))

    @property
    def size(self) -> int:
        """Number of steps."""
        return len(self.procedure.steps)

    def rounds(self, results: Mapping[int, Plain]) -> Iterator[list[Job]]:
        """Yield the steps without `results`, and those with; a real winch is open as long as they run."""
        left = [step for number, step in enumerate(self.procedure.steps, 1) if number not in results]
        with ExitStack() as stack:
            winch = self._real_winch(stack, left)
            yield [
                Job(number, _label(step), partial(self._done, step, winch))
                for number, step in enumerate(self.procedure.steps, 1)
            ]

    def frame(self, results: Mapping[int, Plain]) -> pandas.DataFrame:
        """Return a row for each criterion of each step, from their `results`."""
        rows = []
        for number in sorted(results):
            one = results[number]
            detail = json.dumps(one)
            for title, required, got, verdict in one["cells"] or [["", "", one[FAILURE], NOT_DONE]]:
                rows.append([one["step"], one["state"], title, required, got, verdict, one["part"], detail])
                detail = ""
        columns = ["step", "state", "figure", "required", "reached", "verdict", "against", DETAIL]
        frame = pandas.DataFrame(rows, columns=columns)
        frame.insert(0, CASE, range(1, len(frame) + 1))
        return frame.assign(**{SCENARIO: ""})

    def _real_winch(self, stack: ExitStack, steps: Sequence[Step]) -> WinchPart | None:
        """Open the real winch, where there is one and a step that moves it."""
        needed = any(isinstance(step.test, WinchTest) for step in steps)
        if self._parts.winch is None or not needed:
            return None
        from heave_devices.bench.real_winch import real_winch  # noqa: PLC0415 - starts ROS

        return stack.enter_context(real_winch(self._parts.winch))

    def _done(self, step: Step, winch: WinchPart | None) -> Plain:
        set_up_transport(network=self._parts.is_on_network)
        return self._result(step, self._folder, winch).to_plain()

    def _result(self, step: Step, folder: Path, winch: WinchPart | None) -> StepResult:
        try:
            if isinstance(step.test, WinchTest):
                return self._on_winch(step, step.test, folder, winch)
            return self._in_a_run(step, step.test, folder)
        except (CommandError, BagError) as error:
            if str(error).startswith("interrupted"):
                raise KeyboardInterrupt from None
            if str(error) == ANOTHER_RUN:
                raise
            return StepResult(step, failure=str(error))

    def _on_winch(self, step: Step, test: WinchTest, folder: Path, real: WinchPart | None) -> StepResult:
        part = real or VirtualPart(self._scenario.parameters["virtual_winch"], test.load)
        with ProgressLine() as progress:
            trace = run_winch(part, test, step.event, step.name, progress.show)
        path = folder / f"{step.slug}.csv"
        trace.save(path)
        return _judged(step, of_winch(trace, test, self.nominal), path, "real winch" if real else "virtual winch")

    def _in_a_run(self, step: Step, test: RunTest, folder: Path) -> StepResult:
        run = folder / step.slug
        measured, breaches = run_loop(self._loop(step, test), step.event, run, self._parts.external)
        measured.nominal = self.nominal
        real = ", ".join(self._parts.external)
        return _judged(step, measured, run / "bag", f"run, real: {real}" if real else "run, all virtual", breaches)

    def _loop(self, step: Step, test: RunTest) -> Scenario:
        return scenario_of(self.procedure, test, step.event, self._parts.external)


def _label(step: Step) -> str:
    """Return what a step does, in a line."""
    signal = getattr(step.test, "signal", None)
    does = signal.words if signal else "a run"
    return f"{step.name}: {does}{f'; {step.event.words}' if step.event else ''}"


def _limits_of(scenario: Scenario) -> Limits:
    """Return what the nominal winch of a scenario, and its rope, can do."""
    winch, cable = scenario.parameters["winch_controller"].winch, scenario.parameters["cable_sim"].cable
    stated = strengths(
        {"cable.breaking_force": cable.breaking_force}, {"rated_pull": scenario.parameters["virtual_winch"].rated_pull}
    )
    parting = Strength("", "rope", "tension at which the rope parts", LARGEST_STRAIN * cable.axial_stiffness, LEAST)
    payout = (winch.payout_minimum, winch.payout_maximum)
    return Limits(winch.speed_limit, winch.acceleration_limit, payout, (*stated, parting))


def _judged(step: Step, measured: Measured, path: Path, part: str, breaches: Sequence[str] = ()) -> StepResult:
    """Return the verdict on a step that left what was `measured` in the file or folder `path`."""
    values = {} if measured.lacks else figures.evaluate(measured, step.alarms)
    found = tuple(figures.judged(criterion, values, measured) for criterion in step.wanted)
    return StepResult(step, found, tuple(breaches), "", values, measured, path, digest_of(path), part)
