"""Sheets: the columns of a table, each declared once with unit and format, for people and for machines. Pure.

>>> SEAS = Sheet(
...     Column("sea", "name", "name"),
...     Column("Hs [m]", "height", "height_m", ".1f"),
...     Column("power [kW]", lambda sea: 250.0 * sea.height, "power_w", ".2f", 1e-3),
... )
>>> from types import SimpleNamespace
>>> seas = [SimpleNamespace(name="calm", height=1.0), SimpleNamespace(name="not known", height=float("nan"))]
>>> SEAS.cells(seas)
[['calm', '1.0', '0.25'], ['not known', '-', '-']]
>>> SEAS.records(seas[:1])
[{'name': 'calm', 'height_m': 1.0, 'power_w': 250.0}]
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from operator import attrgetter
from typing import Any

UNKNOWN = "-"
"""Cell of a number that is not known."""


@dataclass(frozen=True)
class Column:
    """A column of a table, or a line of a report of one row."""

    heading: str  # for people, with the unit; "": machines alone have the column
    given: str | Callable[[Any], Any]  # attribute of a row, dotted, or a function of the row: in the unit of `key`
    key: str = ""  # for machines, ends in the unit: top_tension_n; "": people alone have the column
    form: str | Callable[[Any], str] = ""  # of a cell for people, as in format(); or a function of the scaled value
    scale: float = 1.0  # from the unit of `key` to that of `heading` [-]

    def value(self, row: Any) -> Any:
        """Return the value of a `row`, in the unit of the key."""
        return self.given(row) if callable(self.given) else attrgetter(self.given)(row)

    def text(self, row: Any) -> str:
        """Return the cell of a `row` for people."""
        value = self.value(row)
        if isinstance(value, float):
            if math.isnan(value):
                return UNKNOWN
            value = self.scale * value + 0.0  # no -0
        return self.form(value) if callable(self.form) else format(value, self.form)


class Sheet(tuple[Column, ...]):
    """The columns of a table. Made of columns and of sheets, whose columns it has as well."""

    __slots__ = ()

    def __new__(cls, *parts: Column | Sheet) -> Sheet:
        """Return the sheet of `parts`, in their order."""
        return super().__new__(cls, (one for part in parts for one in (part if isinstance(part, Sheet) else (part,))))

    @property
    def shown(self) -> list[Column]:
        """Columns that people see."""
        return [one for one in self if one.heading]

    @property
    def headings(self) -> list[str]:
        """Headings of the columns that people see."""
        return [one.heading for one in self.shown]

    def cells(self, rows: Iterable[Any]) -> list[list[str]]:
        """Return the cells of each of the `rows` under the headings."""
        return [[one.text(row) for one in self.shown] for row in rows]

    def lines(self, row: Any) -> list[tuple[str, str]]:
        """Return heading and cell of each column, for a report of one `row`."""
        return [(one.heading, one.text(row)) for one in self.shown]

    def record(self, row: Any) -> dict[str, Any]:
        """Return the values of a `row` by key, for machines."""
        return {one.key: one.value(row) for one in self if one.key}

    def records(self, rows: Iterable[Any]) -> list[dict[str, Any]]:
        """Return the values of each of the `rows` by key, for JSON, CSV and frames."""
        return [self.record(row) for row in rows]
