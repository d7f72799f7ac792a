"""Who was late: the clock master with the beginning of ticks, or this node with its part of them. Wall time, no ROS."""

from __future__ import annotations

from heave_node.tick.simulated_clock import Least

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
        self._clock, self._node = _Delay(), _Delay()

    def entered(self, start: int, sent: int, wall: int) -> None:
        """Take in a tick that this node enters.

        Parameters
        ----------
        start : of the tick, simulated time [ns]
        sent : when the master sent it, by its clock [ns]; 0: the middleware does not tell
        wall : now, by this node's clock [ns]
        """
        if start < self._newest:  # another run
            self._clock, self._node = _Delay(), _Delay()
        self._newest = start
        sent = sent or wall
        self._clock.add(wall, sent - start)
        self._node.add(wall, wall - sent)

    @property
    def of_clock(self) -> float:
        """Time by which ticks of the last seconds began late [s]: the machine stalled, or the master."""
        return self._clock.largest / _SECOND

    @property
    def of_node(self) -> float:
        """Time by which this node entered ticks of the last seconds late, after they had begun [s]."""
        return self._node.largest / _SECOND

    @property
    def newest_of_node(self) -> float:
        """Time by which this node entered the newest tick late, after it had begun [s]."""
        return self._node.newest / _SECOND


class _Delay:
    """A delay beside the least one that is remembered, which counts as none [ns]."""

    def __init__(self) -> None:
        self._least, self._most = Least(REMEMBERED), Least(RECENT)  # the latter of delays times -1
        self._newest = 0

    def add(self, wall: int, delay: int) -> None:
        self._least.add(wall, delay)
        self._most.add(wall, -delay)
        self._newest = delay

    @property
    def newest(self) -> int:
        return self._newest - self._least.value

    @property
    def largest(self) -> int:
        return -self._most.value - self._least.value
