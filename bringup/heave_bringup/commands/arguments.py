"""Arguments that several subcommands have."""

from __future__ import annotations

import argparse
import os
import re
from collections.abc import Callable, Iterable
from pathlib import Path

ASKED = "_ARGCOMPLETE"
"""Set in the environment by the shell while it asks what may stand next."""


def complete(parser: argparse.ArgumentParser) -> None:
    """Answer the shell and end, where it asks; else do nothing, and load nothing, for the command of a `parser`."""
    if ASKED not in os.environ:
        return
    import argcomplete

    argcomplete.autocomplete(parser)


def completed_by(action: argparse.Action, words: Callable[[], Iterable[str]]) -> None:
    """Let the shell complete the argument of an `action` by what `words` returns, which is called only when the shell
    asks.
    """

    def completer(**_: object) -> list[str]:
        return list(words())

    action.completer = completer  # type: ignore[attr-defined]


def add_settings(parser: argparse.ArgumentParser) -> None:
    """Let the user of `parser` change parameters of a scenario."""
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NODE.PARAM=VALUE",
        help="set a parameter of one node; system.PARAM sets it for both plant and controller, all.PARAM for "
        "the run; repeatable",
    )


def _scenarios() -> list[str]:
    from heave_bringup.scenarios import shipped_scenarios

    return [*shipped_scenarios(), *map(str, Path().glob("*.yaml"))]


def add_scenario(parser: argparse.ArgumentParser) -> None:
    """Let the user of `parser` name a scenario and change its parameters."""
    scenario = parser.add_argument("scenario", metavar="SCENARIO", help="a shipped scenario (heave list) or a file")
    completed_by(scenario, _scenarios)
    add_settings(parser)


def add_bags(parser: argparse.ArgumentParser) -> None:
    """Let the user of `parser` name one or several bags."""
    parser.add_argument("bags", metavar="BAG", type=Path, nargs="+", help="bag folder or run folder")
    parser.add_argument(
        "--transient", type=float, metavar="S", help="initial time to exclude from the figures (default: the bag's)"
    )
    parser.add_argument("--scenario", metavar="SCENARIO", help="scenario of the run, for bags that do not contain one")


SAME_SEA = "the efficiency of law industrial in the same sea"
"""The reference beside the efficiency, in the words of the help."""


def add_baseline(parser: argparse.ArgumentParser) -> None:
    """Let the user of `parser` leave out the baseline beside the efficiency."""
    parser.add_argument(
        "--baseline",
        action=argparse.BooleanOptionalAction,
        help=f"also show {SAME_SEA}. The scenario is run again without ROS, once; the result is saved beside the bag "
        "(default: yes)",
    )


def add_full(parser: argparse.ArgumentParser) -> None:
    """Let the user of `parser` see every figure of merit."""
    parser.add_argument("--full", action="store_true", help="print all figures of merit, not only the summary")


def add_network(parser: argparse.ArgumentParser, default: object = False) -> None:
    """Let the user of `parser` open the run to other hosts; `default` where he does not."""
    parser.add_argument(
        "--network",
        action="store_true",
        default=default,
        help="let nodes on other hosts join; by default nothing leaves this machine",
    )


def port_number(text: str) -> int:
    """Return the number of a TCP port that `text` is; raise what argparse understands for another."""
    if not (text.isascii() and text.isdigit() and 1 <= int(text) <= 65535):
        raise argparse.ArgumentTypeError(f"{text}: must be a whole number from 1 to 65535")
    return int(text)


def add_namespace(parser: argparse.ArgumentParser, what: str, default: str | None = None) -> None:
    """Let the user of `parser` name the namespace of a run; `what` it does is its help, `default` holds without it."""
    parser.add_argument("--namespace", type=_namespace, metavar="NAME", default=default, help=what)


def _namespace(text: str) -> str:
    if re.fullmatch(r"/?[A-Za-z][A-Za-z0-9_]*(/[A-Za-z][A-Za-z0-9_]*)*", text) is None:
        raise argparse.ArgumentTypeError(
            f"{text!r} is not a ROS namespace: letters, digits and _, parts separated by /"
        )
    return text
