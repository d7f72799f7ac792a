"""Packs messages: the bytes that the middleware would make of a message object, in a fraction of the time.

Once the lengths of its texts and sequences are known, a message is one `struct` of fixed layout. So what a definition
says of padding is worked out once for each set of lengths, and every message after that is one call of `struct.pack`.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from struct import Struct
from typing import Any, Protocol

import numpy as np

from heave_node.cdr.definitions import schema_text
from heave_node.cdr.layout import ENCAPSULATION, LITTLE_ENDIAN, NUMPY_TYPES, STRUCT_CODES, Field, parse_schema

_MOST_KEPT = 256
"""Layouts kept for one type of message; texts of ever new lengths must not fill the memory."""
_TIMES = ("builtin_interfaces/Time", "builtin_interfaces/Duration")


class _Format:
    """The format of a struct as it grows, with the padding that CDR wants: a number begins at a multiple of its size.

    `lengths` are those of the texts and sequences of a message, in order.
    """

    def __init__(self, lengths: Sequence[int]) -> None:
        self._lengths = iter(lengths)
        self._position = ENCAPSULATION
        self.text = f"<{ENCAPSULATION}s"

    def add(self, code: str, size: int, *, count: int = 1, alignment: int = 1) -> None:
        gap = -(self._position - ENCAPSULATION) % alignment
        self.text += f"{gap}x" * bool(gap) + f"{count}{code}"
        self._position += gap + size * count

    def add_length(self) -> int:
        self.add("I", 4, alignment=4)
        return next(self._lengths)


class _Part(Protocol):
    """A part of a message: it puts its value in a row, and says how that lies in the message."""

    def put(self, value: Any, row: list[Any], lengths: list[int]) -> None:
        """Append what `struct.pack` takes of a `value` to the `row`, and the lengths in it to `lengths`."""

    def lay_out(self, form: _Format) -> None:
        """Append the format of this part."""


class _Number:
    def __init__(self, dtype: str) -> None:
        self._code, self._size = STRUCT_CODES[dtype], np.dtype(dtype).itemsize

    def put(self, value: Any, row: list[Any], _: list[int]) -> None:
        row.append(value)

    def lay_out(self, form: _Format) -> None:
        form.add(self._code, self._size, alignment=self._size)


class _Zeros:
    """Numbers that are always 0, `count` of them: padding."""

    def __init__(self, dtype: str, count: int) -> None:
        self._size, self._count = np.dtype(dtype).itemsize, count

    def put(self, value: Any, row: list[Any], lengths: list[int]) -> None:
        """Put nothing: no value is given."""

    def lay_out(self, form: _Format) -> None:
        form.add("x", 1, count=self._count * self._size, alignment=self._size)


class _Numbers:
    """A row of numbers of one type: groups of `width`, `count` of them; -1 says a sequence, None one group."""

    def __init__(self, dtype: str, width: int, count: int | None) -> None:
        self._dtype = np.dtype(dtype)
        self._code = STRUCT_CODES[dtype].replace("?", "B")
        self._group = self._dtype.itemsize * width
        self._count = 1 if count is None else count
        self._length = self._group * self._count

    def put(self, value: Any, row: list[Any], lengths: list[int]) -> None:
        if isinstance(value, np.ndarray):
            data = (value if value.dtype is self._dtype else value.astype(self._dtype)).tobytes()
        else:
            data = array(self._code, value).tobytes()
        length = self._length
        if self._count == -1:
            count = len(data) // self._group
            length = count * self._group
            row.append(count)
            lengths.append(count)
        if len(data) != length:
            raise ValueError(f"a field of {self._count} times {self._group} bytes cannot hold {len(data)}")
        row.append(data)

    def lay_out(self, form: _Format) -> None:
        count = form.add_length() if self._count == -1 else self._count
        form.add("s", 1, count=count * self._group, alignment=self._dtype.itemsize if count else 1)


class _Text:
    def put(self, value: str, row: list[Any], lengths: list[int]) -> None:
        data = value.encode() + b"\0"
        row += (len(data), data)
        lengths.append(len(data))

    def lay_out(self, form: _Format) -> None:
        form.add("s", 1, count=form.add_length())


class _Time:
    """A time, given in nanoseconds."""

    def put(self, value: int, row: list[Any], _: list[int]) -> None:
        row.extend(divmod(value, 1_000_000_000))

    def lay_out(self, form: _Format) -> None:
        form.add("i", 4, alignment=4)
        form.add("I", 4, alignment=4)


class _Structure:
    def __init__(self, members: Sequence[_Part]) -> None:
        self._members = members

    def put(self, value: Sequence[Any], row: list[Any], lengths: list[int]) -> None:
        for member, its_value in zip(self._members, value, strict=True):
            member.put(its_value, row, lengths)

    def lay_out(self, form: _Format) -> None:
        for member in self._members:
            member.lay_out(form)


class _Sequence:
    """Texts or structures: a fixed `count` of them, or with -1 as many as there are."""

    def __init__(self, element: _Part, count: int) -> None:
        self._element, self._count = element, count

    def put(self, value: Sequence[Any], row: list[Any], lengths: list[int]) -> None:
        if self._count < 0:
            row.append(len(value))
            lengths.append(len(value))
        elif len(value) != self._count:
            raise ValueError(f"{len(value)} values where the message has {self._count}")
        for its_value in value:
            self._element.put(its_value, row, lengths)

    def lay_out(self, form: _Format) -> None:
        for _ in range(form.add_length() if self._count < 0 else self._count):
            self._element.lay_out(form)


class _Constant:
    """What a part puts of a value that is always the same."""

    def __init__(self, part: _Part, value: Any) -> None:
        self._row: list[Any] = []
        self._lengths: list[int] = []
        part.put(value, self._row, self._lengths)

    def put(self, _: Any, row: list[Any], lengths: list[int]) -> None:
        row += self._row
        lengths += self._lengths


def _put_run(values: Sequence[Any], row: list[Any], _: list[int]) -> None:
    """Put numbers that follow each other both in the message and among the values."""
    row += values


class _Definition:
    """The definition of a type as the parts that its messages are made of."""

    def __init__(self, name: str) -> None:
        self._types = parse_schema(name, schema_text(name))
        self._root = next(iter(self._types))

    def parts(self, named: Collection[str]) -> Iterator[tuple[str, _Part]]:
        """Yield the parts of a message in order, each with its path, and "" where it is 0: in no path of `named`."""
        return self._parts_of(self._root, named, "")

    def _parts_of(self, kind: str, named: Collection[str], prefix: str) -> Iterator[tuple[str, _Part]]:
        members = self._types[kind]
        if not members:
            yield "", _Zeros("u1", 1)  # CDR knows no empty structure
        for member in members:
            path = prefix + member.name
            inside = [name for name in named if name.startswith((f"{path}.", f"{path}["))]
            is_fixed = member.count != -1
            if path in named:
                yield path, self._whole(member)
            elif member.type in NUMPY_TYPES and is_fixed:
                yield from _numbers(path, NUMPY_TYPES[member.type], member.count or 1, inside)
            elif member.type in self._types and member.count is None:
                yield from self._parts_of(member.type, inside, f"{path}.")
            else:
                yield path, self._whole(member)

    def _whole(self, member: Field) -> _Part:
        """Return a field as one part."""
        dtype, width = self._uniform(member.type)
        if dtype and member.count is None and member.type in NUMPY_TYPES:
            return _Number(dtype)
        if dtype:
            return _Numbers(dtype, width, member.count)
        element: _Part
        if member.type == "string":
            element = _Text()
        elif member.type in _TIMES:
            element = _Time()
        else:
            element = _Structure([self._whole(inner) for inner in self._types[member.type]])
        return element if member.count is None else _Sequence(element, member.count)

    def _uniform(self, kind: str) -> tuple[str, int]:
        """Return type and number of the numbers in a structure of nothing else; "" where they differ."""
        if kind in NUMPY_TYPES:
            return NUMPY_TYPES[kind], 1
        members = self._types.get(kind, [])
        inside = [self._uniform(member.type) for member in members]
        dtypes = {dtype for dtype, _ in inside}
        if len(dtypes) != 1 or any(member.count == -1 for member in members):
            return "", 0
        return dtypes.pop(), sum(
            width * (member.count or 1) for member, (_, width) in zip(members, inside, strict=True)
        )


def _numbers(path: str, dtype: str, count: int, named: Collection[str]) -> Iterator[tuple[str, _Part]]:
    """Yield the numbers of an array of which a few are `named` by their index; the others are 0."""
    zeros = 0
    for index in range(count):
        if f"{path}[{index}]" not in named:
            zeros += 1
            continue
        if zeros:
            yield "", _Zeros(dtype, zeros)
            zeros = 0
        yield f"{path}[{index}]", _Number(dtype)
    if zeros:
        yield "", _Zeros(dtype, zeros)


class Packer:
    """Packs messages of one type.

    A value is a number or a text; of an array or a sequence a Python sequence; of a structure a sequence with the
    values of its fields; of a time whole nanoseconds. Where a structure holds numbers of one type and nothing else, it
    and a sequence of it are one row of numbers, which may be an array of numpy: positions of shape (n, 3).

    Parameters
    ----------
    name : of the type, `package/msg/Type`
    fields : dotted names of the fields whose values `pack` takes, in that order
    constants : values of further fields. What is in neither is 0, False or empty

    Raises ValueError for a field that the type does not have, DefinitionError for a type that is not installed.

    >>> packer = Packer("geometry_msgs/msg/PointStamped", ("header.stamp", "point"), {"header.frame_id": "world"})
    >>> len(packer.pack(1_500_000_000, (1.0, 2.0, 3.0)))
    52
    """

    def __init__(self, name: str, fields: Sequence[str], constants: Mapping[str, Any] | None = None) -> None:
        constants = constants or {}
        parts = list(_Definition(name).parts({*fields, *constants}))
        unknown = {*fields, *constants} - {path for path, _ in parts}
        if unknown:
            raise ValueError(f"{name} has no field {min(unknown)}")
        self._layout = [part for _, part in parts]
        self._fields = len(fields)
        self._steps = list(_steps(parts, fields, constants))
        self._structs: dict[tuple[int, ...], Struct] = {}

    def pack(self, *values: Any) -> bytes:
        """Return the message with these `values` of its fields.

        Raises ValueError for another number of values, or of numbers in one of them; struct.error for a number that its
        field cannot hold.
        """
        if len(values) != self._fields:
            raise ValueError(f"{len(values)} values for {self._fields} fields")
        row: list[Any] = [LITTLE_ENDIAN]
        lengths: list[int] = []
        for put, place in self._steps:
            put(values[place], row, lengths)
        return self._struct(tuple(lengths)).pack(*row)

    def _struct(self, lengths: tuple[int, ...]) -> Struct:
        """Return the layout of messages whose texts and sequences have these `lengths`."""
        known = self._structs.get(lengths)
        if known is None:
            if len(self._structs) >= _MOST_KEPT:
                self._structs.clear()
            form = _Format(lengths)
            for part in self._layout:
                part.lay_out(form)
            known = self._structs[lengths] = Struct(form.text)
        return known


_Step = tuple[Callable[[Any, list[Any], list[int]], None], int | slice]
"""A function that puts values in a row, and the values that it takes."""


def _steps(parts: Sequence[tuple[str, _Part]], fields: Sequence[str], constants: Mapping[str, Any]) -> Iterator[_Step]:
    """Yield what puts the values of the `fields` and the `constants` in a row, in the order of `parts`."""
    first = after = 0  # of a run of numbers that has not been yielded yet
    for path, part in parts:
        if isinstance(part, _Zeros):
            continue
        place = fields.index(path) if path in fields else -1
        is_in_run = isinstance(part, _Number) and place == after > first
        if after > first and not is_in_run:
            yield _put_run, slice(first, after)
            first = after
        if place < 0:
            value = constants.get(path, "" if isinstance(part, _Text) else ())
            yield _Constant(part, value).put, slice(0)
        elif isinstance(part, _Number):
            first, after = (first if is_in_run else place), place + 1
        else:
            yield part.put, place
    if after > first:
        yield _put_run, slice(first, after)
