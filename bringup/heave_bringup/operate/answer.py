"""The answer to what an operator requested."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Answer:
    """A definite answer, in one line."""

    text: str  # what was done, or why it was not
    is_refused: bool = False  # it was not done


def refusal(text: str) -> Answer:
    """Return the answer that says in `text` why something was not done."""
    return Answer(text, is_refused=True)
