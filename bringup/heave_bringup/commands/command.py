"""The declaration of a subcommand of `heave`."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Protocol

DEFAULT_MODEL = "b3_deep_900"


class CommandModule(Protocol):
    """The module of a subcommand. The command has its name, up to a `_`: no module can be called `import`."""

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


@dataclass(frozen=True)
class Command:
    """A subcommand.

    Attributes
    ----------
    name : as given on the command line
    summary, examples, execute, add_arguments : as its module has them
    """

    name: str
    summary: str
    examples: tuple[str, ...]
    execute: Callable[[argparse.Namespace], None]
    add_arguments: Callable[[argparse.ArgumentParser], None]


def commands_of(*modules: CommandModule) -> Iterator[Command]:
    """Return the subcommands that `modules` declare."""
    for module in modules:
        name = module.__name__.rpartition(".")[2].partition("_")[0]
        yield Command(name, module.SUMMARY, module.EXAMPLES, module.execute, module.add_arguments)


def add_model(parser: argparse.ArgumentParser, words: str) -> None:
    """Add to a `parser` the option that names the scenario which a new one begins with; its help in `words`."""
    parser.add_argument("--like", metavar="SCENARIO", default=DEFAULT_MODEL, help=f"{words} (default: {DEFAULT_MODEL})")
