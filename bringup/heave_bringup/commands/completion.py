"""Completion in the user's shell, by argcomplete: `eval "$(register-python-argcomplete heave)"`."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Iterable

ASKED = "_ARGCOMPLETE"
"""Set in the environment by the shell while it asks what may stand next."""


def complete(parser: argparse.ArgumentParser) -> None:
    """Answer the shell and end, where it asks; else do nothing, and load nothing, for the command of a `parser`."""
    if ASKED not in os.environ:
        return
    import argcomplete

    argcomplete.autocomplete(parser)


def completed_by(action: argparse.Action, words: Callable[[], Iterable[str]]) -> None:
    """Let the shell complete an argument.

    Parameters
    ----------
    action : of the parser, that takes the argument
    words : returns what may stand there; called only when the shell asks
    """

    def completer(**_: object) -> list[str]:
        return list(words())

    action.completer = completer  # type: ignore[attr-defined]
