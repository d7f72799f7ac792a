"""What all parts of the loop are, as FMUs hold them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable

from heave_bringup.closed_loop import LoopParameters
from heave_node.interface.sensors import WireReading
from heave_node.interface.topic import Topic

from heave_fmu.ports import Port

STEPS = 4
"""Steps of a tick after which parts that are stepped together have done it in the order of the loop."""


class Part(ABC):
    """A part of the loop.

    Parameters
    ----------
    parameters : of the loop

    Attributes
    ----------
    instant : of a tick at which it acts, as a share of the tick: the middle of its step where a tick has STEPS
    inputs, outputs : messages by topic
    """

    instant: float

    def __init__(self, parameters: LoopParameters) -> None:
        self.parameters = parameters
        self.tick_period = parameters.tick_period
        self._tick_nanoseconds = round(parameters.tick_period * 1e9)
        self.inputs: dict[str, Port] = {}
        self.outputs: dict[str, Port] = {}
        self.declare()
        for port in self.inputs.values():
            port.await_messages()

    @abstractmethod
    def declare(self) -> None:
        """Add the messages in and out."""

    @abstractmethod
    def start(self) -> None:
        """Make the component, and put out what is known at the first tick."""

    @abstractmethod
    def step(self, tick: int) -> list[str]:
        """Do a `tick`, from 1; return alarms, one line each."""

    def add_input(self, topic: Topic, fields: Iterable[str], slots: int = 1) -> None:
        """Take messages of a `topic` in: these `fields` of them, at most so many, `slots`, in a tick."""
        self.inputs[topic.name] = Port(topic, tuple(fields), slots)

    def add_output(self, topic: Topic, fields: Iterable[str], slots: int = 1) -> None:
        """Put messages of a `topic` out: these `fields` of them, at most so many, `slots`, in a tick."""
        self.outputs[topic.name] = Port(topic, tuple(fields), slots)

    def stamp(self, tick: int) -> int:
        """Return when a `tick` begins [ns]."""
        return tick * self._tick_nanoseconds

    def send(self, topic: Topic, tick: int, numbers: Iterable[object]) -> None:
        """Put the message of a `topic` out with the stamp of a `tick` and the `numbers` of its fields."""
        self.outputs[topic.name].publish([WireReading(self.stamp(tick), tuple(numbers))])  # type: ignore[arg-type]
