"""Alarms of the recorder: code, severity, words."""

from __future__ import annotations

from heave_node.interface.alarm import AlarmRow, Severity, alarm_table

ALARMS = alarm_table(
    AlarmRow(
        "RECORDING_FAILED",
        Severity.HIGH,
        "recorder",
        "messages are not recorded: {problem}",
        "The bag lacks them. After a full disk it takes no more: in lockstep the run ends, in real time it continues",
        "Free the disk or choose another folder, then start recording again",
    ),
    AlarmRow(
        "TOPIC_UNREADABLE",
        Severity.MEDIUM,
        "recorder",
        "a topic cannot be read: {problem}",
        "That topic is recorded without its definition, or not at all",
        "Source the workspace that defines its type, then start the recorder again",
    ),
)
