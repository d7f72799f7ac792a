"""Equal messages, equal bytes.

Middleware leaves whatever was in memory in the padding of a message and after it, so that the same message comes
as other bytes each time. Here padding is cleared and the tail cut off, which changes no value.
"""

from __future__ import annotations

import struct

from heave_bags.cdr.layout import Layout, MessageLayouts
from heave_bags.errors import BagError

_MOST_PATTERNS = 64
"""Patterns kept of one size of message."""
_MOST_KEPT = 1 << 18
"""Lengths and gaps kept in all patterns."""


class _Pattern:
    """The messages of one size whose length words agree: how to recognise one, and what to clear in it."""

    def __init__(self, layout: Layout) -> None:
        self.end = layout.end
        self.size = 1 + len(layout.gaps) + len(layout.lengths)
        self._gaps = layout.gaps
        self._lengths = _picker([(offset, offset + 4) for offset, _ in layout.lengths])
        self._expected = tuple(value.to_bytes(4, "little") for _, value in layout.lengths)
        self._padding = _picker(layout.gaps)
        self._cleared = tuple(bytes(after - first) for first, after in layout.gaps)

    def fits(self, data: bytes) -> bool:
        """Return whether a message of the right size has this layout."""
        return self._lengths.unpack_from(data) == self._expected

    def clean(self, data: bytes) -> bytes:
        """Return the message without what is not of it; itself if there is nothing to do."""
        if self._padding.unpack_from(data) == self._cleared:
            return data if len(data) == self.end else data[: self.end]
        cleaned = bytearray(data[: self.end])
        for first, after in self._gaps:
            cleaned[first:after] = bytes(after - first)
        return bytes(cleaned)


def _picker(spans: list[tuple[int, int]]) -> struct.Struct:
    """Return what picks the bytes of `spans` out of a message in one step."""
    position, form = 0, "<"
    for first, after in spans:
        form += f"{first - position}x{after - first}s"
        position = after
    return struct.Struct(form)


class Canonical:
    """Makes equal messages of one type equal bytes; what does not fit the definition is left as it is.

    Parameters
    ----------
    name : of the type, `package/msg/Type`
    text : its definition, `ros2msg`
    """

    def __init__(self, name: str, text: str) -> None:
        self._layouts = MessageLayouts(name, text)
        self._patterns: dict[int, list[_Pattern]] = {}
        self._kept = 0

    def __call__(self, data: bytes) -> bytes:
        """Return `data` with its padding cleared and its tail cut off."""
        pattern = self._pattern(data)
        return data if pattern is None else pattern.clean(data)

    def fits(self, data: bytes) -> bool:
        """Return whether `data` is a message of the type."""
        return self._pattern(data) is not None

    def _pattern(self, data: bytes) -> _Pattern | None:
        for pattern in self._patterns.get(len(data), ()):
            if pattern.fits(data):
                return pattern
        try:
            found = _Pattern(self._layouts.of(data))
        except BagError:
            return None
        if self._kept > _MOST_KEPT:  # messages that never come again must not fill the memory
            self._patterns.clear()
            self._kept = 0
        known = self._patterns.setdefault(len(data), [])
        if len(known) >= _MOST_PATTERNS:
            known.pop()
        known.insert(0, found)
        self._kept += found.size
        return found
