"""The answer to what an operator requested."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Answer:
    """A definite answer, in one line.

    Attributes
    ----------
    text : what was done, or why it was not
    is_refused : it was not done
    """

    text: str
    is_refused: bool = False


def refusal(text: str) -> Answer:
    """Return the answer that says in `text` why something was not done."""
    return Answer(text, is_refused=True)
