"""From a bag and a question to the answers: laws and changes of controller or winch, checked like a scenario."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from cable_sim_node.errors import PlantError
from cable_sim_node.winch.parameters import WinchParameters
from heave_bags.mcap.loss import remarks
from heave_bags.mcap.reader import Bag
from heave_bringup.errors import CommandError
from heave_bringup.output import warn
from heave_bringup.scenarios import Scenario
from heave_node.parameters import ParameterError, flatten
from winch_controller_node.laws.registry import LAWS
from winch_controller_node.model.lqr import DesignError
from winch_controller_node.node_parameters import WinchControllerParameters

from heave_studies.kappa import stored_scenario
from heave_studies.study.workers import Job, workers
from heave_studies.whatif.answer import answers, drawn, learn, recorded
from heave_studies.whatif.fitness import Result, check_known, check_record
from heave_studies.whatif.record import NOMINAL, read_record
from heave_studies.whatif.twin import Asked, winch_under

CONTROLLER, WINCH = "winch_controller", "virtual_winch"
DRAWS, SEED = 6, 1
"""Plants over which each loop is closed again for the bands, and seed of these."""


def ask(
    source: Path, laws: Sequence[str], settings: Sequence[str], end: float | None, *, show: Callable[[str, float], None]
) -> Result:
    """Return what a record answers to a question.

    Parameters
    ----------
    source : the bag's folder
    laws : that are asked for; none: that of the record
    settings : changes, as for `--set`
    end : time at which the record is cut off [s]; None: it is not
    show : called with what is done, and its share

    Raises CommandError where the record cannot carry an answer, ParameterError for what cannot be asked.
    """
    bag = Bag(source)
    before, after = stored_scenario(bag), stored_scenario(bag, settings)
    nominal = before.parameters[CONTROLLER]
    try:
        asked_of(before, after, laws, winch_under(NOMINAL, nominal), has_adviser=True)
        record = read_record(bag, nominal, progress=lambda share: show("reading", share))
        warn(remarks(bag.notes, bag.losses))
        record = record if end is None else record.part(end)
        check_record(record, before.run.transient, str(source))
        show("the same law again, cable and unit", 0.0)
        known = learn(record, nominal, start=before.run.transient)
        check_known(known, str(source))
        others = [drawn(known, SEED, number) for number in range(DRAWS)]
        wanted = asked_of(before, after, laws, known.past.winch_parameters, has_adviser=record.has_adviser)
        with workers() as run:

            def shown(jobs: Sequence[Job]) -> Iterator[tuple[Job, Any]]:
                for number, pair in enumerate(run(jobs)):
                    show(f"closing loops: {pair[0].label}", (number + 1) / len(jobs))
                    yield pair

            found = answers(known, wanted, others, run=shown)
    except (DesignError, PlantError) as error:
        raise CommandError(f"{source}: {error}") from error
    return Result(settings, known, recorded(known), found)


def asked_of(
    before: Scenario, after: Scenario, laws: Sequence[str], identified: WinchParameters, *, has_adviser: bool
) -> list[Asked]:
    """Return what is asked for.

    Parameters
    ----------
    before, after : scenario of the run, and with what is changed in it
    laws : that are asked for; none: that of the scenario
    identified : winch of the record, to which changes of the winch apply
    has_adviser : the controller of the record had one

    Raises ParameterError for a change of what a record fixes: sea, vessel, cable, unit and sensors are as they were.
    """
    if wrong := next((law for law in laws if law not in LAWS), ""):
        raise ParameterError(f"{wrong}: no such law; known: {', '.join(LAWS)}")
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
    return [Asked(replace(controller, law=law), winch, has_adviser) for law in dict.fromkeys(laws or (controller.law,))]


def _changes(before: Any, after: Any) -> dict[str, Any]:
    """Return what differs, by dotted name, as it is after."""
    old, new = flatten(before), flatten(after)
    return {name: value for name, value in new.items() if old.get(name) != value}
