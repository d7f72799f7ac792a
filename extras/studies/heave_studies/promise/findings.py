"""What a controller has found of its parts, and that it gave an alarm: read from the lines of its alarms."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from heave_node.interface.alarm import ReadAlarm, Severity, alarms_in
from winch_controller_node.interface.alarms import ALARMS

Alarm = tuple[float, str]
"""Time [s] and line."""

WINCH, ENCODER, DRUM = "winch", "encoder", "drum"
PARTS = ("mru", "depth", ENCODER, "load_cell", "cable")
"""Parts that an alarm may blame by itself."""
LOAD = ("CABLE_SLACK", "TENSION_HIGH", "TENSION_TRAVEL", "TENSION_LIMIT_LOW")
"""Alarms of the load of a cable, which is as it should be."""
NO_BLAME = (*LOAD, "LOWERING_BLIND", *(code for code in ALARMS if code.startswith("NOT_DESIGNABLE")))
NO_WARNING = ("AUTHORITY_LIMITED", "PROGRAMME_REJECTED", "PREVIEW_REJECTED")
"""Alarms above an event that are no trouble of a part."""
IDENTIFIED = ("WINCH_MODEL_UPDATED", "IDENTIFIED")
"""How the codes of events begin that name a part which is not as stated."""


@dataclass(frozen=True)
class Finding:
    """A part that is blamed."""

    time: float  # [s]
    parts: tuple[str, ...]  # one of these is at fault
    words: str  # of the alarm


def changes_in(text: str) -> list[tuple[str, float]]:
    """Return what the text of an updated model names, with the values that were identified."""
    return [(name, float(value)) for name, value in re.findall(r"([a-z][a-z ]*?) (-?[\d.]+)[^,(]*\(was", text)]


def blamed_by(alarm: ReadAlarm, *, noise: bool = True) -> tuple[str, ...]:
    """Return the parts of which an `alarm` blames one; empty: none. Whether too much `noise` is blame is a choice."""
    if alarm.code == "WINCH_MODEL_UPDATED":
        return (WINCH, ENCODER) if [name for name, _ in changes_in(alarm.text)] == ["gain by the encoder"] else (WINCH,)
    part = next((row.part for row in ALARMS.of_code(alarm.code)), "")
    is_event = alarm.severity is Severity.EVENT and not alarm.code.startswith(IDENTIFIED)
    if is_event or part not in PARTS or alarm.code in NO_BLAME:
        return ()
    is_noise = alarm.code.startswith("SENSOR_DOUBTFUL") and alarm.text.startswith("noise of ")
    return () if is_noise and not noise else (part,)


def findings_of(alarms: Sequence[Alarm]) -> list[Finding]:
    """Return what the `alarms` of a run blame."""
    read = [(time, words, one) for time, words in alarms for one in alarms_in(words)]
    return [Finding(time, parts, words) for time, words, one in read if (parts := blamed_by(one))]


def warnings_of(alarms: Sequence[Alarm]) -> list[float]:
    """Return the times [s] of the `alarms` that report trouble; events, moves and limited authority do not."""
    read = [(time, one) for time, words in alarms for one in alarms_in(words)]
    troubles = [time for time, one in read if one.severity > Severity.EVENT and one.code not in NO_WARNING]
    return sorted(troubles + [time for time, one in read if one.code.startswith(IDENTIFIED)])
