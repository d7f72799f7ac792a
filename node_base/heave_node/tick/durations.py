"""Durations in wall time, collected one by one: percentiles, and a histogram that fits into a message."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections import deque
from collections.abc import Mapping
from itertools import islice

import numpy as np

EDGES = tuple(round(factor * 10.0**power, 9) for power in range(-4, 2) for factor in (1.0, 2.0, 5.0))
"""Upper edges of the classes of a histogram [s]: 0.1 ms to 50 s; what is longer has a class of its own."""
LAST = "more"
KEPT = 1000
"""Newest durations that are kept one by one."""
SHORTEST, FINE, FINE_CLASSES = 1e-6, 0.01, 2000
"""Upper edge of the first of the fine classes [s], width of each relative to its durations, and their number: the last
one begins at 480 s."""


class Durations:
    """Durations [s], counted in fine classes: what is kept of them, and the time that a look takes, do not grow."""

    def __init__(self) -> None:
        self._newest: deque[float] = deque(maxlen=KEPT)
        self._count, self._largest, self._seen = 0, 0.0, 0
        self._fine = np.zeros(FINE_CLASSES, dtype=np.int64)
        self._classes = [0] * (len(EDGES) + 1)

    def __len__(self) -> int:
        return self._count

    def add(self, value: float) -> None:
        """Take in the duration `value` [s]."""
        self._newest.append(value)
        self._count += 1
        self._largest = max(self._largest, value)
        self._fine[_fine_class(value)] += 1
        self._classes[bisect_left(EDGES, value)] += 1

    def take_new(self) -> list[float]:
        """Return the durations since the last call [s], the newest KEPT at most, newest first."""
        new, self._seen = self._count - self._seen, self._count
        return list(islice(reversed(self._newest), new))

    def percentiles(self, last: int | None = None, more: tuple[float, ...] = ()) -> tuple[float, float, float]:
        """Return p50, p99 and the largest [s]; zeros without any.

        The first two are exact where they are those of the newest KEPT or fewer, and within half of FINE else.

        Parameters
        ----------
        last : number of the newest ones that count, KEPT at most; None: all
        more : that count as well [s]
        """
        if last is None and self._count > KEPT:
            return self._percentiles_of_all(more)
        values = np.array([*(self._newest if last is None else islice(reversed(self._newest), last)), *more])
        if not values.size:
            return 0.0, 0.0, 0.0
        p50, p99 = np.percentile(values, [50, 99])
        return float(p50), float(p99), float(values.max())

    def _percentiles_of_all(self, more: tuple[float, ...]) -> tuple[float, float, float]:
        counts = self._fine.copy()
        for value in more:
            counts[_fine_class(value)] += 1
        up_to = np.cumsum(counts)
        p50, p99 = (SHORTEST * math.exp(FINE * (np.searchsorted(up_to, p * up_to[-1]) - 0.5)) for p in (0.5, 0.99))
        largest = max((self._largest, *more))
        return min(p50, largest), min(p99, largest), largest

    def histogram(self) -> dict[str, int]:
        """Return how many lie in each class that is not empty, by its upper edge in milliseconds."""
        names = [*(f"{1e3 * edge:g}" for edge in EDGES), LAST]
        return {name: count for name, count in zip(names, self._classes, strict=True) if count}

    def words(self) -> str:
        """Return the figures in words."""
        p50, p99, largest = (f"{1e3 * value:.2f}" for value in self.percentiles())
        return f"p50 {p50} ms, p99 {p99} ms, largest {largest} ms"

    def to_values(self) -> dict[str, str]:
        """Return figures and histogram as values of a diagnostic status."""
        p50, p99, largest = self.percentiles()
        return {
            "count": str(len(self)),
            "p50_ms": f"{1e3 * p50:.2f}",
            "p99_ms": f"{1e3 * p99:.2f}",
            "max_ms": f"{1e3 * largest:.2f}",
            "histogram_ms": histogram_text(self.histogram()),
        }


def _fine_class(value: float) -> int:
    """Return the number of the fine class of a `value` [s]."""
    if value <= SHORTEST:
        return 0
    return min(math.ceil(math.log(value / SHORTEST) / FINE), FINE_CLASSES - 1)


def histogram_text(counts: Mapping[str, int]) -> str:
    """Return a histogram, `counts` by upper edge, as text: `upper edge:count`, one after another."""
    return " ".join(f"{edge}:{count}" for edge, count in counts.items())


def parse_histogram(text: str) -> dict[str, int]:
    """Return the histogram that a text gives; anything else is left out."""
    parts = (part.partition(":") for part in text.split())
    return {edge: int(count) for edge, _, count in parts if count.isdigit()}
