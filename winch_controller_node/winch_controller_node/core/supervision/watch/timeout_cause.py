"""Who was silent when the winch stopped because no command came in time: the cause, not what followed from it."""

from __future__ import annotations

from winch_controller_node.interface.readings import Lateness

NOTABLE = 0.2
"""Delay that may be a cause [s]; watchdogs of winches are longer."""

MEMORY = 3.0
"""Time for which a silence of the winch is a cause [s]."""


class TimeoutCause:
    """Says why commands did not reach the winch in time.

    Parameters
    ----------
    tick_period : [s]
    """

    def __init__(self, tick_period: float) -> None:
        self._dt = tick_period
        self._since_state = 0.0
        self._silence, self._since_silence = 0.0, 0.0
        self._untaken = 0.0

    def update(self, *, has_state: bool, untaken: float) -> None:
        """Take in a tick.

        Parameters
        ----------
        has_state : a state of the winch came
        untaken : time for which commands should have been in effect and were not [s]; not looked at without a
            state
        """
        self._since_state += self._dt
        self._since_silence += self._dt
        if self._since_state >= self._silence or self._since_silence > MEMORY:
            self._silence, self._since_silence = self._since_state, 0.0
        if has_state:
            self._since_state = 0.0
            self._untaken = untaken

    def words(self, lateness: Lateness) -> str:
        """Return the cause in words, with the `lateness` of the ticks; empty where it is not known."""
        causes = {
            "the controller was delayed, its commands came {:.2f} s late": lateness.of_controller,
            "ticks began {:.2f} s late, the machine or the clock master stalled": lateness.of_clock,
            "no data from the winch for {:.2f} s": self._silence - self._dt,
        }
        text, delay = max(causes.items(), key=lambda cause: cause[1])
        if delay > NOTABLE:
            return text.format(delay)
        if self._untaken > NOTABLE:
            return f"commands were sent in time, and the winch took none for {self._untaken:.2f} s"
        return ""
