"""Loop age and speed of the run in wall time: for the user to see, never part of a recorded message."""

from __future__ import annotations

import time
from array import array
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class LoopAge:
    """Wall time from the start of a tick to its last answer.

    Attributes
    ----------
    p50, p99, max : median, 99th percentile and largest [s]
    """

    p50: float = 0.0
    p99: float = 0.0
    max: float = 0.0


class LoopTiming:
    """Collects the loop age of every tick, and measures the speed of the run."""

    def __init__(self) -> None:
        self.missed_deadlines = 0
        self.resends = 0
        self._ages = array("d")
        self._began = self._run_began = self._last_wall = time.monotonic()
        self._last_simulated = 0.0

    def run_began(self) -> None:
        """Note the start of a run."""
        self._run_began = self._last_wall = time.monotonic()
        self._last_simulated = 0.0

    def tick_began(self) -> None:
        """Note the start of a tick."""
        self._began = time.monotonic()

    def tick_answered(self) -> None:
        """Note the last answer to the tick."""
        self._ages.append(time.monotonic() - self._began)

    @property
    def age_of_tick(self) -> float:
        """Wall time since the tick began [s]."""
        return time.monotonic() - self._began

    def loop_age(self, last: int | None = None) -> LoopAge:
        """Return the loop age over the `last` ticks; None takes all ticks so far."""
        if not self._ages:
            return LoopAge()
        ages = np.array(self._ages if last is None else self._ages[-last:])
        p50, p99 = np.percentile(ages, [50, 99])
        return LoopAge(float(p50), float(p99), float(ages.max()))

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
