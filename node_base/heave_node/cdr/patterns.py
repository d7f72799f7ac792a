"""Patterns of messages: those of one size whose length words agree have one layout, which is worked out once."""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

from heave_node.cdr.layout import LITTLE_ENDIAN, Layout, MessageLayouts

_MOST_PATTERNS = 64
"""Patterns kept of one size of message."""
_MOST_KEPT = 1 << 18
"""Lengths and gaps kept in all patterns."""

Made = TypeVar("Made")


def picker(spans: Sequence[tuple[int, int]]) -> struct.Struct:
    """Return what picks the bytes of `spans`, ascending (first byte, and the one after the last), in one step."""
    position, form = 0, "<"
    for first, after in spans:
        form += f"{first - position}x{after - first}s"
        position = after
    return struct.Struct(form)


class _Pattern(Generic[Made]):
    """How to recognise the messages of a layout among those of its size, and its compiled form.

    Attributes
    ----------
    pick : takes byte order and length words out of a message
    expected : what it finds in one of this layout
    made : of the layout
    size : lengths and gaps that are kept
    """

    def __init__(self, layout: Layout, made: Made) -> None:
        order = LITTLE_ENDIAN[:2]
        self.pick = picker([(0, len(order)), *((offset, offset + 4) for offset, _ in layout.lengths)]).unpack_from
        self.expected = (order, *(value.to_bytes(4, "little") for _, value in layout.lengths))
        self.made = made
        self.size = 1 + len(layout.gaps) + len(layout.lengths)


class Patterns(Generic[Made]):
    """What is made of each layout that messages of one type have.

    Parameters
    ----------
    layouts : of the type
    make : makes of a layout what `of` returns for its messages
    """

    def __init__(self, layouts: MessageLayouts, make: Callable[[Layout], Made]) -> None:
        self._layouts = layouts
        self._make = make
        self._patterns: dict[int, list[_Pattern[Made]]] = {}
        self._kept = 0

    def of(self, data: bytes) -> Made:
        """Return what was made of the layout of the message `data`. Raises LayoutError if it does not fit the type."""
        for pattern in self._patterns.get(len(data), ()):
            if pattern.pick(data) == pattern.expected:
                return pattern.made
        layout = self._layouts.of(data)
        return self._keep(len(data), _Pattern(layout, self._make(layout))).made

    def _keep(self, size: int, found: _Pattern[Made]) -> _Pattern[Made]:
        if self._kept > _MOST_KEPT:  # messages that never come again must not fill the memory
            self._patterns.clear()
            self._kept = 0
        known = self._patterns.setdefault(size, [])
        if len(known) >= _MOST_PATTERNS:
            known.pop()
        known.insert(0, found)
        self._kept += found.size
        return found
