"""Numbers that messages carry in place of words, and words by which a figure is found in diagnostics. Pure; a test
holds the numbers against the constants of heave_msgs.
"""

from __future__ import annotations

import enum
import re
from collections.abc import Mapping


class WinchFault(enum.IntEnum):
    """Why the winch stopped by itself: heave_msgs/WinchState FAULT_."""

    NONE = 0
    COMMAND_TIMEOUT = 1
    INVALID_COMMAND = 2
    DRIVE = 3
    EMERGENCY_STOP = 4


class WinchRelease(enum.IntEnum):
    """What a latched fault of the winch waits for: heave_msgs/WinchState RELEASE_."""

    NONE = 0
    BRAKE_REQUEST = 1
    STANDSTILL = 2
    COMMAND = 3


class WinchLimit(enum.IntFlag):
    """Limits of the winch that acted: heave_msgs/WinchState LIMIT_."""

    NONE = 0
    SPEED = 1
    ACCELERATION = 2
    PAYOUT = 4
    POWER = 8
    TORQUE = 16
    PRESSURE = 32
    FLOW = 64


class MruStatus(enum.IntEnum):
    """What the motion reference unit reports of its own sample: heave_msgs/MruSample STATUS_."""

    OK = 0
    SETTLING = 1
    INVALID = 2


class SensorLevel(enum.IntEnum):
    """How the controller sees a sensor: heave_msgs/SensorHealth."""

    OK = 0
    SUSPECT = 1
    LOST = 2


RELEASE_WORDS = {
    WinchRelease.NONE: "nothing is latched",
    WinchRelease.BRAKE_REQUEST: "the controller commands brake on, then brake off",
    WinchRelease.STANDSTILL: "the drum stands still, then the controller commands brake off",
    WinchRelease.COMMAND: "the controller commands brake off",
}
"""What has to be for a latched fault to be released, in words: it stays until ..."""

COMMANDS, LATE = "commands", "late"
"""Part of the controller's diagnostics about its commands, and the value in it that counts those that came late."""

ALARMS = "alarms"
"""Part of the controller's diagnostics with the alarms since the last ones, by time, as values: see `alarms_in`."""

MODE = "mode"
"""Part of the controller's diagnostics with its mode and why, and each change since the last ones by time, as values.
"""

SENSOR = "sensor"
"""Begins the names of the parts of the controller's diagnostics with how it sees each sensor; the sensor follows."""

OPERATOR = "operator"
"""Part of the controller's diagnostics with what an operator has asked for since the last ones, by time, as values and
in its message.
"""

REQUESTED = "requested"
"""Last word of the reason of a mode that somebody asked for."""

RESTS_REQUESTED = (f"stop {REQUESTED}", f"standby {REQUESTED}", f"manual {REQUESTED}")
"""Reasons of modes in which compensation rests since somebody asked for that; an emergency stop is none of them."""

MODE_CHANGED, COMPENSATION_LOST = "MODE_CHANGED", "COMPENSATION_LOST"
"""Codes of the controller's alarms about its mode: any change, and compensation that ended unrequested."""

WINCH_MODEL_UPDATED, OPERATOR_SPEED_LIMITED = "WINCH_MODEL_UPDATED", "OPERATOR_SPEED_LIMITED"
"""Codes of the controller's alarms that other packages look for."""


def time_key(time: float) -> str:
    """Return the key of a value for an event at a simulated `time` [s]."""
    return f"t = {time:.2f} s"


def time_of(key: str) -> float | None:
    """Return the simulated time [s] of the event of a `key`; None for any other key."""
    found = TIME_KEY.fullmatch(key)
    return None if found is None else float(found[1])


def timed_message(events: Mapping[str, str]) -> str:
    """Return the message, for `timed_words`, of what happened: `events` in words by the key of their time."""
    return "; ".join(f"{time}: {what}" for time, what in events.items())


def timed_words(message: str) -> list[tuple[float, str]]:
    """Return simulated time [s] and words of all events in a `message`: "t = 1.00 s: this; t = 2.00 s: that"."""
    _, *found = re.split(rf"(?:^|; ){TIME_KEY.pattern}: ", message)
    return [(float(time), words) for time, words in zip(found[::2], found[1::2], strict=True)]


TIME_KEY = re.compile(r"t = ([0-9.]+) s")
"""Pattern of the keys that `time_key` returns; its group is the time [s]."""
_FIGURES = re.compile(r"[-+]?[0-9.]+")


def without_figures(message: str) -> str:
    """Return a `message` of diagnostics without what changes in it while its report stays the same, as a countdown."""
    return _FIGURES.sub("", message)


def fault_words(code: int) -> str:
    """Return the fault of a winch, given by its `code`, in words; an unknown number of hardware is named as such."""
    try:
        return WinchFault(code).name.lower().replace("_", " ")
    except ValueError:
        return f"unknown fault {code}"
