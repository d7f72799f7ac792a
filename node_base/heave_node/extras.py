"""Packages that may be missing: how to install them, and what they add to the suite, by entry point."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any

PARTS: Mapping[str, Mapping[str, str]] = {
    "heave.commands": {
        **dict.fromkeys(("adapt", "import"), "devices"),
        **dict.fromkeys(("study", "identify", "whatif", "qualify"), "studies"),
        "static": "statics",
        **dict.fromkeys(("panel", "view"), "panel"),
        "fmu": "fmu",
    },
    "heave.record_extras": {"kappa": "studies", "baseline": "studies"},
    "heave.drives": dict.fromkeys(("electric", "pump_controlled", "valve_controlled"), "drives"),
    "heave.motion_sources": {"crane": "devices"},
    "heave.replacements": {"fmu": "fmu"},
}
"""The extra of the suite that brings each part of a group of entry points, so that one that is missing can be named."""


class MissingExtraError(Exception):
    """An extra that is needed is not installed; the message is one line for the user."""


def how_to_install(extra: str) -> str:
    """Return the command, given in the folder of the suite, that installs the packages of an `extra`.

    >>> how_to_install("studies")
    'in the folder of the suite: make extras (most), or .venv/bin/uv pip install -r pyproject.toml --extra studies'
    """
    of_one = f".venv/bin/uv pip install -r pyproject.toml --extra {extra}"
    return f"in the folder of the suite: make extras (most), or {of_one}"


def missing_extra(what: str, extra: str, error: ModuleNotFoundError | None = None) -> MissingExtraError:
    """Return the error that says which `extra` brings `what`; `error` names a package that it lacks itself."""
    lacks = f" (no module {error.name})" if error is not None else ""
    return MissingExtraError(f"{what} needs heave[{extra}]{lacks}; {how_to_install(extra)}")


@cache
def extra_parts(group: str) -> dict[str, EntryPoint]:
    """Return the entry points of a `group`, as `heave.commands`, by name: what the installed extras bring."""
    return {entry.name: entry for entry in entry_points(group=group)}


def known_parts(group: str) -> tuple[str, ...]:
    """Return the names of the parts of a `group`: the suite's own, then those of others that are installed."""
    return tuple(dict.fromkeys((*PARTS[group], *extra_parts(group))))


def extra_of(group: str, name: str) -> str:
    """Return the extra that brings the part `name` of a `group`."""
    return PARTS[group].get(name, name)


def load_part(group: str, name: str, what: str) -> Any:
    """Return what an extra brings.

    Parameters
    ----------
    group, name : of its entry point
    what : it is for the user; opens the message

    Raises MissingExtraError where the extra, or a package of its own, is not installed.
    """
    entry, extra = extra_parts(group).get(name), extra_of(group, name)
    if entry is None:
        raise missing_extra(what, extra)
    try:
        return entry.load()
    except ModuleNotFoundError as error:
        raise missing_extra(what, extra, error) from error
