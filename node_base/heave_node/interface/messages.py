"""Message classes by the name of their type, and readings as messages. No rclpy: messages are bytes or plain data."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from typing import Any

from heave_node.cdr.packer import Packer
from heave_node.cdr.unpacker import Unpacker, header_stamp
from heave_node.interface.sensors import Sensor, WireReading


def message_type(name: str) -> type[Any]:
    """Return the message class of the type `name`, such as "heave_msgs/msg/MruSample".

    Raises ModuleNotFoundError or AttributeError where the package or the message is not installed.
    """
    package, kind, message = name.split("/")
    return getattr(importlib.import_module(f"{package}.{kind}"), message)  # type: ignore[no-any-return]


class MessageReader:
    """Reads serialised messages of one type that begin with a Header.

    Parameters
    ----------
    name : of the type
    fields : dotted names of those whose numbers a reading has, in that order
    """

    def __init__(self, name: str, fields: Sequence[str]) -> None:
        self._unpacker = Unpacker(name, fields)

    def reading(self, data: bytes) -> WireReading:
        """Return the reading that the message `data` carries. Raises LayoutError where it does not fit the type."""
        numbers = self._unpacker.unpack(data)
        return WireReading(header_stamp(data), numbers)


class SensorMessages(MessageReader):
    """The messages of a `sensor` of SENSORS; what is read of them are the values, without their accuracies."""

    def __init__(self, sensor: Sensor) -> None:
        super().__init__(sensor.topic.type, sensor.values)
        fields = ("header.stamp", *sensor.values, *sensor.accuracies)
        self._packer = Packer(sensor.topic.type, fields, {"header.frame_id": sensor.frame, **dict(sensor.constants)})

    def message(self, reading: WireReading) -> bytes:
        """Return the serialised message that carries a reading."""
        return self._packer.pack(reading.stamp, *reading.numbers)
