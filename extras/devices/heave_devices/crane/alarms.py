"""Alarms of a crane that moves: the rows of `alarms.yaml`."""

from __future__ import annotations

from pathlib import Path

from heave_node.interface.alarm import read_alarms

ALARMS = read_alarms(Path(__file__).with_name("alarms.yaml"))
