"""A procedure from its first step to its last: each is run, or judged on a record, and kept in a folder."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path

from heave_bags.errors import BagError
from heave_bringup.errors import CommandError
from heave_bringup.progress import ProgressLine
from heave_bringup.run.one_run import ANOTHER_RUN
from heave_bringup.scenarios import Scenario, load_scenario
from heave_bringup.settings import make_setting, parse_setting
from heave_bringup.stored_scenario import stored_sections, stored_title
from heave_devices.maps.device_map import DeviceMap
from heave_node.loads.strength import LEAST, Strength, strengths
from heave_node.numerics.constants import LARGEST_STRAIN
from heave_node.parameters import ParameterError
from heave_node.scenario import sections_text

from heave_studies.accept import figures
from heave_studies.accept.limits import Limits
from heave_studies.accept.measured import Measured, Nominal
from heave_studies.accept.parts.record import ForeignRecord
from heave_studies.accept.parts.run import run_loop, scenario_of
from heave_studies.accept.parts.winch import VirtualPart, WinchPart, run_winch
from heave_studies.accept.procedure import RunTest, Step, WinchTest
from heave_studies.accept.procedure_file import Head, read_procedure, refuse_late
from heave_studies.accept.results import Acceptance, StepResult, digest_of, facts_of

WHOLE = ""
"""Name of the record that is judged by every step that has none of its own."""


@dataclass(frozen=True)
class Parts:
    """What is tested in the place of virtual parts."""

    winch: DeviceMap | None = None  # map of a real winch; None: the virtual one of the scenario
    external: tuple[str, ...] = ()  # real parts in runs, as `external_settings` takes them
    # by name of the step, or WHOLE; where there is one nothing is run
    records: Mapping[str, Path] = field(default_factory=dict)
    mapping: Path | None = None  # of the records; None: they are the suite's own

    @property
    def words(self) -> dict[str, str]:
        """What is tested, by name."""
        winch = f"real, by map {self.winch.name}" if self.winch else "virtual"
        replaced = {"real in runs": ", ".join(self.external)} if self.external else {}
        if self.records:
            return {
                f"record {name}".strip(): f"{path}, SHA-256 {digest_of(path)}" for name, path in self.records.items()
            }
        return {"winch": winch, **replaced}


class Session:
    """Runs a procedure.

    Parameters
    ----------
    head : of its file
    parts : what is tested
    settings : changes of the scenario on the command line, PLACE=VALUE each
    scenario : that takes the place of the procedure's; "": none does

    Attributes
    ----------
    procedure : read and checked
    nominal : the winch as it should be

    Raises ParameterError, in one line, for what is wrong with the procedure, its scenarios or the records and their
    map, before anything is run.
    """

    def __init__(self, head: Head, parts: Parts, settings: Sequence[str] = (), scenario: str = "") -> None:
        where = str(head.path)
        changes = [*(make_setting(place, value, where) for place, value in head.settings.items()),
                   *map(parse_setting, settings)]  # fmt: skip
        self._scenario = load_scenario(scenario or head.scenario, settings=changes)
        winch = self._scenario.parameters["winch_controller"].winch
        self.nominal = Nominal(winch.speed_limit, winch.acceleration_limit, winch.command_delay + winch.time_constant)
        procedure = read_procedure(head, _limits_of(self._scenario))
        given = {text.partition("=")[0]: parse_setting(text).value for text in settings}
        self.procedure = replace(
            procedure, scenario=scenario or procedure.scenario, settings={**procedure.settings, **given}
        )
        self._parts = parts
        names = {step.name for step in procedure.steps}
        unknown = next((name for name in parts.records if name not in (WHOLE, *names)), None)
        if unknown is not None:
            raise ParameterError(f"--record {unknown}=...: no such step; steps: {', '.join(sorted(names))}")
        try:
            self._records = {name: ForeignRecord(path, parts.mapping) for name, path in parts.records.items()}
        except BagError as error:
            raise ParameterError(str(error)) from error
        for step in procedure.steps:
            if isinstance(step.test, RunTest) and not parts.records:
                refuse_late(step.event, self._loop(step, step.test).run.duration, f"{where}: {step.name}: event")

    def run(self, folder: Path, only: Sequence[str] = ()) -> Acceptance:
        """Run the steps, and return what became of them.

        Parameters
        ----------
        folder : that takes what they leave
        only : names of steps; empty: all

        Ctrl-C ends it: the steps that were not run are then not done.
        """
        began, results = time.time(), []
        (folder / self.procedure.path.name).write_bytes(self.procedure.text)
        steps = [step for step in self.procedure.steps if not only or step.name in only]
        is_ended = False
        with ExitStack() as stack:
            winch = self._real_winch(stack, steps)
            for step in steps:
                if not is_ended:
                    try:
                        results.append(self._result(step, folder, winch))
                        continue
                    except KeyboardInterrupt:
                        is_ended = True
                results.append(StepResult(step, failure="interrupted"))
        text = sections_text(stored_sections(self._scenario), title=stored_title(self._scenario))
        return Acceptance(self.procedure, results, self._parts.words, began, facts_of(self.procedure, text, began))

    def _real_winch(self, stack: ExitStack, steps: Sequence[Step]) -> WinchPart | None:
        """Open the real winch, where there is one and a step that moves it."""
        needed = any(isinstance(step.test, WinchTest) for step in steps)
        if self._parts.winch is None or not needed or self._parts.records:
            return None
        from heave_studies.accept.parts.real_winch import real_winch  # noqa: PLC0415 - starts ROS

        return stack.enter_context(real_winch(self._parts.winch))

    def _result(self, step: Step, folder: Path, winch: WinchPart | None) -> StepResult:
        try:
            if self._parts.records:
                return self._on_record(step)
            if isinstance(step.test, WinchTest):
                return self._on_winch(step, step.test, folder, winch)
            if isinstance(step.test, RunTest):
                return self._in_a_run(step, step.test, folder)
            return StepResult(step, failure="it can be judged on a record alone: --record FILE")
        except (CommandError, BagError) as error:
            if str(error).startswith("interrupted"):
                raise KeyboardInterrupt from None
            if str(error) == ANOTHER_RUN:
                raise
            return StepResult(step, failure=str(error))

    def _on_record(self, step: Step) -> StepResult:
        name = step.name if step.name in self._records else WHOLE
        if name not in self._records:
            return StepResult(step, failure="there is no record of it")
        return _judged(step, self._records[name].measured(step, self.nominal), self._parts.records[name], "record")

    def _on_winch(self, step: Step, test: WinchTest, folder: Path, real: WinchPart | None) -> StepResult:
        part = real or VirtualPart(self._scenario.parameters["virtual_winch"], test.load)
        with ProgressLine() as progress:
            trace = run_winch(part, test, step.event, step.name, progress.show)
        path = folder / f"{step.slug}.csv"
        trace.save(path)
        return _judged(step, trace.measured(test, self.nominal), path, "real winch" if real else "virtual winch")

    def _in_a_run(self, step: Step, test: RunTest, folder: Path) -> StepResult:
        run = folder / step.slug
        done = run_loop(self._loop(step, test), step.event, run, self._parts.external)
        done.measured.nominal = self.nominal
        real = ", ".join(self._parts.external)
        return _judged(
            step, done.measured, run / "bag", f"run, real: {real}" if real else "run, all virtual", done.breaches
        )

    def _loop(self, step: Step, test: RunTest) -> Scenario:
        return scenario_of(self.procedure, test, step.event, self._parts.external)


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
