"""What a YAML file of the user is, by its keys: a scenario given to the command for lift plans is named as one."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from heave_node.parameters import ParameterError

PARAMETERS_KEY = "ros__parameters"

KINDS: Mapping[str, tuple[str, str]] = {
    PARAMETERS_KEY: ("a scenario", "heave run"),
    "phases": ("a lift plan", "heave study"),
    "steps": ("a test procedure", "heave study"),
    "vary": ("a study", "heave study"),
    "draw": ("a study", "heave study"),
    "source": ("the map of a device", "heave adapt"),
}
"""By a key that files of one kind alone have: the kind, and the command for it."""


def refuse_other_kind(content: Mapping[str, Any], known: Iterable[str], where: str) -> None:
    """Refuse a file of another kind, and name the command for it.

    Parameters
    ----------
    content : of the file
    known : keys of the kind that is expected
    where : opens the message: the file

    Raises ParameterError.
    """
    holds_parameters = any(isinstance(part, Mapping) and PARAMETERS_KEY in part for part in content.values())
    keys = {*content, PARAMETERS_KEY} if holds_parameters else {*content}
    for key, (kind, command) in KINDS.items():
        if key in keys and key not in known:
            may_vary = key == PARAMETERS_KEY and "vary" in known
            of_many = f", or heave study {where} --vary NODE.PARAM=V,V" if may_vary else ""
            raise ParameterError(f"{where}: this is {kind}; use {command} {where}{of_many}")
