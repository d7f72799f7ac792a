"""How far a drum has gone in the last seconds, beside how far it was ordered to go, or says by its speed that it went.

A way is a leaky integral: w' = v - w/leak. It does not restart at a lull of the sea: an error of one half wave counts
in the next. Two ways that belong together may lie apart by a delay and a lag: one is compared with the range of the
other over that time.
"""

from __future__ import annotations

import math
from collections import deque

ALLOWED = 0.05
"""Difference of two ways that is not reported [m]: steps of an encoder, play, an overshoot."""
OVERSHOOT = 0.6
"""A drum may go further than ordered by this share: gain errors and ringing stay below it, three times does not."""
SOONER = 0.3
"""A drum of another gain turns back sooner at its limits: by this share of the way that it is ordered back."""
ORDER_LEAK = 1.0
"""A drum's way beside the ordered one is that of so long [s]."""
SPEED_LEAK = 10.0
"""A drum's way beside that of its own speed is that of so long [s]: a drift of 5 mm/s is found."""
SPEED_LAG = 0.5
"""A drive's speed is at most so much later than its position, or the other way round [s]."""
SPEED_ERROR = 0.2
"""Scale error of a drive's speed that is not reported, a share."""


class Way:
    """A way of the last seconds.

    Parameters
    ----------
    leak : time constant of the leak [s]
    memory : its range is that of so long [s]
    """

    def __init__(self, leak: float, memory: float) -> None:
        self._leak, self._memory = leak, memory
        self._times: deque[float] = deque()
        self._values: deque[float] = deque()

    def add(self, now: float, moved: float) -> None:
        """Add what was `moved` until `now` [m], [s]."""
        since = max(now - self._times[-1], 0.0) if self._times else 0.0
        self._values.append(self.value * math.exp(-since / self._leak) + moved)
        self._times.append(now)
        while now - self._times[0] > self._memory and len(self._times) > 1:
            self._times.popleft()
            self._values.popleft()

    @property
    def value(self) -> float:
        """The way now [m]."""
        return self._values[-1] if self._values else 0.0

    def range(self) -> tuple[float, float]:
        """Return the least and the largest value of the memory [m]."""
        return min(self._values, default=0.0), max(self._values, default=0.0)

    def restart(self) -> None:
        """Begin at 0."""
        self._times.clear()
        self._values.clear()


class OrderedTravel:
    """Finds a drum that goes much further than ordered, or the other way; a sound drive may have so much `lag` [s]."""

    def __init__(self, lag: float) -> None:
        self._moved, self._ordered = Way(ORDER_LEAK, 0.0), Way(ORDER_LEAK, lag)
        self._last: tuple[float, float] | None = None
        self._looks = 0

    def restart(self) -> None:
        """Restart: the drum is braked, or not known."""
        self._moved.restart()
        self._ordered.restart()
        self._last, self._looks = None, 0

    def look(self, now: float, payout: float, ordered_rate: float) -> str:
        """Return what is wrong, in words, with a drum at a `payout` [m] at `now` [s]; "": nothing.

        It was ordered the `ordered_rate` since the last look [m/s].
        """
        if self._last is not None:
            self._moved.add(now, payout - self._last[1])
            self._ordered.add(now, ordered_rate * (now - self._last[0]))
        self._last = (now, payout)
        lowest, highest = self._ordered.range()
        moved = self._moved.value
        ordered, turned = (max(highest, 0.0), lowest) if moved > 0.0 else (max(-lowest, 0.0), highest)
        limit = (1.0 + OVERSHOOT) * ordered + ALLOWED + SOONER * abs(self._ordered.value - turned)
        self._looks = self._looks + 1 if abs(moved) > limit else 0
        if self._looks < 2:  # one reading may be a spike
            return ""
        self._looks = 0
        return _words(moved, ordered, max(highest, -lowest))


def _words(moved: float, ordered: float, largest: float) -> str:
    """Return what a drum does wrong that `moved`, where it was `ordered` to go less that way and `largest` in all."""
    where = "in the quantity and in the command"
    if ordered > 0.5 * largest:
        return f"the drum goes {abs(moved) / ordered:.1f} times as far as commanded: check unit and scale, {where}"
    if largest > 0.0:
        return f"the drum turns against the command: check positive, {where}"
    return f"the drum moves by {moved:+.2f} m without a command to move"


class SpeedTravel:
    """Finds a drum whose position and speed, as reported, contradict each other: one frozen, adrift, or mapped wrong.

    Attributes
    ----------
    words : what is wrong now; "": nothing
    """

    def __init__(self) -> None:
        self._moved, self._turned = Way(SPEED_LEAK, SPEED_LAG), Way(SPEED_LEAK, SPEED_LAG)
        self._last: tuple[float, float, float] | None = None
        self.words = ""

    def restart(self) -> None:
        """Restart: the count was lost, or something is not known."""
        self._moved.restart()
        self._turned.restart()
        self._last, self.words = None, ""

    def look(self, now: float, payout: float, rate: float) -> None:
        """Take a reading of a time `now` [s]: `payout` [m], `rate` [m/s]."""
        last = self._last
        if last is not None and now == last[0]:
            return
        if last is None or not 0.0 < now - last[0] <= SPEED_LAG:
            self.restart()
            self._last = (now, payout, rate)
            return
        self._last = (now, payout, rate)
        self._moved.add(now, payout - last[1])
        self._turned.add(now, 0.5 * (rate + last[2]) * (now - last[0]))
        moved, turned = self._moved.value, self._turned.value
        apart = min(_distance(moved, self._turned.range()), _distance(turned, self._moved.range()))
        largest = max(map(abs, (*self._moved.range(), *self._turned.range())))
        if apart <= ALLOWED + SPEED_ERROR * largest:
            self.words = ""
            return
        self.words = (
            f"payout and payout_rate contradict each other: {moved:+.2f} m by the one, {turned:+.2f} m by the other in "
            f"the last {SPEED_LEAK:g} s. One of them stands still or drifts, or its unit, scale or sign is wrong"
        )


def _distance(value: float, span: tuple[float, float]) -> float:
    return max(span[0] - value, value - span[1], 0.0)
