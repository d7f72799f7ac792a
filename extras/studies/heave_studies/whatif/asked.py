"""What a user asks of a record: laws and changes of the controller or the winch, checked like a scenario."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from cable_sim_node.winch.parameters import WinchParameters
from heave_bringup.scenarios import load_scenario
from heave_node.parameters import ParameterError, flatten
from winch_controller_node.laws.registry import LAWS
from winch_controller_node.node_parameters import WinchControllerParameters

from heave_studies.whatif.twin.replay import Asked

CONTROLLER, WINCH = "winch_controller", "virtual_winch"


@dataclass(frozen=True)
class Wish:
    """What is asked."""

    scenario: Path | str  # of the run, a file or a shipped name
    law: str = ""  # of the first answer; empty: that of the record
    settings: Sequence[str] = ()  # changes, as for `--set`
    compare: Sequence[str] = ()  # further laws


def nominal_of(scenario: Path | str) -> tuple[WinchControllerParameters, Any]:
    """Return the parameters of the controller in a `scenario`, and of the run."""
    found = load_scenario(str(scenario), needs_files=False)
    return found.parameters[CONTROLLER], found.run


def asked_of(wish: Wish, identified: WinchParameters, *, has_adviser: bool) -> list[Asked]:
    """Return what is asked for, the first one first.

    Parameters
    ----------
    wish : of the user
    identified : winch of the record, to which changes of the winch apply
    has_adviser : the controller of the record had one

    Raises ParameterError for a law that there is not, and for a change of what a record fixes: sea, vessel, cable,
    unit and sensors are as they were.
    """
    for law in (*([wish.law] if wish.law else []), *wish.compare):
        if law not in LAWS:
            raise ParameterError(f"{law}: no such law; known: {', '.join(LAWS)}")
    before = load_scenario(str(wish.scenario), needs_files=False)
    after = load_scenario(str(wish.scenario), settings=wish.settings, needs_files=False)
    changed = {node: _changes(before.parameters[node], after.parameters[node]) for node in after.parameters}
    changed["all"] = _changes(before.run, after.run)
    fixed = [f"{node}.{name}" for node, names in changed.items() if node not in (CONTROLLER, WINCH) for name in names]
    if fixed:
        raise ParameterError(
            f"--set: a record has one sea, cable, unit, set of sensors and length; {fixed[0]} cannot be asked, only "
            f"{CONTROLLER}.*, {WINCH}.* and system.winch.*"
        )
    nested = [name for name in changed[WINCH] if "." in name]
    if nested:
        raise ParameterError(f"--set: {WINCH}.{nested[0]} cannot be asked of a record: its winch is a speed servo")
    winch = replace(identified, **changed[WINCH]) if changed[WINCH] else None
    controller: WinchControllerParameters = after.parameters[CONTROLLER]
    laws = [wish.law or controller.law, *(law for law in wish.compare if law != (wish.law or controller.law))]
    return [Asked(law, replace(controller, law=law), winch, has_adviser) for law in dict.fromkeys(laws)]


def _changes(before: Any, after: Any) -> dict[str, Any]:
    """Return what differs, by dotted name, as it is after."""
    old, new = flatten(before), flatten(after)
    return {name: value for name, value in new.items() if old.get(name) != value}
