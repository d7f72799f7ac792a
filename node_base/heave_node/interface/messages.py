"""Message classes by the name of their type, and the readings of sensors in them. No rclpy: messages are plain data."""

from __future__ import annotations

import importlib
from operator import attrgetter
from typing import Any

from heave_node.interface.sensors import Sensor, WireReading
from heave_node.tick.tick import nanoseconds_of, stamp_of


def message_type(name: str) -> type[Any]:
    """Return the message class of the type `name`, such as "heave_msgs/msg/MruSample".

    Raises ModuleNotFoundError or AttributeError where the package or the message is not installed.
    """
    package, kind, message = name.split("/")
    return getattr(importlib.import_module(f"{package}.{kind}"), message)  # type: ignore[no-any-return]


class _Field:
    """A number in a message, named like "twist.covariance[7]"."""

    def __init__(self, path: str) -> None:
        path, _, index = path.partition("[")
        *owner, self._name = path.split(".")
        self._owner = attrgetter(".".join(owner)) if owner else None
        self._index = int(index.rstrip("]")) if index else None

    def put(self, message: Any, number: float) -> None:
        """Write the number."""
        owner = message if self._owner is None else self._owner(message)
        if self._index is None:
            setattr(owner, self._name, number)
        else:
            getattr(owner, self._name)[self._index] = number

    def take(self, message: Any) -> Any:
        """Read the number."""
        value = getattr(message if self._owner is None else self._owner(message), self._name)
        return value if self._index is None else value[self._index]


class SensorMessages:
    """The messages of one sensor.

    Parameters
    ----------
    sensor : of the table `sensors.SENSORS`
    """

    def __init__(self, sensor: Sensor) -> None:
        self.sensor = sensor
        self._type = message_type(sensor.topic.type)
        self._values = [_Field(path) for path in sensor.values]
        self._numbers = self._values + [_Field(path) for path in sensor.accuracies]
        self._constants = [(_Field(path), number) for path, number in sensor.constants]

    def message(self, reading: WireReading) -> Any:
        """Return the message that carries a reading."""
        message = self._type()
        message.header.stamp = stamp_of(reading.stamp)
        message.header.frame_id = self.sensor.frame
        for field, number in self._constants:
            field.put(message, number)
        for field, number in zip(self._numbers, reading.numbers, strict=True):
            field.put(message, number)
        return message

    def reading(self, message: Any) -> WireReading:
        """Return the reading that a message carries: its values, without their accuracies."""
        return WireReading(nanoseconds_of(message.header.stamp), tuple(field.take(message) for field in self._values))
