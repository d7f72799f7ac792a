"""Equal messages, equal bytes.

Middleware leaves whatever was in memory in the padding of a message and behind it, so that the same message comes
as other bytes each time.
Here padding is cleared and the tail cut off, which changes no value.
"""

from __future__ import annotations

import struct

from heave_bags.cdr.layout import Layout, MessageLayouts
from heave_bags.errors import BagError

_MOST_PATTERNS = 64


class _Pattern:
    """The messages of one size whose length words agree: how to recognise one, and what to clear in it."""

    def __init__(self, layout: Layout) -> None:
        self.end = layout.end
        self._gaps = layout.gaps
        self._lengths = _picker([(offset, offset + 4) for offset, _ in layout.lengths])
        self._expected = tuple(value.to_bytes(4, "little") for _, value in layout.lengths)
        self._padding = _picker(layout.gaps)
        self._cleared = tuple(bytes(after - first) for first, after in layout.gaps)

    def fits(self, data: bytes) -> bool:
        """Tell whether a message of the right size has this layout."""
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
    """Makes equal messages of one type equal bytes; what does not fit the definition is left as it is."""

    def __init__(self, name: str, text: str) -> None:
        self._layouts = MessageLayouts(name, text)
        self._patterns: dict[int, list[_Pattern]] = {}

    def __call__(self, data: bytes) -> bytes:
        """Return `data` with its padding cleared and its tail cut off."""
        patterns = self._patterns.get(len(data), ())
        for pattern in patterns:
            if pattern.fits(data):
                return pattern.clean(data)
        try:
            pattern = _Pattern(self._layouts.of(data))
        except BagError:
            return data
        known = self._patterns.setdefault(len(data), [])
        if len(known) >= _MOST_PATTERNS:
            known.pop()
        known.insert(0, pattern)
        return pattern.clean(data)
