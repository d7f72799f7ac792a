"""The declaration of a subcommand of `heave`."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass

DEFAULT_MODEL = "b3_deep_900"


@dataclass(frozen=True)
class Command:
    """A subcommand.

    Attributes
    ----------
    name : as given on the command line
    summary : what it does, in one sentence
    examples : command lines that a user may try
    execute : does it; raises CommandError, ParameterError or BagError, in one line, where it cannot, and VerdictError
        where it gives a verdict that is FAILED
    add_arguments : adds its own arguments to its parser; those that every command has are there already
    """

    name: str
    summary: str
    examples: tuple[str, ...]
    execute: Callable[[argparse.Namespace], None]
    add_arguments: Callable[[argparse.ArgumentParser], object] = lambda parser: None  # noqa: ARG005


def add_model(parser: argparse.ArgumentParser, words: str) -> None:
    """Add to a `parser` the option that names the scenario which a new one begins with; its help in `words`."""
    parser.add_argument("--like", metavar="SCENARIO", default=DEFAULT_MODEL, help=f"{words} (default: {DEFAULT_MODEL})")
