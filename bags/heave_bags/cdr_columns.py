"""Serialised ROS 2 messages to columns: many messages of one type at once, by numpy, from the definition a bag
carries.

Where strings and sequences of two messages have the same lengths, their bytes are laid out alike. So the layout is
worked out once for each
pattern of lengths, and the values of all messages of that pattern are picked in one step.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heave_bags.definitions import PRIMITIVES, SEPARATOR
from heave_bags.errors import BagError

NUMPY_TYPES = {
    "bool": "?",
    "byte": "u1",
    "char": "u1",
    "uint8": "u1",
    "int8": "i1",
    "uint16": "u2",
    "int16": "i2",
    "uint32": "u4",
    "int32": "i4",
    "uint64": "u8",
    "int64": "i8",
    "float32": "f4",
    "float64": "f8",
}

_ENCAPSULATION = 4
"""Bytes before the message proper; alignment counts from behind them."""

_FIELD = re.compile(
    r"^(?P<type>[A-Za-z][\w/]*)(?:<=\d+)?(?P<array>\[(?:<=)?\d*\])?\s+(?P<name>[A-Za-z]\w*)\s*(?P<rest>.*)$"
)


@dataclass(frozen=True)
class Field:
    """One field of a message definition. `count` is the length of a fixed array; -1 is a sequence, None a single
    value.
    """

    name: str
    type: str
    count: int | None


@dataclass(frozen=True)
class Leaf:
    """Where one primitive value, array or text lies in a message: byte offset, numpy type ("" for a text), elements."""

    name: str
    offset: int
    dtype: str
    count: int | None


@dataclass
class Layout:
    """The layout of all messages whose length words agree with `lengths` (offset, value)."""

    leaves: list[Leaf] = field(default_factory=list)
    lengths: list[tuple[int, int]] = field(default_factory=list)


def parse_schema(name: str, text: str) -> dict[str, list[Field]]:
    """Return the fields of each type in a `ros2msg` schema, keyed `package/Type`; the first is that of `name`."""
    parts = name.split("/")
    key = f"{parts[0]}/{parts[-1]}"
    types: dict[str, list[Field]] = {}
    for part in text.split(SEPARATOR):
        lines = part.splitlines()
        heading = next((line for line in lines if line.strip()), "")
        if heading.startswith("MSG:"):
            key = heading[4:].strip()
            parts = key.split("/")
            key = f"{parts[0]}/{parts[-1]}"
            lines = lines[lines.index(heading) + 1 :]
        types[key] = list(_fields(lines, key.split("/")[0]))
    for built_in in ("builtin_interfaces/Time", "builtin_interfaces/Duration"):
        types.setdefault(built_in, [Field("sec", "int32", None), Field("nanosec", "uint32", None)])
    return types


def _fields(lines: Sequence[str], package: str) -> Iterator[Field]:
    for line in lines:
        match = _FIELD.match(line.split("#", 1)[0].strip())
        if not match or match["rest"].startswith("="):
            continue
        kind, array = match["type"], match["array"]
        if kind not in PRIMITIVES:
            parts = kind.split("/")
            kind = f"{parts[0] if len(parts) > 1 else package}/{parts[-1]}"
        count = None if not array else int(array[1:-1]) if array[1:-1].isdigit() else -1
        yield Field(match["name"], kind, count)


class _Walker:
    """Walks one message and notes where its values lie."""

    def __init__(self, types: dict[str, list[Field]], data: bytes) -> None:
        self._types = types
        self._data = data
        self._position = _ENCAPSULATION
        self.layout = Layout()

    def struct(self, name: str, prefix: str) -> None:
        fields = self._types[name]
        if not fields:
            self._position += 1
        for member in fields:
            self._member(member, prefix + member.name)

    def _member(self, member: Field, path: str) -> None:
        count = self._length() if member.count == -1 else member.count
        if member.type in NUMPY_TYPES:
            self._primitive(path, NUMPY_TYPES[member.type], count)
        elif count is None:
            self._single(member.type, path)
        else:
            for index in range(count):
                self._single(member.type, f"{path}[{index}]")

    def _single(self, kind: str, path: str) -> None:
        if kind == "string":
            length = self._length()
            self.layout.leaves.append(Leaf(path, self._position, "", length))
            self._position += length
        elif kind == "wstring":
            self._position += 4 * self._length()
        else:
            self.struct(kind, path + ".")

    def _align(self, size: int) -> None:
        self._position += -(self._position - _ENCAPSULATION) % size

    def _length(self) -> int:
        self._align(4)
        (length,) = struct.unpack_from("<I", self._data, self._position)
        self.layout.lengths.append((self._position, length))
        self._position += 4
        return int(length)

    def _primitive(self, path: str, dtype: str, count: int | None) -> None:
        size = np.dtype(dtype).itemsize
        if count != 0:
            self._align(size)
        end = self._position + size * (1 if count is None else count)
        if end > len(self._data):
            raise struct.error(f"{path} lies beyond the end of the message")
        self.layout.leaves.append(Leaf(path, self._position, dtype, count))
        self._position = end


Columns = dict[str, NDArray[Any]]


class ColumnDecoder:
    """Decodes messages of one type into columns named by dotted paths, such as `pose.pose.position.z`.

    Array elements of structures are `nodes[0].x`; an array of numbers is one column of shape (n, elements).

    Parameters
    ----------
    name, text : the type and its `ros2msg` schema
    wanted : which paths to decode; all if None
    """

    def __init__(self, name: str, text: str, wanted: Callable[[str], bool] | None = None) -> None:
        self._name = name
        self._types = parse_schema(name, text)
        self._root = next(iter(self._types))
        self._wanted = wanted
        self._layouts: dict[int, list[Layout]] = {}
        missing = {
            member.type
            for fields in self._types.values()
            for member in fields
            if member.type not in PRIMITIVES and member.type not in self._types
        }
        if missing:
            raise BagError(f"the definition of {name} in the bag lacks {', '.join(sorted(missing))}")

    @property
    def has_header(self) -> bool:
        """The type begins with a std_msgs/Header."""
        fields = self._types[self._root]
        return bool(fields) and fields[0] == Field("header", "std_msgs/Header", None)

    def decode(self, messages: Sequence[bytes]) -> Columns:
        """Return the columns of `messages`, n rows each; what a message does not have is NaN or "".

        Raises BagError for a message that does not fit the definition.
        """
        by_size: dict[int, list[int]] = {}
        for row, data in enumerate(messages):
            by_size.setdefault(len(data), []).append(row)
        gathered: list[tuple[NDArray[np.intp], Columns]] = []
        for size, rows in by_size.items():
            block = np.frombuffer(b"".join([messages[row] for row in rows]), dtype=np.uint8).reshape(-1, size)
            self._groups(block, np.asarray(rows), gathered)
        if len(gathered) == 1:
            return gathered[0][1]
        return _merge(gathered, len(messages))

    def _groups(
        self, block: NDArray[np.uint8], rows: NDArray[np.intp], gathered: list[tuple[NDArray[np.intp], Columns]]
    ) -> None:
        """Split rows of one size by layout, and decode each group."""
        known = self._layouts.setdefault(block.shape[1], [])
        for layout in known:
            block, rows = self._gather(layout, block, rows, gathered)
        while rows.size:
            layout = self._layout(block[0].tobytes())
            if len(known) < 64:
                known.append(layout)
            block, rows = self._gather(layout, block, rows, gathered)

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
        if data[:2] != b"\x00\x01":
            raise BagError(f"a message of {self._name} is not little-endian CDR (it begins with {data[:4].hex()})")
        walker = _Walker(self._types, data)
        try:
            walker.struct(self._root, "")
        except struct.error as error:
            raise BagError(f"a message of {self._name} does not fit its definition: {error}") from error
        layout = walker.layout
        if self._wanted:
            layout.leaves = [leaf for leaf in layout.leaves if self._wanted(leaf.name)]
        return layout


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
    """Put groups of rows together; columns or elements that a group lacks are NaN or ""."""
    names = dict.fromkeys(name for _, columns in gathered for name in columns)
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
    """Put batches (rows, columns) one behind the other."""
    gathered = []
    first = 0
    for rows, columns in batches:
        gathered.append((np.arange(first, first + rows), columns))
        first += rows
    return gathered[0][1] if len(gathered) == 1 else _merge(gathered, first)
