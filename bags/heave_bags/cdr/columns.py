"""Serialised ROS 2 messages to columns: many messages of one type at once, by numpy, from the definition a bag
carries.

Where strings and sequences of two messages have the same lengths, their bytes have the same layout. So the layout is
worked out once for each pattern of lengths, and the values of all messages of that pattern are picked in one step.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
from heave_node.cdr.layout import Layout, LayoutError, Leaf, MessageLayouts
from numpy.typing import NDArray

from heave_bags.errors import BagError


@contextmanager
def as_bag_error() -> Iterator[None]:
    """Turn a LayoutError into a BagError."""
    try:
        yield
    except LayoutError as error:
        raise BagError(str(error)) from error


def layouts_in_bag(name: str, text: str) -> MessageLayouts:
    """Return the layouts of the type `name` by its `ros2msg` schema `text`.

    Raises BagError for a schema that cannot be.
    """
    with as_bag_error():
        return MessageLayouts(name, text)


_MOST_KEPT = 1 << 18
"""Values and lengths kept in the layouts of one type."""
_MOST_CELLS = 1 << 24
_MOST_PADDING = 8
"""Cells of columns padded to equal length: so many, or so many times those that hold a value."""

Columns = dict[str, NDArray[Any]]


class ColumnDecoder:
    """Decodes messages of one type into columns named by dotted paths, such as `pose.pose.position.z`.

    Array elements of structures are `nodes[0].x`; an array of numbers is one column of shape (n, elements).

    Parameters
    ----------
    name, text : the type and its `ros2msg` schema
    wanted : which paths to decode; all if None
    longest : arrays and texts of more elements are left out; None takes all

    Raises BagError for a definition that cannot be.
    """

    def __init__(
        self, name: str, text: str, wanted: Callable[[str], bool] | None = None, longest: int | None = None
    ) -> None:
        self._types = layouts_in_bag(name, text)
        self._wanted = wanted
        self._longest = longest
        self._layouts: dict[int, list[Layout]] = {}
        self._kept = 0

    @property
    def has_header(self) -> bool:
        """The type begins with a std_msgs/Header."""
        return self._types.has_header

    def fits(self, data: bytes) -> bool:
        """Return whether the message `data` fits the definition."""
        try:
            self._types.of(data)
        except LayoutError:
            return False
        return True

    def decode(self, messages: Sequence[bytes]) -> Columns:
        """Return the columns of `messages`, n rows each; what a message does not have is NaN or "".

        Raises BagError for a message that does not fit the definition.
        """
        by_size: dict[int, list[int]] = {}
        for row, data in enumerate(messages):
            by_size.setdefault(len(data), []).append(row)
        gathered: list[tuple[NDArray[np.intp], Columns]] = []
        for size, rows in by_size.items():
            block = np.frombuffer(b"".join([messages[row] for row in rows]), dtype=np.uint8).reshape(len(rows), size)
            self._groups(block, np.asarray(rows), gathered)
        if len(gathered) == 1:
            return gathered[0][1]
        return _merge(gathered, len(messages))

    def _groups(
        self, block: NDArray[np.uint8], rows: NDArray[np.intp], gathered: list[tuple[NDArray[np.intp], Columns]]
    ) -> None:
        """Split rows of one size by layout, and decode each group."""
        for layout in self._layouts.get(block.shape[1], ()):
            block, rows = self._gather(layout, block, rows, gathered)
        while rows.size:
            layout = self._layout(block[0].tobytes())
            self._keep(block.shape[1], layout)
            block, rows = self._gather(layout, block, rows, gathered)

    def _keep(self, size: int, layout: Layout) -> None:
        """Keep the layout of messages of a size for the next; in a bounded number, since lengths may never recur."""
        self._kept += 1 + len(layout.leaves) + len(layout.lengths)
        if self._kept > _MOST_KEPT:
            self._layouts.clear()
            self._kept = 0
        known = self._layouts.setdefault(size, [])
        if len(known) < 64:
            known.append(layout)

    def _gather(
        self,
        layout: Layout,
        block: NDArray[np.uint8],
        rows: NDArray[np.intp],
        gathered: list[tuple[NDArray[np.intp], Columns]],
    ) -> tuple[NDArray[np.uint8], NDArray[np.intp]]:
        """Decode the rows that have this layout; return the others."""
        if not rows.size:
            return block, rows
        fits = np.ones(rows.size, dtype=bool)
        for offset, value in layout.lengths:
            fits &= _words(block, offset) == value
        if not fits.any():
            return block, rows
        whole = bool(fits.all())
        matching = block if whole else block[fits]
        gathered.append((rows[fits], {leaf.name: _column(matching, leaf) for leaf in layout.leaves}))
        return block[~fits], rows[~fits]

    def _layout(self, data: bytes) -> Layout:
        with as_bag_error():
            layout = self._types.of(data)
        layout.leaves = [leaf for leaf in layout.leaves if self._is_wanted(leaf)]
        return layout

    def _is_wanted(self, leaf: Leaf) -> bool:
        is_short = self._longest is None or (leaf.count or 0) <= self._longest
        return is_short and (self._wanted is None or self._wanted(leaf.name))


def _words(block: NDArray[np.uint8], offset: int) -> NDArray[np.uint32]:
    return np.ascontiguousarray(block[:, offset : offset + 4]).view("<u4")[:, 0]


def _column(block: NDArray[np.uint8], leaf: Leaf) -> NDArray[Any]:
    if not leaf.dtype:
        length = max((leaf.count or 0) - 1, 0)
        if not length:
            return np.full(block.shape[0], "", dtype=object)
        texts = np.ascontiguousarray(block[:, leaf.offset : leaf.offset + length]).view(f"S{length}")[:, 0]
        unique, inverse = np.unique(texts, return_inverse=True)
        decoded = np.array([text.decode("utf-8", "replace") for text in unique], dtype=object)
        return decoded[inverse]
    dtype = np.dtype("<" + leaf.dtype)
    count = 1 if leaf.count is None else leaf.count
    if not count:
        return np.empty((block.shape[0], 0), dtype=dtype)
    values = np.ascontiguousarray(block[:, leaf.offset : leaf.offset + count * dtype.itemsize]).view(dtype)
    return values[:, 0] if leaf.count is None else values


def _blank(rows: int, example: NDArray[Any], width: int) -> NDArray[Any]:
    shape = (rows,) if example.ndim == 1 else (rows, width)
    if example.dtype == object:
        return np.full(shape, "", dtype=object)
    return np.full(shape, np.nan)


def _merge(gathered: Sequence[tuple[NDArray[np.intp], Columns]], rows: int) -> Columns:
    """Put groups of rows together; columns or elements that a group lacks are NaN or "".

    Raises BagError where that would take many times the room of the values.
    """
    names = dict.fromkeys(name for _, columns in gathered for name in columns)
    widest = [max(columns[name][:1].size for _, columns in gathered if name in columns) for name in names]
    cells = rows * sum(widest)
    filled = sum(column.size for _, columns in gathered for column in columns.values())
    if cells > max(_MOST_CELLS, _MOST_PADDING * filled):
        raise BagError(f"{rows} messages differ too much in length to be held in columns ({cells} cells)")
    merged: Columns = {}
    for name in names:
        parts = [(index, columns[name]) for index, columns in gathered if name in columns]
        widths = [part.shape[1] if part.ndim > 1 else 0 for _, part in parts]
        example = parts[0][1]
        if sum(index.size for index, _ in parts) == rows and len(set(widths)) == 1:
            column = np.empty((rows, *example.shape[1:]), dtype=example.dtype)
        else:
            column = _blank(rows, example, max(widths))
        for (index, part), width in zip(parts, widths, strict=True):
            if part.ndim == 1:
                column[index] = part
            else:
                column[index, :width] = part
        merged[name] = column
    return merged


def join(batches: Sequence[tuple[int, Columns]]) -> Columns:
    """Concatenate batches (rows, columns)."""
    gathered = []
    first = 0
    for rows, columns in batches:
        gathered.append((np.arange(first, first + rows), columns))
        first += rows
    return gathered[0][1] if len(gathered) == 1 else _merge(gathered, first)
