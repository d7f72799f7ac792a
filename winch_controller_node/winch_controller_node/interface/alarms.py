"""Every alarm of the controller: the rows of `alarms.yaml`. Raised by `ALARMS.alarm(name, **values)`."""

from __future__ import annotations

from pathlib import Path

from heave_node.interface.alarm import AlarmTable, read_alarms

ALARMS: AlarmTable = read_alarms(Path(__file__).with_name("alarms.yaml"))
"""All of them, by name."""
