"""Commands that the winch takes later than modelled: counted one by one, judged by their statistics."""

from __future__ import annotations

from heave_core.watch import Link
from heave_core.watch_table import LinkNews
from heave_node.interface.alarm import Alarm

from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.interface.readings import Lateness

LATE_WINDOW = 2.0
"""Commands of so many seconds are judged together: one hiccup of a machine is no slow transport."""

SHARE_WINDOW = 60.0
"""A share of the commands of so many seconds may be late."""

CUT_TIME = 0.5
"""Time without a new command taken after which the link counts as cut [s]: how late any command is, is then unknown."""

ROUNDING = 1e-6
"""Part of a tick that counts as none."""

CONSTANTS = {
    "late_ticks": 2,
    "largest_share": 0.1,
    "cut_time": CUT_TIME,
    "memory": 3.0,
    "rounding": ROUNDING,
}
"""Constants of the link: meanings and units are in the core's table, LINK_DESIGN."""


def link_values(tick_period: float) -> dict[str, float]:
    """Return the values of the core's LinkDesign for a `tick_period` [s]."""
    return {
        "minute": max(1, round(SHARE_WINDOW / tick_period)),
        "window": max(1, round(LATE_WINDOW / tick_period)),
        **CONSTANTS,
        "tick_period": tick_period,
    }


class LateCommands:
    """Notices that the winch takes commands later than modelled, by the sequence numbers that it acknowledges.

    They are counted in C++ (`heave_core`, winch_watch.cpp).

    Parameters
    ----------
    tick_period : [s]
    link : of the core; None: its own
    """

    def __init__(self, tick_period: float, link: Link | None = None) -> None:
        self._link = Link(link_values(tick_period)) if link is None else link
        self._state = self._link.state[0]

    @property
    def known(self) -> int:
        """Commands of which it is known how late they were, since the start."""
        return int(self._state["known"])

    @property
    def late(self) -> int:
        """Those that were late, since the start."""
        return int(self._state["late"])

    @property
    def largest(self) -> float:
        """Time by which one was later than modelled [s]."""
        return float(self._state["largest"])

    @property
    def has_begun(self) -> bool:
        """Tell whether with the last command they have just become late."""
        return bool(self._state["has_begun"])

    @property
    def is_cut(self) -> bool:
        """Tell whether no new command has been taken for CUT_TIME."""
        return bool(self._state["is_cut"])

    @property
    def overdue(self) -> float:
        """Time by which more than half of the commands of the last seconds were later than modelled, at least [s]."""
        return float(self._state["overdue"])

    @property
    def is_reported(self) -> bool:
        """Tell whether an alarm holds."""
        return bool(self._state["is_slow"] or self._state["is_ragged"])

    @property
    def news(self) -> Alarm | None:
        """What is wrong since this tick; None: nothing new."""
        found = int(self._state["news"])
        if found == LinkNews.COMMANDS_SLOW:
            return ALARMS.alarm("COMMANDS_LATE: delay", delay=self.overdue)
        if found == LinkNews.COMMANDS_RAGGED:
            minute = self._link.minute
            percent, largest = 100.0 * float(self._state["late_in_minute"]) / len(minute), float(minute.max())
            return ALARMS.alarm("COMMANDS_LATE: often", percent=percent, window=SHARE_WINDOW, largest=largest)
        return None


NOTABLE = 0.2
"""Delay that may be a cause [s]; watchdogs of winches are longer."""


class TimeoutCause:
    """Says why commands did not reach the winch in time.

    Parameters
    ----------
    tick_period : [s]
    link : of the core; None: its own
    """

    def __init__(self, tick_period: float, link: Link | None = None) -> None:
        self._dt = tick_period
        self._link = Link(link_values(tick_period)) if link is None else link

    def update(self, *, has_state: bool, untaken: float) -> None:
        """Take in a tick.

        Parameters
        ----------
        has_state : a state of the winch came
        untaken : time for which commands should have been in effect and were not [s]; not looked at without a
            state
        """
        self._link.silence(untaken, has_state=has_state)

    def words(self, lateness: Lateness) -> str:
        """Return the cause in words, with the `lateness` of the ticks; empty where it is not known."""
        state = self._link.state[0]
        untaken = float(state["untaken"])
        causes = {
            "the controller was delayed, its commands came {:.2f} s late": lateness.of_controller,
            "ticks began {:.2f} s late, the machine or the clock master stalled": lateness.of_clock,
            "no data from the winch for {:.2f} s": float(state["silence"]) - self._dt,
        }
        text, delay = max(causes.items(), key=lambda cause: cause[1])
        if delay > NOTABLE:
            return text.format(delay)
        if untaken > NOTABLE:
            return f"commands were sent in time, and the winch took none for {untaken:.2f} s"
        return ""
