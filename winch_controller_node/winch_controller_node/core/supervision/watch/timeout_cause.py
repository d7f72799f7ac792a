"""Who was silent when the winch stopped because no command came in time: the cause, not what followed from it."""

from __future__ import annotations

from heave_core.watch import Link

from winch_controller_node.core.supervision.late_commands import link_values
from winch_controller_node.interface.readings import Lateness

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
