"""Who was late: the clock master with the beginning of ticks, or this node with its part of them. Wall time, no ROS."""

from __future__ import annotations

from collections import deque

RECENT, REMEMBERED = 3_000_000_000, 10_000_000_000
"""Wall time for which a delay is reported, and over which the least one counts as none [ns]."""

_SECOND = 1e9


class Punctuality:
    """How late ticks began, and how late this node entered them.

    A tick begins in simulated time, is sent by the master's clock and is entered by this node's: only differences of
    each count, so that the clocks need not agree.
    """

    def __init__(self) -> None:
        self._newest = 0
        self._delays: deque[tuple[int, int, int]] = deque()

    def entered(self, start: int, sent: int, wall: int) -> None:
        """Take in a tick that this node enters.

        Parameters
        ----------
        start : of the tick, simulated time [ns]
        sent : when the master sent it, by its clock [ns]; 0: the middleware does not tell
        wall : now, by this node's clock [ns]
        """
        if start < self._newest:  # another run
            self._delays.clear()
        self._newest = start
        while self._delays and self._delays[0][0] < wall - REMEMBERED:
            self._delays.popleft()
        sent = sent or wall
        self._delays.append((wall, sent - start, wall - sent))

    @property
    def of_clock(self) -> float:
        """Time by which ticks of the last seconds began late [s]: the machine stalled, or the master."""
        return self._largest(1)

    @property
    def of_node(self) -> float:
        """Time by which this node entered ticks of the last seconds late, after they had begun [s]."""
        return self._largest(2)

    @property
    def newest_of_node(self) -> float:
        """Time by which this node entered the newest tick late, after it had begun [s]."""
        return (self._delays[-1][2] - min(delays[2] for delays in self._delays)) / _SECOND if self._delays else 0.0

    def _largest(self, column: int) -> float:
        if not self._delays:
            return 0.0
        since = self._delays[-1][0] - RECENT
        least = min(delays[column] for delays in self._delays)
        return (max(delays[column] for delays in self._delays if delays[0] >= since) - least) / _SECOND
