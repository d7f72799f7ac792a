"""The declaration of a subcommand of `heave`."""

from __future__ import annotations

import argparse
from typing import Protocol

DEFAULT_MODEL = "unit_1500"


class CommandModule(Protocol):
    """The module of a subcommand, which has its name, up to a `_`: no module can be called `import`."""

    __name__: str

    @property
    def SUMMARY(self) -> str:
        """What it does, in one sentence."""

    @property
    def EXAMPLES(self) -> tuple[str, ...]:
        """Command lines that a user may try."""

    def add_arguments(self, parser: argparse.ArgumentParser, /) -> None:
        """Add its own arguments to its `parser`; those that every command has are there already."""

    def execute(self, options: argparse.Namespace, /) -> None:
        """Do it, as `options` say.

        Raises CommandError, ParameterError or BagError, in one line, where it cannot, and VerdictError where it gives a
        verdict that is FAILED.
        """


def name_of(command: CommandModule) -> str:
    """Return the name of a `command` on the command line."""
    return command.__name__.rpartition(".")[2].partition("_")[0]


def add_model(parser: argparse.ArgumentParser, words: str) -> None:
    """Add to a `parser` the option that names the scenario which a new one begins with; its help in `words`."""
    parser.add_argument("--like", metavar="SCENARIO", default=DEFAULT_MODEL, help=f"{words} (default: {DEFAULT_MODEL})")
