"""Packages that may be missing: what they add to the suite, found by entry point, and how their absence is said."""

from __future__ import annotations

import argparse
from typing import cast

from heave_node.extras import PARTS, extra_of, extra_parts, missing_extra

from heave_bringup.commands.command import CommandModule
from heave_bringup.errors import CommandError

COMMANDS = "heave.commands"
"""Group of entry points whose modules are subcommands (`heave_bringup.commands.command`)."""

EXTRA_OF_MODULE = {
    **dict.fromkeys(("control", "matplotlib"), "design"),
    **dict.fromkeys(("pandas", "pyarrow"), "frames"),
    "xlsxwriter": "xlsx",
}
"""The extra that brings a library which some of the suite's own commands need."""


class AbsentCommand:
    """Stands for the subcommand `name`, whose extra is absent or cannot be loaded for an `error`, and says so."""

    EXAMPLES = ()

    def __init__(self, name: str, error: ModuleNotFoundError | None) -> None:
        self.__name__ = name
        self.SUMMARY = f"Needs heave[{extra_of(COMMANDS, name)}], which is not installed."
        self._error = error

    def add_arguments(self, parser: argparse.ArgumentParser, /) -> None:
        """Let `parser` take any arguments: what is missing is the answer to all."""
        parser.add_argument("arguments", nargs=argparse.REMAINDER, help=argparse.SUPPRESS)

    def execute(self, _: argparse.Namespace, /) -> None:
        """Refuse, whatever the options say; raises CommandError."""
        raise missing(self.__name__, self._error)


def extra_commands() -> tuple[CommandModule, ...]:
    """Return the subcommands that extras bring; one of a missing extra says what it needs."""
    return tuple(extra_command(name) for name in PARTS[COMMANDS])


def extra_command(name: str) -> CommandModule:
    """Return the subcommand `name` of an extra; where the extra is missing, what says so."""
    entry = extra_parts(COMMANDS).get(name)
    try:
        return AbsentCommand(name, None) if entry is None else cast(CommandModule, entry.load())
    except ModuleNotFoundError as error:
        return AbsentCommand(name, error)


def missing(command: str, error: ModuleNotFoundError | None) -> CommandError:
    """Return what to say where a `command` needs a module that is not there; raise `error` where no extra has it."""
    module = "" if error is None else str(error.name).partition(".")[0]
    extra = PARTS[COMMANDS].get(command) or EXTRA_OF_MODULE.get(module)
    if extra is None:
        raise error or KeyError(command)
    return CommandError(str(missing_extra(f"heave {command}", extra, error)))
