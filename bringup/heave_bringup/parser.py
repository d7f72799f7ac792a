"""The command line of `heave`: its subcommands, each with its arguments, help and example."""

from __future__ import annotations

import argparse
import difflib
import sys
from collections.abc import Sequence
from importlib import metadata
from typing import Any, NoReturn

from heave_node.extras import PARTS

from heave_bringup.commands.bags import export, kpi, record, repair, replay, report
from heave_bringup.commands.command import CommandModule, name_of
from heave_bringup.commands.extras import COMMANDS as EXTRA_COMMANDS
from heave_bringup.commands.extras import extra_command, extra_commands
from heave_bringup.commands.models import design, modes
from heave_bringup.commands.runs import check, operate, run
from heave_bringup.commands.scenarios import list_scenarios, new, params
from heave_bringup.errors import ExitStatus

DISTRIBUTIONS = ("heave", "heave-bringup")
"""Under which this project is installed: as a whole from wheels, or package by package by colcon."""


class VersionAction(argparse.Action):
    """Prints the version and, where it is known, the git commit; both are looked for only then. `option_strings` and
    `dest` are as argparse gives them.
    """

    def __init__(self, option_strings: list[str], dest: str) -> None:
        super().__init__(option_strings, dest, nargs=0, help="print the version, and the git commit where it is known")

    def __call__(self, *_: object) -> NoReturn:
        """Print, and end."""
        from heave_bags.record.provenance import git_commit  # noqa: PLC0415 - seldom needed

        commit = git_commit()
        sys.stdout.write(f"heave {own_version()}{f' ({commit})' if commit else ''}\n")
        sys.exit(0)


def own_version() -> str:
    """Return the version of this project; "of unknown version" where it is not installed."""
    found = (one.version for name in DISTRIBUTIONS for one in metadata.distributions(name=name))
    return next(found, "of unknown version")


COMMANDS: tuple[CommandModule, ...] = (
    *(run, operate, check),
    *(list_scenarios, new, params),
    *(report, kpi, export, record, replay, repair),
    *(design, modes),
)
"""The suite's own subcommands, in the order of the help; those of extras follow (`heave_bringup.commands.extras`)."""


_NUMBERS = {float: "a number", int: "a whole number"}
_UNITS = {"S": " of seconds", "M": " of metres", "H": " of hours", "DEG": " of degrees"}
"""What a number is of, by the name of an option's value in its help."""


class OneLineParser(argparse.ArgumentParser):
    """Complains in one line, each subcommand of its own arguments."""

    def parse_known_args(self, args: Sequence[str] | None = None, namespace: Any = None) -> tuple[Any, list[str]]:  # type: ignore[override]
        """Parse `args` into a `namespace` as the base class does, but refuse what is not known here: the subcommand's
        help is the one to read.
        """
        options, unknown = super().parse_known_args(args, namespace)
        if unknown:
            self.error(self._refusal(unknown))
        return options, unknown

    def _refusal(self, unknown: list[str]) -> str:
        known = {option.lstrip("-"): option for action in self._actions for option in action.option_strings}
        near = difflib.get_close_matches(unknown[0].partition("=")[0].lstrip("-"), known, n=1)
        hint = f"; did you mean {known[near[0]]}?" if near else ""
        return f"unrecognized arguments: {' '.join(unknown)}{hint}"

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Refuse what is no choice, and name the one that is near: the list of all commands is in the help."""
        if action.choices is not None and value not in action.choices:
            near = difflib.get_close_matches(str(value), list(map(str, action.choices)), n=1)
            if near:
                raise argparse.ArgumentError(action, f"invalid choice: {value!r}; did you mean {near[0]}?")
        super()._check_value(action, value)

    def _get_value(self, action: argparse.Action, arg_string: str) -> Any:
        """Refuse what is no number in the user's words, not in Python's."""
        try:
            return super()._get_value(action, arg_string)
        except argparse.ArgumentError as error:
            if action.type not in _NUMBERS:
                raise
            unit = _UNITS.get(str(action.metavar), "")
            raise argparse.ArgumentError(action, f"must be {_NUMBERS[action.type]}{unit}: {arg_string!r}") from error

    def error(self, message: str) -> NoReturn:
        """Say in `message` what is wrong, and where help is; exit as refused."""
        self.exit(ExitStatus.REFUSED, f"{self.prog}: {message}; see {self.prog} --help\n")


def make_parser(words: Sequence[str] = ()) -> argparse.ArgumentParser:
    """Return the parser of the whole command; the chosen subcommand's function is in `execute`.

    Of a command line in `words` the other subcommands than its own are left without their arguments, which take 15 ms;
    without words all have theirs.
    """
    parser = OneLineParser(
        prog="heave",
        description="Active heave compensation: run scenarios over ROS 2, record, replay, analyse, design.",
        epilog="\n".join(
            [
                "example: heave run b2_calm_300 --duration 600",
                "exit status:",
                *(f"  {status.value:<4} {status.meaning}" for status in ExitStatus),
            ]
        ),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action=VersionAction)
    subparsers = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for command in _commands(words[:1]):
        subparser = subparsers.add_parser(
            name_of(command),
            help=command.SUMMARY[0].lower() + command.SUMMARY[1:].rstrip("."),
            description=command.SUMMARY,
            epilog="\n".join(f"example: {example}" for example in command.EXAMPLES),
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        subparser.set_defaults(execute=command.execute)
        subparser.add_argument(
            "--json",
            metavar="FILE",
            help="write the result as JSON to FILE; with -, standard output holds nothing else",
        )
        if name_of(command) in words[:1] or not _is_known(words[:1]):
            command.add_arguments(subparser)
    return parser


def all_commands() -> tuple[CommandModule, ...]:
    """Return all subcommands, in the order of the help."""
    return (*COMMANDS, *extra_commands())


def _is_known(words: Sequence[str]) -> bool:
    known = {*map(name_of, COMMANDS), *PARTS[EXTRA_COMMANDS]}
    return any(word in known for word in words)


def _commands(words: Sequence[str]) -> tuple[CommandModule, ...]:
    """Return the subcommands that a line beginning with `words` may mean; extras are looked for only if needed."""
    if any(name_of(command) in words for command in COMMANDS):
        return COMMANDS
    return (*COMMANDS, *map(extra_command, words)) if _is_known(words) else all_commands()
