"""What follows when the winch has stopped by itself because no command came in time.

A hiccup of the machine between controller and winch is over when commands are taken again: compensation then goes on by
itself. Each raises the bar for the next attempt, until compensation has gone well for some waves; where they come again
and again an operator decides.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum

from heave_node.interface.alarm import Alarm
from heave_node.interface.codes import WinchFault

from winch_controller_node.interface.alarms import ALARMS

WAIT = 3.0
"""Time that the winch stands with all sensors and its link well before compensation is tried again [s]."""


class Advice(Enum):
    """What is to be done about a command timeout."""

    RESUME = "resume"
    GIVE_UP = "give up"

    @property
    def alarm(self) -> Alarm:
        """What is reported of it."""
        if self is Advice.RESUME:
            return ALARMS.alarm("COMMANDS_RESTORED")
        return ALARMS.alarm("COMMAND_TIMEOUTS")


class CommandTimeouts:
    """Watches for command timeouts of the winch.

    Parameters
    ----------
    tick_period : [s]
    resumes : compensation may resume automatically
    count : counts an attempt that was ended so; returns whether an operator has to ask from then on
    """

    def __init__(self, tick_period: float, *, resumes: bool, count: Callable[[], bool]) -> None:
        self._dt = tick_period
        self._resumes, self._count = resumes, count
        self._fault_before = int(WinchFault.NONE)
        self._is_pending = self._is_tried = False
        self._well_time = 0.0

    @property
    def is_pending(self) -> bool:
        """Tell whether compensation is asked for again once commands reach the winch."""
        return self._is_pending

    def cancel(self) -> None:
        """Leave it to the operator, who has asked for something."""
        self._is_pending = False

    def update(self, fault: int, *, wants_compensation: bool, is_stopped: bool, is_well: bool) -> Advice | None:
        """Take in a tick and return what is to be done; None: nothing.

        Parameters
        ----------
        fault : of the winch, as reported last
        wants_compensation : the winch compensated up to now, or was to begin or to resume automatically
        is_stopped : the mode is stopped
        is_well : the link to the winch and all sensors are well, these for long enough where the winch was stopped for
            them
        """
        is_new = fault == WinchFault.COMMAND_TIMEOUT and self._fault_before != fault
        self._fault_before = fault
        if is_new and wants_compensation and self._resumes:
            return self._note()
        self._is_pending = self._is_pending and fault == WinchFault.COMMAND_TIMEOUT
        if not self._is_pending:
            return None
        self._well_time = self._well_time + self._dt if is_stopped and is_well else 0.0
        if self._well_time < WAIT:
            return None
        # a winch that was released and kept its fault counts as one that has timed out again
        advice = self._note() if self._is_tried else None
        self._is_tried, self._well_time = self._is_pending, 0.0
        return advice or Advice.RESUME

    def _note(self) -> Advice | None:
        """Note a timeout that ended compensation."""
        is_often = self._count()
        self._is_pending, self._is_tried, self._well_time = not is_often, False, 0.0
        return Advice.GIVE_UP if is_often else None
