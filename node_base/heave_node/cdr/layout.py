"""The layout of serialised ROS 2 messages (CDR): where each value lies, worked out from the definition that a bag
carries.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np

SEPARATOR = "=" * 80
"""The line of a `ros2msg` schema after which the next type follows."""

_NUMBERS = (
    *(("bool", "?", "?"), ("byte", "u1", "B"), ("char", "u1", "B"), ("uint8", "u1", "B"), ("int8", "i1", "b")),
    *(("uint16", "u2", "H"), ("int16", "i2", "h"), ("uint32", "u4", "I"), ("int32", "i4", "i")),
    *(("uint64", "u8", "Q"), ("int64", "i8", "q"), ("float32", "f4", "f"), ("float64", "f8", "d")),
)
NUMPY_TYPES = {name: dtype for name, dtype, _ in _NUMBERS}
"""Types of numpy, by those of a definition."""
STRUCT_CODES = {dtype: code for _, dtype, code in _NUMBERS}
"""Codes of `struct`, by types of numpy."""

PRIMITIVES = frozenset((*NUMPY_TYPES, "string", "wstring"))

LITTLE_ENDIAN = b"\x00\x01\x00\x00"
"""Encapsulation header at the start of a message."""
ENCAPSULATION = len(LITTLE_ENDIAN)
"""Bytes before the message proper; alignment counts from their end."""

MOST_VALUES = 1 << 17
"""Values, texts and sequences in one message, beyond which no layout is worked out."""
DEEPEST_TYPE = 32
"""Structures within each other in one message."""
LONGEST_DEFINITION = 1 << 20
LONGEST_NAME = 255
"""Characters of a definition and of the name of a field."""


class LayoutError(ValueError):
    """A message that does not fit its definition, or a definition that cannot be; one line."""


_FIELD = re.compile(
    r"^(?P<type>[A-Za-z][\w/]*)(?:<=\d+)?(?P<array>\[(?:<=)?\d*\])?\s+(?P<name>[A-Za-z]\w*)\s*(?P<rest>.*)$"
)


@dataclass(frozen=True)
class Field:
    """One field of a message definition: `name`, `type`, `count`.

    The count is the length of a fixed array; -1 is a sequence, None a single value.
    """

    name: str
    type: str
    count: int | None


@dataclass(frozen=True)
class Leaf:
    """Where one primitive value, array or text lies in a message."""

    name: str  # of the field, dotted
    offset: int  # in the message [bytes]
    dtype: str  # of numpy; "" for a text
    count: int | None  # of elements; None for a single value


@dataclass
class Layout:
    """The `leaves` of all messages whose length words agree with `lengths` (offset, value)."""

    leaves: list[Leaf] = field(default_factory=list)
    lengths: list[tuple[int, int]] = field(default_factory=list)
    # padding between values: first byte and the one after the last
    gaps: list[tuple[int, int]] = field(default_factory=list)
    end: int = 0  # number of bytes of the message


def parse_schema(name: str, text: str) -> dict[str, list[Field]]:
    """Return the fields of each type in the `ros2msg` schema `text`, keyed `package/Type`; the first is that of `name`.

    Raises LayoutError for a definition of a length that none has.
    """
    if len(text) > LONGEST_DEFINITION:
        raise LayoutError(f"the definition of {name} has {len(text)} characters, {LONGEST_DEFINITION} are allowed")
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


def field_lines(lines: Iterable[str]) -> Iterator[re.Match[str]]:
    """Yield type, array and name of each field among the `lines` of a definition; constants are left out."""
    for line in lines:
        match = _FIELD.match(line.split("#", 1)[0].strip())
        if match and not match["rest"].startswith("="):
            yield match


def _fields(lines: Iterable[str], package: str) -> Iterator[Field]:
    for match in field_lines(lines):
        kind, array = match["type"], match["array"]
        if kind not in PRIMITIVES:
            parts = kind.split("/")
            kind = f"{parts[0] if len(parts) > 1 else package}/{parts[-1]}"
        count = None if not array else int(array[1:-1][:10]) if array[1:-1].isdigit() else -1
        if len(match["name"]) > LONGEST_NAME:
            raise LayoutError(f"a field of {package} has a name of {len(match['name'])} characters")
        yield Field(match["name"], kind, count)


class _Walker:
    """Walks one message and notes where its values lie. Raises struct.error where the message does not hold what its
    lengths promise, or holds too much.
    """

    def __init__(self, types: dict[str, list[Field]], data: bytes) -> None:
        self._types = types
        self._data = data
        self._position = ENCAPSULATION
        self._left = MOST_VALUES
        self.layout = Layout()

    def walk(self, name: str) -> Layout:
        self.struct(name, "")
        self.layout.end = self._position
        if self._position > len(self._data):
            raise struct.error("it ends too early")
        return self.layout

    def struct(self, name: str, prefix: str) -> None:
        fields = self._types[name]
        if not fields:
            self._position += 1
        for member in fields:
            self._member(member, prefix + member.name)

    def _member(self, member: Field, path: str) -> None:
        count = self._length() if member.count == -1 else member.count
        if count is not None and count > len(self._data) - self._position:  # each element takes a byte at least
            raise struct.error(f"{path} has {count} elements, which extend beyond the end of the message")
        if member.type in NUMPY_TYPES:
            self._primitive(path, NUMPY_TYPES[member.type], count)
        elif count is None:
            self._single(member.type, path)
        else:
            for index in range(count):
                self._single(member.type, f"{path}[{index}]")

    def _single(self, kind: str, path: str) -> None:
        self._left -= 1
        if self._left < 0 or self._position > len(self._data):
            raise struct.error(f"it has more than {MOST_VALUES} values" if self._left < 0 else "it ends too early")
        if kind == "string":
            length = self._length()
            self.layout.leaves.append(Leaf(path, self._position, "", length))
            self._position += length
        elif kind == "wstring":
            self._position += 4 * self._length()
        else:
            self.struct(kind, path + ".")

    def _align(self, size: int) -> None:
        gap = -(self._position - ENCAPSULATION) % size
        if gap:
            self.layout.gaps.append((self._position, self._position + gap))
            self._position += gap

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
            raise struct.error(f"{path} extends beyond the end of the message")
        self._left -= 1
        self.layout.leaves.append(Leaf(path, self._position, dtype, count))
        self._position = end


class MessageLayouts:
    """Works out the layouts of messages of the type `name` with the `ros2msg` schema `text`.

    Raises LayoutError if the schema lacks a type that it uses, or nests types too deeply or without an end.
    """

    def __init__(self, name: str, text: str) -> None:
        self.name = name
        self._types = parse_schema(name, text)
        self._root = next(iter(self._types))
        missing = {
            member.type
            for fields in self._types.values()
            for member in fields
            if member.type not in PRIMITIVES and member.type not in self._types
        }
        if missing:
            raise LayoutError(f"the definition of {name} lacks {', '.join(sorted(missing))}")
        level = {self._root}
        for _ in range(DEEPEST_TYPE):
            level = {member.type for kind in level for member in self._types[kind] if member.type not in PRIMITIVES}
        if level:
            raise LayoutError(f"the definition of {name} nests types more than {DEEPEST_TYPE} deep")

    @property
    def has_header(self) -> bool:
        """The type begins with a std_msgs/Header."""
        fields = self._types[self._root]
        return bool(fields) and fields[0] == Field("header", "std_msgs/Header", None)

    def has_field(self, path: str) -> bool:
        """Return whether the type has a field of the dotted name `path`, such as `twist.covariance[7]`."""
        kind = self._root
        for name in path.split("."):
            found = [member for member in self._types.get(kind, []) if member.name == name.partition("[")[0]]
            if not found:
                return False
            kind = found[0].type
        return True

    def of(self, data: bytes) -> Layout:
        """Return the layout of the message `data`. Raises LayoutError if it does not fit the definition."""
        if data[:2] != LITTLE_ENDIAN[:2]:
            raise LayoutError(f"a message of {self.name} is not little-endian CDR (it begins with {data[:4].hex()})")
        try:
            return _Walker(self._types, data).walk(self._root)
        except struct.error as error:
            raise LayoutError(f"a message of {self.name} does not fit its definition: {error}") from error
