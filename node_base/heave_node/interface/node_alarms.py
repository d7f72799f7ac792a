"""Alarms that every node may raise: who publishes, clocks of external nodes, messages that are late or missing."""

from __future__ import annotations

from pathlib import Path

from heave_node.interface.alarm import read_alarms

NODE_ALARMS = read_alarms(Path(__file__).with_name("alarms.yaml"))
