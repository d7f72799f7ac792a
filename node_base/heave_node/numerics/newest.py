"""The newest values of a signal as one array."""

from __future__ import annotations

import numpy as np

from heave_node.numerics.arrays import Array


class Newest:
    """The newest values, in the order in which they came.

    Parameters
    ----------
    length : number of values that are kept
    """

    def __init__(self, length: int) -> None:
        self._length = length
        # they wander along a longer array and are moved back at its end, seldom
        self._array: Array = np.empty(2 * length)
        self._end = self._count = 0

    def __len__(self) -> int:
        return self._count

    def append(self, value: float) -> None:
        """Take in a `value`; the oldest goes where all are there."""
        if self._end == self._array.size:
            self._array[: self._length] = self._array[self._length :]
            self._end = self._length
        self._array[self._end] = value
        self._end += 1
        self._count = min(self._count + 1, self._length)

    def clear(self) -> None:
        """Discard all of them."""
        self._end = self._count = 0

    def last(self, count: int | None = None) -> Array:
        """Return the newest `count` of them, or as many as there are; None: all. It holds until the next one comes."""
        count = self._count if count is None else min(count, self._count)
        return self._array[self._end - count : self._end]
