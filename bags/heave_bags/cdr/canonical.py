"""Equal messages, equal bytes.

Middleware leaves whatever was in memory in the padding of a message and after it, so that the same message comes
as other bytes each time. Here padding is cleared and the tail cut off, which changes no value.
"""

from __future__ import annotations

from heave_node.cdr.layout import Layout, LayoutError
from heave_node.cdr.patterns import Patterns, picker

from heave_bags.cdr.columns import layouts_in_bag


class _Cleaner:
    """Clears what is not of the message, in messages of one layout."""

    def __init__(self, layout: Layout) -> None:
        self._end = layout.end
        self._gaps = layout.gaps
        self._padding = picker(layout.gaps)
        self._cleared = tuple(bytes(after - first) for first, after in layout.gaps)

    def clean(self, data: bytes) -> bytes:
        """Return the message without what is not of it; itself if there is nothing to do."""
        if self._padding.unpack_from(data) == self._cleared:
            return data if len(data) == self._end else data[: self._end]
        cleaned = bytearray(data[: self._end])
        for first, after in self._gaps:
            cleaned[first:after] = bytes(after - first)
        return bytes(cleaned)


class Canonical:
    """Makes equal messages of the type `name` equal bytes; what does not fit its definition, the `ros2msg` `text`, is
    left as it is.

    Raises BagError for a definition that cannot be.
    """

    def __init__(self, name: str, text: str) -> None:
        self._cleaners = Patterns(layouts_in_bag(name, text), _Cleaner)

    def __call__(self, data: bytes) -> bytes:
        """Return `data` with its padding cleared and its tail cut off."""
        try:
            return self._cleaners.of(data).clean(data)
        except LayoutError:
            return data

    def fits(self, data: bytes) -> bool:
        """Return whether `data` is a message of the type."""
        try:
            self._cleaners.of(data)
        except LayoutError:
            return False
        return True
