"""Simulated time between ticks, as the wall clock carries it on.

In real time the master begins tick k when k periods of wall time have passed, or later where the machine is busy, and
then catches up: never earlier. So of the last ticks the one that began with the least delay gives the time; one
that was late would put the clock back for as long as it is the newest.
"""

from __future__ import annotations

from collections import deque

_SECOND = 1_000_000_000
WINDOW = 2 * _SECOND
"""Wall time for which a tick counts [ns]; after a pause the clock is right again when it has passed."""
LONGEST_LEAD = _SECOND
"""The clock goes no further ahead of the newest tick [ns]: then the run is paused."""


class Least:
    """The least of the values that came within a `length` of wall time [ns] before the newest."""

    def __init__(self, length: int) -> None:
        self._length = length
        self._rising: deque[tuple[int, int]] = deque()  # each is less than all that came after it

    def add(self, wall: int, value: int) -> None:
        """Take a `value` in that came at a `wall` time [ns]."""
        while self._rising and self._rising[-1][1] >= value:
            self._rising.pop()
        self._rising.append((wall, value))
        while self._rising[0][0] < wall - self._length:
            self._rising.popleft()

    @property
    def value(self) -> int:
        """The least value; 0 where none has come."""
        return self._rising[0][1] if self._rising else 0

    @property
    def is_empty(self) -> bool:
        """Tell whether no value has come."""
        return not self._rising


class SimulatedClock:
    """The simulated time now, by when the last ticks began."""

    def __init__(self) -> None:
        self._newest, self._lags = 0, Least(WINDOW)

    def tick_began(self, start: int, wall: int) -> None:
        """Take a tick that begins at simulated time `start`, as seen at `wall` time [ns]."""
        if start < self._newest:  # another run
            self._lags = Least(WINDOW)
        self._newest = start
        self._lags.add(wall, wall - start)

    def now(self, wall: int) -> int:
        """Return the simulated time at `wall` time [ns]; 0 before the first tick."""
        if self._lags.is_empty:
            return 0
        return min(wall - self._lags.value, self._newest + LONGEST_LEAD)
