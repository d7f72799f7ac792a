"""How a table of the core is written: a structure is a list of rows, each with name, unit, meaning and shape.

Numbers are of eight bytes, counters of four. The build runs it before anything is installed: standard library alone.
"""

from __future__ import annotations

from dataclasses import dataclass

NUMBER, COUNTER = "f8", "i4"
"""Kinds of a field."""


class Size(int):
    """A size of arrays that a build for one controller may make smaller: C++ has it by its name.

    A product of sizes keeps their names.
    """

    text: str

    def __new__(cls, text: str, value: int) -> Size:
        """Make the size that C++ calls `text`."""
        size = super().__new__(cls, value)
        size.text = text
        return size

    def __mul__(self, other: int) -> Size:
        """Return the size of a matrix packed row by row."""
        return Size(f"{self.text} * {getattr(other, 'text', other)}", int(self) * int(other))


@dataclass(frozen=True)
class Row:
    """A field of a structure.

    Attributes
    ----------
    name : of the field
    unit : SI unit; "" for a pure number or a flag
    meaning : what it is, in one line
    kind : NUMBER, COUNTER, or the structure that it holds
    shape : of an array; () of a single one
    """

    name: str
    unit: str
    meaning: str
    kind: str | Structure = NUMBER
    shape: tuple[int, ...] = ()


@dataclass(frozen=True)
class Structure:
    """A structure: its name in C++, what it is, and its rows in their order."""

    name: str
    meaning: str
    rows: tuple[Row, ...]


def structure(name: str, meaning: str, *rows: Row) -> Structure:
    """Return the structure of a `name` and a `meaning` with its `rows`."""
    return Structure(name, meaning, rows)
