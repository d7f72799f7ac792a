"""The list of alarms: what is wrong now, and what was and nobody has acknowledged yet."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from string import Formatter

from heave_bringup.operate.situation import Trouble
from heave_bringup.pages.alarms import TABLES
from heave_node.interface.alarm import AlarmRow, Severity, alarms_in

MOST = 200
"""Alarms that are kept; the oldest that has passed goes first."""

ROWS: list[AlarmRow] = [row for table in TABLES.values() for row in table.values()]
"""Every alarm of the suite, by code."""


@dataclass(frozen=True)
class Alarm:
    """An alarm and what has become of it."""

    key: str  # node and code, or part of /diagnostics where what it reports has no code
    title: str  # code, or part of /diagnostics
    severity: Severity  # priority
    text: str  # what is wrong, and what follows
    action: str = ""  # what to do; empty where that is not known
    since: float = math.nan  # simulated time at which it was raised [s]; NaN: not known yet
    is_older: bool = False  # it was raised at some time before that: it was there when the list began
    is_active: bool = True  # it still holds
    is_acknowledged: bool = False  # somebody has seen it


def split_action(text: str, action: str) -> tuple[str, str]:
    """Return a `text` without the `action` at its end, and that action with the values that the text gives."""
    words = "".join(re.escape(word) + (".+" if name else "") for word, name, _, _ in Formatter().parse(action))
    found = re.fullmatch(rf"(.*\.) ({words})\.", text)
    return (found[1], found[2]) if found else (text, "" if "{" in action else action)


def alarms_of(trouble: Trouble) -> Iterator[Alarm]:
    """Return the alarms that a `trouble` reports; events are none. One without a code is as grave as its status."""
    found = alarms_in(trouble.message)
    node = trouble.part.partition(":")[0]
    for one in found:
        if one.severity > Severity.EVENT:
            splits = [split_action(one.text, row.action) for row in ROWS if row.code == one.code]
            otherwise = splits[0] if len(splits) == 1 else (one.text, "")
            text, action = next((split for split in splits if split[0] != one.text), otherwise)
            yield Alarm(f"{node} {one.code}", one.code, one.severity, text, action, one.time)
    if not found:
        severity = Severity.HIGH if trouble.is_error else Severity.MEDIUM
        yield Alarm(trouble.part, trouble.part, severity, trouble.message)


class AlarmList:
    """Alarms by key."""

    def __init__(self) -> None:
        self._alarms: dict[str, Alarm] = {}
        self._has_begun = False

    def note(self, time: float, troubles: Mapping[str, Trouble]) -> None:
        """Take what is wrong now, `troubles` by part, at a simulated `time` [s]; that counts where a line has none.

        An alarm that comes back, or gets worse, is to be acknowledged again. One that several parts report is one.
        """
        present: dict[str, Alarm] = {}
        for alarm in (alarm for trouble in troubles.values() for alarm in alarms_of(trouble)):
            other = present.get(alarm.key)
            since = alarm.since if other is None or math.isfinite(alarm.since) else other.since
            worst = alarm if other is None or alarm.severity > other.severity else other
            present[alarm.key] = replace(worst, since=since)
        for key, alarm in present.items():
            known = self._alarms.get(key)
            if known is None or not known.is_active or alarm.severity > known.severity:
                self._alarms.pop(key, None)
                is_dated = math.isfinite(alarm.since)
                since, is_older = alarm.since if is_dated else time, not (is_dated or self._has_begun)
                self._alarms[key] = replace(alarm, since=since, is_older=is_older)
            else:
                seen = known.is_acknowledged
                self._alarms[key] = replace(alarm, since=known.since, is_older=known.is_older, is_acknowledged=seen)
        self._has_begun = True
        for key, alarm in list(self._alarms.items()):
            if key not in present:
                self._alarms[key] = replace(alarm, is_active=False)
                if alarm.is_acknowledged:
                    del self._alarms[key]
        for key in [key for key, alarm in self._alarms.items() if not alarm.is_active][:-MOST]:
            del self._alarms[key]

    def acknowledge(self, key: str) -> None:
        """Take note that somebody has seen the alarm of a `key`; one that has passed leaves the list."""
        alarm = self._alarms.get(key)
        if alarm is not None and alarm.is_active:
            self._alarms[key] = replace(alarm, is_acknowledged=True)
        elif alarm is not None:
            del self._alarms[key]

    @property
    def alarms(self) -> tuple[Alarm, ...]:
        """All of them, the gravest first, and of those the newest."""
        newest_first = list(self._alarms.values())[::-1]
        return tuple(sorted(newest_first, key=lambda alarm: -alarm.severity))
