"""An adviser behind its messages: what every shell does with it, in its own process, in a worker, or over a bag."""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Protocol

from winch_controller_node.advice.messages import beliefs_message, observations_of
from winch_controller_node.beliefs.beliefs import Beliefs, latency_ticks
from winch_controller_node.design.wire import parameters_of
from winch_controller_node.interface.observations import Observations
from winch_controller_node.node_parameters import WinchControllerParameters


class Adviser(Protocol):
    """What answers observations."""

    def advise(self, observations: Observations) -> Beliefs:
        """Return the answer to a batch of `observations`; batches come in order."""
        ...


MakeAdviser = Callable[[WinchControllerParameters, float], Adviser]
"""Makes an adviser from nominal parameters and the tick period [s]."""


class Answering:
    """Answers messages with messages. The nominal comes with the observations, so that an adviser can begin
    anywhere; with another one another adviser begins.

    Parameters
    ----------
    make : makes the adviser
    tick_period : [s]
    """

    def __init__(self, make: MakeAdviser, tick_period: float) -> None:
        self._make = make
        self._dt = tick_period
        self._nominal = ""
        self._adviser: Adviser | None = None

    def answer(self, message: Any) -> bytes:
        """Return the answer to a heave_msgs/Observations, the `message`, as a serialised heave_msgs/Beliefs.

        It is stamped with the start of the last tick before it becomes active. Raises WireError for a message that
        makes no sense, DesignError where the adviser has no design for its nominal.
        """
        observations = observations_of(message)
        if message.nominal != self._nominal:
            self._adviser = self._make(parameters_of(message.nominal), self._dt)
            self._nominal = message.nominal
        assert self._adviser is not None
        beliefs = self._adviser.advise(observations)
        last = beliefs.asked + latency_ticks(self._dt) - 1
        return beliefs_message(beliefs, last * round(self._dt * 1e9))


@dataclass(frozen=True)
class Comparison:
    """Answers beside those that were recorded."""

    equal: int  # answers with the same bytes
    different: tuple[int, ...]  # last ticks of the batches whose answers differ
    unrecorded: int  # batches without a recorded answer
    unasked: int  # recorded answers to batches that are not there

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
