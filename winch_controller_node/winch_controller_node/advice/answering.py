"""An adviser behind its messages: what every shell does with it, in its own process, in a worker, or over a bag."""

from __future__ import annotations

from collections.abc import Callable
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
