"""Alarms of the recorder: code, severity, words."""

from __future__ import annotations

from heave_node.interface.alarm import AlarmRow, Severity, alarm_table

ALARMS = alarm_table(
    AlarmRow(
        "RECORDING_FAILED",
        Severity.HIGH,
        "recorder",
        "{problem}",
        "Messages are not recorded",
        "Free the disk or choose another folder, then start recording again",
    ),
    AlarmRow(
        "TOPIC_UNREADABLE",
        Severity.MEDIUM,
        "recorder",
        "{problem}",
        "That topic is recorded without its definition, or not at all",
        "Source the workspace that defines its type, then start the recorder again",
    ),
)
