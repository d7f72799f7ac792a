"""News of the authority of compensation: what limits it, where that lasts, and that it is over."""

from __future__ import annotations

from heave_node.interface.alarm import Alarm

from winch_controller_node.interface.alarms import ALARMS

HELD_TIME, REPORTED_AGAIN = 5.0, 60.0
"""Limited authority is reported once it has lasted for the first time [s], and again after the second; its end, once
that has lasted for the first time.
"""


class ShareNews:
    """Reports what limits compensation, at most once a minute, and once that it is over.

    Parameters
    ----------
    tick_period : [s]
    """

    def __init__(self, tick_period: float) -> None:
        self._dt = tick_period
        self._held_time = self._free_time = 0.0
        self._is_reported = False

    def update(
        self, share: float, cause: str, *, residual: float, authority: float, factor: float, compensates: bool
    ) -> Alarm | None:
        """Return what is to be reported in this tick; None: nothing.

        Parameters
        ----------
        share : largest authority allowed, 0 to 1
        cause : why it is no larger, in words
        residual : motion that it is predicted to leave, over that with the winch locked
        authority, factor : share that is compensated, and the largest that is asked for: that is all
        compensates : the mode is that of compensation
        """
        is_held = share < 1.0 and compensates
        self._held_time = self._held_time + self._dt if is_held else min(self._held_time + self._dt, 0.0)
        if self._held_time >= HELD_TIME:
            self._held_time, self._is_reported = -REPORTED_AGAIN, True
            return ALARMS.alarm("AUTHORITY_LIMITED", percent=100.0 * share, cause=cause, rest=100.0 * residual)
        # whatever ends compensation is reported with its mode
        self._is_reported = self._is_reported and compensates
        self._free_time = self._free_time + self._dt if self._is_reported and not is_held else 0.0
        if self._free_time < HELD_TIME or authority < factor:
            return None
        self._is_reported = False
        return ALARMS.alarm("AUTHORITY_RESTORED", percent=100.0 * authority)
