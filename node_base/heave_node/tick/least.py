"""The least value of a window of wall time, kept as values come."""

from __future__ import annotations

from collections import deque


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
