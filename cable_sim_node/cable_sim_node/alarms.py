"""Alarms of the plant and of the virtual winch: code, severity, words."""

from __future__ import annotations

from heave_node.interface.alarm import Alarm, AlarmRow, Severity, alarm_table
from heave_node.interface.codes import RELEASE_WORDS, WinchFault, WinchRelease

from cable_sim_node.inputs import CLOSING_TIME, LONGEST_EXTRAPOLATION

DRIVE_CODES = {
    WinchFault.COMMAND_TIMEOUT: "WINCH_COMMAND_TIMEOUT",
    WinchFault.INVALID_COMMAND: "WINCH_INVALID_COMMAND",
    WinchFault.DRIVE: "WINCH_DRIVE_FAULT",
    WinchFault.EMERGENCY_STOP: "WINCH_EMERGENCY_STOP",
}
"""Alarm of each fault for which the winch stops by itself."""

_ACTIONS = {
    WinchFault.COMMAND_TIMEOUT: "Check the controller, the network and the CPU load of the computer",
    WinchFault.INVALID_COMMAND: "Check the numbers that the controller sends, then request a mode",
    WinchFault.DRIVE: "Clear the fault at the drive, then request a mode",
    WinchFault.EMERGENCY_STOP: "Clear the cause, then request a mode",
}

BRAKE_WORDS = {True: "on", False: "open"}
"""The brake as its switch says."""

ALARMS = alarm_table(
    *(
        AlarmRow(
            code,
            Severity.HIGH,
            "winch",
            f"the winch has stopped ({fault.name.lower().replace('_', ' ')}{{cause}})",
            "The brake is {brake}; the fault stays latched until {condition}",
            _ACTIONS[fault],
        )
        for fault, code in DRIVE_CODES.items()
    ),
    AlarmRow(
        "CABLE_OVERSTRAINED",
        Severity.CRITICAL,
        "cable",
        "strain {percent:.1f} %, limit {limit:.0f} %",
        "The rope would have parted: results are not valid from here on",
        "Check cable.axial_stiffness, the masses and the snaps of this run",
    ),
    AlarmRow(
        "CABLE_SEGMENTS_SLACK",
        Severity.LOW,
        "cable",
        "{count} segments are slack",
        "A snap load may follow",
        "Lower more slowly, or wait for calmer seas",
    ),
    AlarmRow(
        "PLANT_INPUT_MISSING",
        Severity.MEDIUM,
        "network",
        "{name} missing for {count} ticks",
        f"Its last speed decays with a time constant of {CLOSING_TIME:g} s; in real time a value up to "
        f"{LONGEST_EXTRAPOLATION:g} s old is still used",
        "Check the node that publishes it",
    ),
)


def fault_alarm(fault: WinchFault, release: WinchRelease, *, brake: bool, cause: str) -> Alarm:
    """Return the alarm of a `fault` for which the winch has stopped by itself.

    Parameters
    ----------
    fault : other than NONE
    release : what it waits for
    brake : its switch says that it is on
    cause : in words; empty: not known
    """
    told = f": {cause}" if cause else ""
    return ALARMS.alarm(DRIVE_CODES[fault], cause=told, brake=BRAKE_WORDS[brake], condition=RELEASE_WORDS[release])
