"""The questions of a recorded run put to an adviser again, and its answers held against those of the run."""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from winch_controller_node.advice.answering import Answering, MakeAdviser


@dataclass(frozen=True)
class Comparison:
    """Answers beside those that were recorded.

    Attributes
    ----------
    equal : answers with the same bytes
    different : last ticks of the batches whose answers differ
    unrecorded : batches without a recorded answer
    unasked : recorded answers to batches that are not there
    """

    equal: int
    different: tuple[int, ...]
    unrecorded: int
    unasked: int

    @property
    def is_same(self) -> bool:
        """Return whether every recorded answer was given again."""
        return not self.different and not self.unasked


def compare_again(
    questions: Iterable[Any], recorded: Iterable[tuple[int, bytes]], make: MakeAdviser, tick_period: float
) -> Comparison:
    """Answer the `questions` of a run again.

    Parameters
    ----------
    questions : heave_msgs/Observations, in order; one that goes back in time begins another run, with a new adviser
    recorded : last tick of a batch and the serialised answer to it, in order
    make : makes the adviser
    tick_period : of the run [s]

    Raises WireError for a question that makes no sense.
    """
    waiting: defaultdict[int, deque[bytes]] = defaultdict(deque)
    for asked, data in recorded:
        waiting[asked].append(data)
    equal, different, unrecorded = 0, [], 0
    answers, next_tick = Answering(make, tick_period), 0
    for question in questions:
        if question.first < next_tick:
            answers = Answering(make, tick_period)
        answer = answers.answer(question)
        next_tick = question.first + len(question.ticks) // len(question.tick_columns)
        of_run = waiting[next_tick - 1]
        if not of_run:
            unrecorded += 1
        elif answer == of_run.popleft():
            equal += 1
        else:
            different.append(next_tick - 1)
    return Comparison(equal, tuple(different), unrecorded, unasked=sum(map(len, waiting.values())))
