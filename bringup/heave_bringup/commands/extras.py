"""Packages that may be missing: what they add to the suite, found by entry point, and how their absence is said."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from functools import cache
from importlib.metadata import EntryPoint, entry_points

from heave_node.extras import how_to_install

from heave_bringup.commands.command import CommandModule
from heave_bringup.errors import CommandError

COMMANDS = "heave.commands"
"""Group of entry points whose modules are subcommands (`heave_bringup.commands.command`)."""

EXTRA_OF = {
    **dict.fromkeys(("adapt", "import"), "devices"),
    **dict.fromkeys(
        ("accept", "campaign", "extremes", "falsify", "identify", "lift", "operability", "sizing", "whatif"), "studies"
    ),
    "static": "statics",
    **dict.fromkeys(("panel", "view"), "panel"),
    "fmu": "fmu",
}
"""The extra that brings each subcommand, so that one that is not installed can be named."""


class ExtraCommand:
    """A subcommand of an extra, or what stands for it where the extra is missing.

    Parameters
    ----------
    name : of the subcommand
    summary, examples, add_arguments : as of `CommandModule`
    execute : its function
    """

    def __init__(
        self,
        name: str,
        summary: str,
        examples: tuple[str, ...],
        add_arguments: Callable[[argparse.ArgumentParser], None],
        execute: Callable[[argparse.Namespace], None],
    ) -> None:
        self.__name__ = name
        self.SUMMARY = summary
        self.EXAMPLES = examples
        self._add_arguments = add_arguments
        self._execute = execute

    def add_arguments(self, parser: argparse.ArgumentParser, /) -> None:
        """Add its own arguments to its `parser`."""
        self._add_arguments(parser)

    def execute(self, options: argparse.Namespace, /) -> None:
        """Do it, as `options` say; raises CommandError where a package of the extra is missing."""
        try:
            self._execute(options)
        except ModuleNotFoundError as error:
            raise _missing(self.__name__, error) from error


def extra_commands() -> tuple[CommandModule, ...]:
    """Return the subcommands that extras bring, those of missing extras too: these say what they need."""
    return tuple(extra_command(name) for name in EXTRA_OF)


def extra_command(name: str) -> CommandModule:
    """Return the subcommand `name` of an extra; where the extra is missing, what says so."""
    entry = _found().get(name)
    error: ModuleNotFoundError | None = None
    try:
        module = None if entry is None else entry.load()
    except ModuleNotFoundError as missing:
        module, error = None, missing
    if module is None:
        return _absent(name, error)
    return ExtraCommand(name, module.SUMMARY, module.EXAMPLES, module.add_arguments, module.execute)


@cache
def _found() -> dict[str, EntryPoint]:
    return {entry.name: entry for entry in entry_points(group=COMMANDS)}


def _absent(name: str, error: ModuleNotFoundError | None) -> CommandModule:
    def add_arguments(parser: argparse.ArgumentParser, /) -> None:
        parser.add_argument("arguments", nargs=argparse.REMAINDER, help=argparse.SUPPRESS)

    def refuse(_: argparse.Namespace, /) -> None:
        raise _missing(name, error)

    return ExtraCommand(name, f"Needs heave[{EXTRA_OF[name]}], which is not installed.", (), add_arguments, refuse)


def _missing(name: str, error: ModuleNotFoundError | None) -> CommandError:
    extra = EXTRA_OF[name]
    found = f" (no module {error.name})" if error is not None else ""
    return CommandError(f"heave {name} needs heave[{extra}]{found}; {how_to_install(extra)}")
