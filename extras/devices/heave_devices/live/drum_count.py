"""The count of a drum goes on: one that jumps has been lost, as by the restart of a PLC, and the drum has not moved.

A drum that runs away is driven by the weight of its load at most: in a time t it gets no further than v t + g t^2 / 2.
"""

from __future__ import annotations

import math

from heave_node.numerics.constants import STANDARD_GRAVITY

from heave_devices.maps.quantities import QUANTITIES

JITTER = 0.2
"""Time by which two readings may have come nearer to each other than they were taken [s]."""
LEAST = 0.05
"""Change of the count that is not reported [m]."""


class DrumCount:
    """Watches one count.

    Attributes
    ----------
    jumps : so far
    words : on the last one; "": none
    """

    def __init__(self) -> None:
        self.jumps = 0
        self.words = ""
        self._last: tuple[float, float, float] | None = None

    def jump(self, now: float, payout: float, rate: float, *, has_restarted: bool) -> float:
        """Return by how much the count has jumped [m]; 0: it goes on.

        Parameters
        ----------
        now : time of the reading, by its own clock or its arrival [s]
        payout, rate : as read [m], [m/s]; of the rate NaN: not known
        has_restarted : the device's own clock restarted since the last reading
        """
        last, self._last = self._last, (now, payout, rate)
        if last is None:
            return 0.0
        elapsed, change = now - last[0], payout - last[1]
        time = elapsed + JITTER
        if has_restarted:  # it stood, or went on for a moment: its clock has stepped, or one of its times was wrong
            time = min(time, JITTER)
        speed = abs(last[2]) if math.isfinite(last[2]) else QUANTITIES["payout_rate"].largest
        allowed = LEAST + speed * time + (0.0 if has_restarted else 0.5 * STANDARD_GRAVITY * time**2)
        if not abs(change) > allowed:
            return 0.0
        self.jumps += 1
        cause = "its clock restarted" if has_restarted else f"no drum does so in {elapsed:.2f} s"
        self.words = f"the drum's count jumped by {change:+.2f} m: {cause}. It is counted on from where the drum was"
        self._last = (now, payout - change, math.nan)
        return change
