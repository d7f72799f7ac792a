"""News of the share of the sea that is compensated: what holds it back, where that lasts, and that it is over."""

from __future__ import annotations

HELD_TIME, TOLD_AGAIN = 5.0, 60.0
"""What holds a part of the sea back is told when it has lasted so long [s], and again when so much later; that it is
over, when that has lasted as long.
"""


class ShareNews:
    """Tells what holds compensation back, at most once a minute, and once that it is over.

    Parameters
    ----------
    tick_period : [s]
    """

    def __init__(self, tick_period: float) -> None:
        self._dt = tick_period
        self._held_time = self._free_time = 0.0
        self._is_told = False

    def update(self, share: float, cause: str, *, authority: float, factor: float, compensates: bool) -> str:
        """Return what is to be told in this tick; empty: nothing.

        Parameters
        ----------
        share : largest share of the sea that may be compensated, 0 to 1
        cause : why it is no larger, in words
        authority, factor : share that is compensated, and the largest that is asked for: that is all
        compensates : the mode is that of compensation
        """
        is_held = share < 1.0 and compensates
        self._held_time = self._held_time + self._dt if is_held else min(self._held_time + self._dt, 0.0)
        if self._held_time >= HELD_TIME:
            self._held_time, self._is_told = -TOLD_AGAIN, True
            return f"only {100.0 * share:.0f} % of the sea is compensated: {cause}"
        # whatever ends compensation is told by its mode
        self._is_told = self._is_told and compensates
        self._free_time = self._free_time + self._dt if self._is_told and not is_held else 0.0
        if self._free_time < HELD_TIME or authority < factor:
            return ""
        self._is_told = False
        return f"{100.0 * authority:.0f} % of the sea is compensated again: what held it back is over"
