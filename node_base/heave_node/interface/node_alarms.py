"""Alarms that every node may raise: who publishes, clocks of external nodes, messages that are late or missing."""

from __future__ import annotations

from heave_node.interface.alarm import AlarmRow, Severity, alarm_table

NODE_ALARMS = alarm_table(
    AlarmRow(
        "UNKNOWN_PUBLISHER",
        Severity.HIGH,
        "network",
        "{who} publishes on {topic} but is not part of the run",
        "Its messages are ignored",
        "Stop that process, or move it to another ROS domain or namespace",
    ),
    AlarmRow(
        "MESSAGE_REJECTED",
        Severity.HIGH,
        "network",
        "a message from {who} on {topic} was rejected: {why}",
        "It is not used",
        "Correct its publisher",
    ),
    AlarmRow(
        "CLOCK_VIOLATION",
        Severity.HIGH,
        "clock",
        "stamps of {topic} do not fit its clock: {violation}",
        "Its messages may be used late",
        "Set the clock of the external node",
    ),
    AlarmRow(
        "EXTERNAL_NODE_UNHEARD",
        Severity.HIGH,
        "network",
        "{mismatch}",
        "Its messages are not used",
        "Start the external node before the run, with matching types and QoS",
    ),
    AlarmRow(
        "PARTICIPANT_LATE",
        Severity.HIGH,
        "node",
        "waiting for {time:.0f} s: {missing}",
        "The run waits, and ends when that takes too long",
        "Check that the named node runs",
    ),
    AlarmRow(
        "INPUT_EARLY",
        Severity.MEDIUM,
        "clock",
        "{count} messages rejected, stamped in the future",
        "They are not used",
        "Set the clock of the publisher",
    ),
    AlarmRow(
        "INPUT_LATE",
        Severity.MEDIUM,
        "network",
        "{count} messages arrived late and were discarded",
        "Newer ones are used",
        "Check the network and the CPU load of the computer",
    ),
)
