"""Every alarm of the controller: the rows of `alarms.yaml`. Raised by `ALARMS.alarm(code, **values)`."""

from __future__ import annotations

from pathlib import Path

from heave_node.interface.alarm import AlarmTable, read_alarms

ALARMS: AlarmTable = read_alarms(Path(__file__).with_name("alarms.yaml"))
"""All of them, by code."""

HARMFUL = frozenset(("UNIT_HEAVE_HIGH", "UNIT_SWING_HIGH", "DRUM_SPEED_OFF", "WORSE_THAN_OFF", "LITTLE_GAIN"))
"""Codes by which the guard ends compensation that does harm."""
