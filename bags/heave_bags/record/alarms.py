"""Alarms of the recorder: code, severity, words."""

from __future__ import annotations

from heave_node.interface.alarm import AlarmRow, Severity, alarm_table

ALARMS = alarm_table(
    AlarmRow(
        "RECORDING_FAILED",
        Severity.HIGH,
        "recorder",
        "messages are not recorded: {problem}",
        "They are missing from the bag. After a full disk nothing more is recorded",
        "Free the disk or choose another folder, then start recording again",
    ),
    AlarmRow(
        "TOPIC_UNREADABLE",
        Severity.MEDIUM,
        "recorder",
        "a topic cannot be read: {problem}",
        "The bag may lack the definition of that topic",
        "Source the workspace that defines its type, then start the recorder again",
    ),
)
