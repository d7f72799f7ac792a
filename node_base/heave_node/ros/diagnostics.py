"""Health of a node's parts, as DiagnosticArray."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from heave_node.interface.alarm import Alarm, Severity


class Level(Enum):
    """Level of a status, as in diagnostic_msgs/DiagnosticStatus."""

    OK = DiagnosticStatus.OK
    WARN = DiagnosticStatus.WARN
    ERROR = DiagnosticStatus.ERROR
    STALE = DiagnosticStatus.STALE


@dataclass(frozen=True)
class Health:
    """Health of one part of a node: a sensor, the solver, the tick protocol."""

    part: str  # its name
    level: Level = Level.OK  # severity
    message: str = "ok"  # one line for the user
    values: Mapping[str, str] = field(default_factory=dict)  # figures by name


LEVELS = {
    Severity.EVENT: Level.OK,
    Severity.LOW: Level.WARN,
    Severity.MEDIUM: Level.WARN,
    Severity.HIGH: Level.ERROR,
    Severity.CRITICAL: Level.ERROR,
}
"""Level of a status that is an alarm, by its severity."""


def alarm_health(part: str, alarm: Alarm, values: Mapping[str, str] | None = None) -> Health:
    """Return the health of a `part` that raises an `alarm`, with figures (`values`): its line, code and severity."""
    reported = {"code": alarm.code, "severity": alarm.severity.word, **(values or {})}
    return Health(part, LEVELS[alarm.severity], str(alarm), reported)


def diagnostic_array(node: str, stamp: Time, parts: Sequence[Health]) -> DiagnosticArray:
    """Return the message with the health of the `parts` of `node` at `stamp`."""
    message = DiagnosticArray()
    message.header.stamp = stamp
    for part in parts:
        status = DiagnosticStatus(level=part.level.value, name=f"{node}: {part.part}", message=part.message)
        status.hardware_id = node
        status.values = [KeyValue(key=key, value=value) for key, value in part.values.items()]
        message.status.append(status)
    return message
