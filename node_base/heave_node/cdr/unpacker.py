"""Takes numbers out of serialised messages, without making a message object of them."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator, Sequence
from operator import itemgetter
from typing import Any

import numpy as np

from heave_node.cdr.definitions import schema_text
from heave_node.cdr.layout import STRUCT_CODES, Layout, LayoutError, MessageLayouts
from heave_node.cdr.patterns import Patterns

_STAMP = struct.Struct("<iI")
_STAMP_OFFSET = 4


def header_stamp(data: bytes) -> int:
    """Return the header stamp of the serialised message `data`, which begins with a Header [ns]."""
    seconds, nanoseconds = _STAMP.unpack_from(data, _STAMP_OFFSET)
    return int(seconds) * 1_000_000_000 + int(nanoseconds)


class Unpacker:
    """Unpacks the numbers of certain fields of messages of one type.

    Parameters
    ----------
    name : of the type, `package/msg/Type`
    fields : dotted names of fields, such as `twist.covariance[7]`; of a structure or an array all its numbers are
        taken, in the order of the definition

    Raises ValueError for a field that the type does not have, DefinitionError for a type that is not installed.
    """

    def __init__(self, name: str, fields: Sequence[str]) -> None:
        self._name = name
        self._fields = tuple(fields)
        layouts = MessageLayouts(name, schema_text(name))
        for field in fields:
            if not layouts.has_field(field):
                raise ValueError(f"{name} has no field {field}")
        self._patterns: Patterns[Callable[[bytes], tuple[Any, ...]]] = Patterns(layouts, self._make)

    def unpack(self, data: bytes) -> tuple[Any, ...]:
        """Return the numbers of the fields in the message `data`, those of one field after those of another.

        Raises LayoutError for a message that does not fit the definition or is not little-endian, and for a field
        that is a text.
        """
        return self._patterns.of(data)(data)

    def _make(self, layout: Layout) -> Callable[[bytes], tuple[Any, ...]]:
        """Return what unpacks the messages of a `layout`."""
        places = [place for field in self._fields for place in self._places(layout, field)]
        position, form = 0, "<"
        for offset, code, size in sorted(places):
            form += f"{offset - position}x{code}"
            position = offset + size
        take = struct.Struct(form).unpack_from
        order = [sorted(places).index(place) for place in places]
        if order == list(range(len(order))):
            return take
        pick = itemgetter(*order)
        return lambda data: pick(take(data))

    def _places(self, layout: Layout, field: str) -> Iterator[tuple[int, str, int]]:
        """Yield offset, code and size of each number of a `field`."""
        path, _, index = field.partition("[")
        inside = (f"{field}.", f"{field}[")
        leaves = [leaf for leaf in layout.leaves if leaf.name == path or leaf.name.startswith(inside)]
        if not all(leaf.dtype for leaf in leaves):
            raise LayoutError(f"{field} of {self._name} is no number")
        for leaf in leaves:
            size = np.dtype(leaf.dtype).itemsize
            numbers = range(1 if leaf.count is None else leaf.count)
            for number in [int(index.rstrip("]"))] if index else numbers:
                yield leaf.offset + number * size, STRUCT_CODES[leaf.dtype], size
