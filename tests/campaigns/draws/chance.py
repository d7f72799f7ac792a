"""What chance gives: numbers of a range, by seed and name of a stream."""

from __future__ import annotations

import math
import zlib
from collections.abc import Sequence
from typing import TypeVar

import numpy as np

Item = TypeVar("Item")


class Chance:
    """A stream of random numbers; the same for the same keys on every machine.

    Parameters
    ----------
    keys : whole numbers or words
    """

    def __init__(self, *keys: int | str) -> None:
        self.random = np.random.default_rng([zlib.crc32(key.encode()) if isinstance(key, str) else key for key in keys])

    def between(self, low: float, high: float) -> float:
        """Return a number of an even distribution."""
        return _short(float(self.random.uniform(low, high)))

    def spread(self, low: float, high: float) -> float:
        """Return a number whose logarithm has an even distribution; both limits above 0."""
        return _short(math.exp(float(self.random.uniform(math.log(low), math.log(high)))))

    def beside(self, low: float, high: float, width: float, middle: float = 1.0) -> float:
        """Return a number of an even distribution that is at least a `width` from the `middle`."""
        while True:
            value = self.between(low, high)
            if abs(value - middle) >= width:
                return value

    def happens(self, share: float) -> bool:
        """Return True in a `share` of the calls."""
        return bool(self.random.random() < share)

    def sign(self) -> float:
        """Return 1 or -1."""
        return 1.0 if self.happens(0.5) else -1.0

    def one_of(self, items: Sequence[Item], weights: Sequence[float] | None = None) -> Item:
        """Return one of the `items`, each as often as its weight says; without weights, all alike."""
        shares = None if weights is None else np.array(weights) / sum(weights)
        return items[int(self.random.choice(len(items), p=shares))]

    def number(self, low: int, high: int) -> int:
        """Return a whole number, both limits included."""
        return int(self.random.integers(low, high + 1))


def _short(value: float) -> float:
    """Return a number that can be read: six digits."""
    return float(f"{value:.6g}")
