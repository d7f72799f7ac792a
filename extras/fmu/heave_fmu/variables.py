"""The scalar variables of an FMU: fields of messages, with the names, units and meanings of their definitions.

A field `payout` of the topic `winch/command` is the variable `winch.command.payout`: topic and field with dots.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import NamedTuple
from xml.etree.ElementTree import Element, SubElement

from heave_bags.analyse.time_base import field_column
from heave_node.cdr.definitions import schema_text
from heave_node.cdr.layout import NUMPY_TYPES, parse_schema
from heave_node.interface.sensors import SENSORS
from heave_node.interface.topic import Topic

REAL, INTEGER, BOOLEAN, STRING = "Real", "Integer", "Boolean", "String"

STAMP = "header.stamp"
COUNT = "count"

UNITS: Mapping[str, Mapping[str, int]] = {
    "m": {"m": 1},
    "m/s": {"m": 1, "s": -1},
    "m/s^2": {"m": 1, "s": -2},
    "s": {"s": 1},
    "N": {"kg": 1, "m": 1, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "rad": {"rad": 1},
    "rad/s": {"rad": 1, "s": -1},
}
"""Units of messages as exponents of the SI base units, which the FMI asks for."""

_STANDARD = (
    (r"position", "m"),
    (r"linear", "m/s"),
    (r"angular|angular_velocity", "rad/s"),
    (r"linear_acceleration", "m/s^2"),
    (r"fluid_pressure", "Pa"),
    (r"(slew|luff|knuckle)_rate", "rad/s"),
    (r"extension_rate", "m/s"),
)
"""Units of fields whose own line in the definition has none: those of ROS are SI by REP-103."""

_STAMP_MEANING = "time of the message, simulated; below 0 at an input: that of the step [s]"
_COUNT_MEANING = "messages sent so far; -1 at an input, as at the start: nobody counts, one comes with each tick"


def unit_definitions(names: Iterable[str]) -> Element:
    """Return the units of these `names`, "" for none, as the element of a model description."""
    definitions = Element("UnitDefinitions")
    for name in sorted(set(names) - {""}):
        unit = SubElement(definitions, "Unit", name=name)
        SubElement(unit, "BaseUnit", {base: str(power) for base, power in UNITS[name].items()})
    return definitions


class Variable(NamedTuple):
    """A scalar variable."""

    name: str  # of the FMU
    kind: str  # REAL, INTEGER, BOOLEAN or STRING
    unit: str  # SI; "" for none
    meaning: str  # what it is, in words, with sign and frame


def base_name(topic: str) -> str:
    """Return the name that the variables of a `topic` begin with."""
    return topic.replace("/", ".")


def count_variable(topic: Topic) -> Variable:
    """Return the variable that counts the messages of a `topic`."""
    return Variable(f"{base_name(topic.name)}.{COUNT}", INTEGER, "", _COUNT_MEANING)


def message_variables(topic: Topic, fields: tuple[str, ...], prefix: str) -> list[Variable]:
    """Return the variables of one message: its stamp, then its `fields`.

    Parameters
    ----------
    topic : with the type of the message
    fields : dotted names, numbers, flags or texts each
    prefix : of the names
    """
    stamp = Variable(f"{prefix}.{STAMP}", REAL, "s", _STAMP_MEANING)
    return [stamp, *(_variable(topic, field, prefix) for field in fields)]


def _variable(topic: Topic, field: str, prefix: str) -> Variable:
    column = field_column(schema_text(topic.type), field)
    kind = _kind(topic.type, field)
    leaf = [part.partition("[")[0] for part in field.split(".")]
    standard = [unit for part in leaf for pattern, unit in _STANDARD if re.fullmatch(pattern, part)]
    unit = column.unit if column.unit in UNITS else (standard or [""])[-1]
    sensor = next((sensor for sensor in SENSORS.values() if sensor.topic == topic), None)
    meaning = column.meaning or (sensor.meaning if sensor is not None else f"{field} of {topic.type}")
    return Variable(f"{prefix}.{field}", kind, unit if kind == REAL else "", meaning.replace("`", ""))


def _kind(type_name: str, field: str) -> str:
    """Return the kind of the variable of a `field` of a message of this type."""
    types = parse_schema(type_name, schema_text(type_name))
    name = next(iter(types))
    for part in field.split("."):
        name = next(member.type for member in types[name] if member.name == part.partition("[")[0])
    if name == "string":
        return STRING
    if name == "bool":
        return BOOLEAN
    return REAL if NUMPY_TYPES[name].startswith("f") else INTEGER
