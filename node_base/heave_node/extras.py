"""Packages that may be missing: how to install them, and what they add to the suite, by entry point."""

from __future__ import annotations

from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any


class MissingExtraError(Exception):
    """An extra that is needed is not installed; the message is one line for the user."""


def how_to_install(extra: str) -> str:
    """Return the command, given in the folder of the suite, that installs the packages of an `extra`.

    >>> how_to_install("dask")
    'in the folder of the suite: .venv/bin/uv pip install -r pyproject.toml --extra dask'
    """
    return f"in the folder of the suite: .venv/bin/uv pip install -r pyproject.toml --extra {extra}"


def missing_extra(what: str, extra: str, error: ModuleNotFoundError | None = None) -> MissingExtraError:
    """Return the error that says which `extra` brings `what`; `error` names a package that it lacks itself."""
    lacks = f" (no module {error.name})" if error is not None else ""
    return MissingExtraError(f"{what} needs heave[{extra}]{lacks}; {how_to_install(extra)}")


@cache
def extra_parts(group: str) -> dict[str, EntryPoint]:
    """Return the entry points of a `group`, as `heave.commands`, by name: what the installed extras bring."""
    return {entry.name: entry for entry in entry_points(group=group)}


def load_part(group: str, name: str, what: str, extra: str) -> Any:
    """Return what an extra brings.

    Parameters
    ----------
    group, name : of its entry point
    what : it is for the user; opens the message
    extra : that brings it

    Raises MissingExtraError where the extra, or a package of its own, is not installed.
    """
    entry = extra_parts(group).get(name)
    if entry is None:
        raise missing_extra(what, extra)
    try:
        return entry.load()
    except ModuleNotFoundError as error:
        raise missing_extra(what, extra, error) from error
