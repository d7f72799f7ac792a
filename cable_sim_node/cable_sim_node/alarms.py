"""Alarms of the plant and of the virtual winch: the rows of `alarms.yaml`."""

from __future__ import annotations

from pathlib import Path

from heave_node.interface.alarm import Alarm, read_alarms
from heave_node.interface.codes import RELEASE_WORDS, WinchFault, WinchRelease

DRIVE_CODES = {
    WinchFault.COMMAND_TIMEOUT: "WINCH_COMMAND_TIMEOUT",
    WinchFault.INVALID_COMMAND: "WINCH_INVALID_COMMAND",
    WinchFault.DRIVE: "WINCH_DRIVE_FAULT",
    WinchFault.EMERGENCY_STOP: "WINCH_EMERGENCY_STOP",
}
"""Alarm of each fault for which the winch stops by itself."""

BRAKE_WORDS = {True: "on", False: "open"}
"""The brake as its switch says."""

ALARMS = read_alarms(Path(__file__).with_name("alarms.yaml"))


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
