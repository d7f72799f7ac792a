"""The list of alarms: what is wrong now, and what was and nobody has acknowledged yet."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from heave_bringup.operate.situation import Trouble

MOST = 200
"""Alarms that are kept; the oldest that has passed goes first."""


@dataclass(frozen=True)
class Alarm:
    """A trouble and what has become of it.

    Attributes
    ----------
    trouble : part, message, error or warning
    since : simulated time at which it came [s]
    is_active : it still holds
    is_acknowledged : somebody has seen it
    """

    trouble: Trouble
    since: float
    is_active: bool = True
    is_acknowledged: bool = False


class AlarmList:
    """Alarms by part, the newest first."""

    def __init__(self) -> None:
        self._alarms: dict[str, Alarm] = {}

    def note(self, time: float, troubles: Mapping[str, Trouble]) -> None:
        """Take what is wrong now, `troubles` by part, at a simulated `time` [s].

        An alarm that comes back, or gets worse, is to be acknowledged anew.
        """
        for part, trouble in troubles.items():
            known = self._alarms.get(part)
            if known is None or not known.is_active or (trouble.is_error and not known.trouble.is_error):
                self._alarms.pop(part, None)
                self._alarms[part] = Alarm(trouble, time)
            elif known.trouble != trouble:
                self._alarms[part] = replace(known, trouble=trouble)
        for part, alarm in list(self._alarms.items()):
            if part not in troubles:
                self._alarms[part] = replace(alarm, is_active=False)
                if alarm.is_acknowledged:
                    del self._alarms[part]
        for part in [part for part, alarm in self._alarms.items() if not alarm.is_active][:-MOST]:
            del self._alarms[part]

    def acknowledge(self, part: str) -> None:
        """Take note that somebody has seen the alarm of a `part`; one that has passed leaves the list."""
        alarm = self._alarms.get(part)
        if alarm is not None and alarm.is_active:
            self._alarms[part] = replace(alarm, is_acknowledged=True)
        elif alarm is not None:
            del self._alarms[part]

    @property
    def alarms(self) -> tuple[Alarm, ...]:
        """All of them, the newest first."""
        return tuple(reversed(self._alarms.values()))
