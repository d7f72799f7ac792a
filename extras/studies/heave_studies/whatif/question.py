"""From a bag and a question to the answers: laws and changes of controller or winch, checked like a scenario."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from cable_sim_node.errors import PlantError
from cable_sim_node.winch.parameters import WinchParameters
from heave_bags.mcap.reader import Bag
from heave_bringup.errors import CommandError
from heave_bringup.output import warn
from heave_bringup.scenarios import load_scenario
from heave_node.parameters import ParameterError, flatten
from winch_controller_node.beliefs.beliefs import Beliefs
from winch_controller_node.laws.registry import LAWS
from winch_controller_node.model.lqr import DesignError
from winch_controller_node.node_parameters import WinchControllerParameters

from heave_studies.study.workers import Job, workers
from heave_studies.whatif.answer import answers, drawn, learn, recorded
from heave_studies.whatif.fitness import Result, check_known, check_record
from heave_studies.whatif.record import read_record, stored_scenario
from heave_studies.whatif.twin import Asked, winch_under

CONTROLLER, WINCH = "winch_controller", "virtual_winch"
DRAWS, SEED = 6, 1
"""Plants over which each loop is closed again for the bands, and seed of these."""


@dataclass(frozen=True)
class Question:
    """What is asked of a record."""

    laws: Sequence[str] = ()  # that are asked for; none: that of the record
    settings: Sequence[str] = ()  # changes, as for `--set`
    scenario: Path | str = ""  # of the run, a file or a shipped name; empty: the one in the bag
    transient: float | None = None  # initial time that is left out [s]; None: the scenario's
    end: float | None = None  # time at which the record is cut off [s]; None: it is not

    def __post_init__(self) -> None:
        """Raise ParameterError for what says nothing."""
        for name in ("transient", "end"):
            value = getattr(self, name)
            if value is not None and not value >= 0:
                raise ParameterError(f"--{name} {value:g}: must be 0 or more")
        for law in self.laws:
            if law not in LAWS:
                raise ParameterError(f"{law}: no such law; known: {', '.join(LAWS)}")


Show = Callable[[str, float], None]
"""Shows what is done, in words, and its share."""


def ask(source: Path, question: Question, *, show: Show) -> Result:
    """Return what a record answers to a question.

    Parameters
    ----------
    source : the bag's folder
    question : what is asked
    show : called with what is done, and its share

    Raises CommandError where the record cannot carry an answer, ParameterError for what cannot be asked.
    """
    bag = Bag(source)
    try:
        with stored_scenario(bag, question.scenario) as scenario:
            return _answered(bag, scenario, question, show)
    except (DesignError, PlantError) as error:
        raise CommandError(f"{source}: {error}") from error


def _answered(bag: Bag, scenario: Path | str, question: Question, show: Show) -> Result:
    """Return what a `bag`, of a run of a `scenario`, answers to a `question`."""
    before = load_scenario(str(scenario), needs_files=False)
    nominal = before.parameters[CONTROLLER]
    asked_of(question, scenario, winch_under(Beliefs(-1), nominal), has_adviser=True)
    record = read_record(bag, nominal, progress=lambda share: show("reading", share))
    notes = [*bag.notes, *map(str, bag.losses)]
    warn(notes)
    record = record if question.end is None else record.part(question.end)
    start = before.run.transient if question.transient is None else question.transient
    check_record(record, start, str(bag.path))
    show("the same law again, cable and unit", 0.0)
    known = learn(record, nominal, start=start)
    check_known(known, str(bag.path))
    others = [drawn(known, SEED, number) for number in range(DRAWS)]
    wanted = asked_of(question, scenario, known.past.winch_parameters, has_adviser=record.has_adviser)
    with workers() as run:

        def shown(jobs: Sequence[Job]) -> Iterator[tuple[Job, Any]]:
            for number, pair in enumerate(run(jobs)):
                show(f"closing loops: {pair[0].label}", (number + 1) / len(jobs))
                yield pair

        found = answers(known, wanted, others, run=shown)
    return Result(question.settings, notes, known, recorded(known), found)


def asked_of(
    question: Question, scenario: Path | str, identified: WinchParameters, *, has_adviser: bool
) -> list[Asked]:
    """Return what is asked for.

    Parameters
    ----------
    question : of the user
    scenario : of the run, a file or a shipped name
    identified : winch of the record, to which changes of the winch apply
    has_adviser : the controller of the record had one

    Raises ParameterError for a change of what a record fixes: sea, vessel, cable, unit and sensors are as they were.
    """
    before = load_scenario(str(scenario), needs_files=False)
    after = load_scenario(str(scenario), settings=question.settings, needs_files=False)
    changed = {node: _changes(before.parameters[node], after.parameters[node]) for node in after.parameters}
    changed["all"] = _changes(before.run, after.run)
    fixed = [f"{node}.{name}" for node, names in changed.items() if node not in (CONTROLLER, WINCH) for name in names]
    fixed += [f"{WINCH}.{name}" for name in changed[WINCH] if "." in name]
    if fixed:
        raise ParameterError(
            f"--set: a record has one sea, cable, unit, set of sensors, drive and length; {fixed[0]} cannot be asked, "
            f"only {CONTROLLER}.*, {WINCH}.* of a speed servo, and system.winch.*"
        )
    winch = replace(identified, **changed[WINCH]) if changed[WINCH] else None
    controller: WinchControllerParameters = after.parameters[CONTROLLER]
    laws = dict.fromkeys(question.laws or (controller.law,))
    return [Asked(law, replace(controller, law=law), winch, has_adviser) for law in laws]


def _changes(before: Any, after: Any) -> dict[str, Any]:
    """Return what differs, by dotted name, as it is after."""
    old, new = flatten(before), flatten(after)
    return {name: value for name, value in new.items() if old.get(name) != value}
