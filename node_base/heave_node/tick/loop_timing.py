"""Loop age and speed of the run in wall time: for the user to see, never part of a recorded message."""

from __future__ import annotations

import time
from collections import deque

from heave_node.tick.durations import Durations


class LoopTiming:
    """Collects the loop age of every tick, those that missed their deadline too, and measures the speed of the run.

    Attributes
    ----------
    missed_deadlines : ticks that were over before all had answered
    resends : ticks that were sent again
    ages : loop age of every tick that was answered
    """

    def __init__(self) -> None:
        self.missed_deadlines = 0
        self.resends = 0
        self.ages = Durations()
        self._open: deque[tuple[int, float]] = deque()
        self._began = self._run_began = self._last_wall = time.monotonic()
        self._last_simulated = 0.0

    def run_began(self) -> None:
        """Note the start of a run."""
        self._run_began = self._last_wall = time.monotonic()
        self._last_simulated = 0.0
        self._open.clear()

    def wait_began(self) -> None:
        """Note the start of a wait that is not a tick."""
        self._began = time.monotonic()

    def tick_began(self, number: int) -> None:
        """Note the start of tick `number`."""
        self.wait_began()
        self._open.append((number, self._began))

    def answered_up_to(self, number: int) -> None:
        """Note that all have answered tick `number` and those before: their loop age is known, late as it may be."""
        now = time.monotonic()
        while self._open and self._open[0][0] <= number:
            self.ages.add(now - self._open.popleft()[1])

    @property
    def age_of_tick(self) -> float:
        """Wall time since the tick began [s]."""
        return time.monotonic() - self._began

    def loop_age(self, last: int | None = None) -> tuple[float, float, float]:
        """Return p50, p99 and the largest [s] of the loop age over the `last` ticks; None takes all ticks so far.

        A tick that is past its deadline and has no answer yet counts with the time that it has waited.
        """
        now = time.monotonic()
        waiting = tuple(now - began for _, began in list(self._open)[:-1])
        return self.ages.percentiles(last, waiting)

    def overall_factor(self, simulated_time: float) -> float:
        """Return `simulated_time` [s] over wall time since the run began."""
        return simulated_time / max(time.monotonic() - self._run_began, 1e-9)

    def real_time_factor(self, simulated_time: float) -> float:
        """Return simulated over wall time since the last call; `simulated_time` [s] is now."""
        now = time.monotonic()
        elapsed = now - self._last_wall
        advanced = simulated_time - self._last_simulated
        self._last_wall, self._last_simulated = now, simulated_time
        return advanced / elapsed if elapsed > 0.0 else 0.0
