"""Alarms: one row of a table for each, with code, severity and words, and what is raised from it. Pure.

A package has one table, `alarms.yaml` (`read_alarms`), and raises its alarms by name with their values. A name is the
code, with the part where several have it, and the reason where there are several:

>>> TABLE = alarm_table(
...     AlarmRow("SENSOR_LOST, MRU", Severity.HIGH, "mru", "no data for {age:.1f} s", "", "Check power", "stale")
... )
>>> alarm = TABLE.alarm("SENSOR_LOST, MRU: stale", age=1.25)
>>> str(alarm)
'SENSOR_LOST, MRU (high): no data for 1.2 s. Check power.'
>>> alarms_in(str(alarm))[0].severity
<Severity.HIGH: 3>
"""

from __future__ import annotations

import enum
import math
import re
import string
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

from heave_node.files.bounded_yaml import parse_yaml
from heave_node.interface.codes import TIME_KEY, without_figures

Value = float | str

LOOP = "loop"
"""Value that says what the loop does: given by `Alarm.reported`, once that is decided, not where an alarm is raised."""


class Severity(enum.IntEnum):
    """Priority of an alarm: how soon somebody has to act, as IEC 62682 and ISA-18.2 ask for."""

    EVENT = 0
    """Nothing has to be done: an entry of the log, no alarm."""
    LOW = 1
    """Look at it before the next lift."""
    MEDIUM = 2
    """Act within minutes: something is missing that a further fault would need."""
    HIGH = 3
    """Act at once: compensation ends or is less than requested."""
    CRITICAL = 4
    """Act at once: people, unit, cable or winch are in danger."""

    @property
    def word(self) -> str:
        """Name as messages carry it."""
        return self.name.lower()


@dataclass(frozen=True)
class AlarmRow:
    """A row of a table of alarms."""

    code: str  # stable name in upper case; where several parts have it, with the part: SENSOR_LOST, MRU
    severity: Severity  # priority
    part: str  # that it is about: mru, winch, cable, adviser
    state: str  # what is wrong, value with unit against limit; values stand in braces, as in str.format
    # what follows, or is done by itself; empty where nothing is. `{loop}` is what the loop does, a sentence of its own
    consequence: str = ""
    action: str = ""  # what a person does; empty where nothing has to be done
    reason: str = ""  # for which the code is raised; empty where it has one only

    @property
    def name(self) -> str:
        """What it is raised by: the code, and the reason where there is one."""
        return f"{self.code}: {self.reason}" if self.reason else self.code

    @cached_property
    def names(self) -> frozenset[str]:
        """Names of the values that the words need, but for LOOP."""
        text = f"{self.state}{self.consequence}{self.action}"
        return frozenset(name for _, name, _, _ in string.Formatter().parse(text) if name and name != LOOP)

    def alarm(self, **values: Value) -> Alarm:
        """Return the alarm with its `values`; raises ValueError where one is missing or unknown."""
        if values.keys() != self.names:
            raise ValueError(f"alarm {self.name} takes the values {sorted(self.names)}; got {sorted(values)}")
        return Alarm(self, values)


@dataclass(frozen=True)
class Alarm:
    """An alarm that is raised: its row and its values, by name, in SI units and in those that its words say."""

    row: AlarmRow
    values: Mapping[str, Value] = field(default_factory=dict)

    @property
    def code(self) -> str:
        """Code of the row."""
        return self.row.code

    @property
    def name(self) -> str:
        """Code and reason of the row."""
        return self.row.name

    @property
    def severity(self) -> Severity:
        """Severity of the row."""
        return self.row.severity

    @property
    def text(self) -> str:
        """State, consequence and action: a sentence each. What the loop does is left out until it is known."""
        consequence = self.row.consequence
        if LOOP not in self.values:
            consequence = consequence.replace(f"{{{LOOP}}}", "").removeprefix(". ")
        parts = (self._state, consequence, self.row.action)
        return " ".join(f"{part.format(**self.values)}." for part in parts if part)

    def reported(self, loop: str) -> Alarm:
        """Return the alarm with what the `loop` does, a sentence without its full stop, where its row says so."""
        return replace(self, values={**self.values, LOOP: loop}) if f"{{{LOOP}}}" in self.row.consequence else self

    @property
    def _state(self) -> str:
        """State of the row, with as many digits as tell its values from the limit."""
        text, limit = self.row.state, self.values.get("limit")
        if not isinstance(limit, float | int):
            return text
        for figure, name, sign, digits in _FIGURE.findall(text):
            value, least = self.values[name], int(digits)
            if name == "limit" or not isinstance(value, float | int) or abs(value) == limit:
                continue
            enough = (n for n in range(least, least + 4) if round(abs(value), n) != round(limit, n))
            more = next(enough, least)
            text = text.replace(figure, f"{{{name}:{sign}.{more}f}}")
            text = text.replace(f"{{limit:.{digits}f}}", f"{{limit:.{more}f}}")
        return text

    @property
    def brief(self) -> str:
        """What is wrong alone, as the reason of a mode."""
        return f"{self.code}: {self._state.format(**self.values)}"

    def __str__(self) -> str:
        """Return the line of the log, of diagnostics and of a bag, which `alarms_in` reads."""
        return f"{self.code} ({self.severity.word}): {self.text}"


class AlarmTable(dict[str, AlarmRow]):
    """The alarms of a package, by name."""

    def alarm(self, name: str, /, **values: Value) -> Alarm:
        """Return the alarm of a `name` with its `values`; raises KeyError or ValueError where it has no such row."""
        return self[name].alarm(**values)

    def of_code(self, code: str) -> list[AlarmRow]:
        """Return the rows of a `code`, one for each reason; none: it is not of this table."""
        return [row for row in self.values() if row.code == code]


def alarm_table(*rows: AlarmRow) -> AlarmTable:
    """Return the table of `rows`; raises ValueError for a name that is there twice or a code not in capitals."""
    table = AlarmTable()
    for row in rows:
        if row.name in table or not _CODE.fullmatch(row.code):
            raise ValueError(f"alarm {row.name!r}: each code is in capitals, and each name there once")
        table[row.name] = row
    return table


def read_alarms(file: Path) -> AlarmTable:
    """Return the table of a YAML `file`: under each code its severity, part, state, consequence and action.

    A code with `parts` is one for each part, whose name it then ends with; its words have `<part>` for the part, and
    `<name>` for what the file says of that part under `each`, with that name. Under `reasons` stands, by reason, what
    differs from what stands under the code; a reason that differs from part to part has a list. What stands under `log`
    is no alarm: entries of severity event. Raises ValueError, with file and code, for a row that is not complete or has
    a name too many.
    """
    content = parse_yaml(file.read_text(encoding="utf-8"))
    each = content.pop("each", {})
    entries = {code: {"severity": Severity.EVENT.word, **cells} for code, cells in content.pop("log", {}).items()}
    codes = {**content, **entries}
    return alarm_table(*(row for code, cells in codes.items() for row in _rows(file, code, cells, each)))


def _rows(file: Path, code: str, cells: Mapping[str, Any], each: Mapping[str, Mapping[str, str]]) -> Iterator[AlarmRow]:
    """Yield the rows that stand in a `file` under a `code`; `each` is what differs from part to part."""
    common = {name: cell for name, cell in cells.items() if name != "reasons"}
    try:
        for reason, differing in cells.get("reasons", {"": {}}).items():
            for own in differing if isinstance(differing, list) else [differing]:
                words = {**common, **own}
                parts = words.pop("parts", ())
                for one in parts or [words.pop("part")]:
                    filled = {name: _filled(text, {"part": one, **each.get(one, {})}) for name, text in words.items()}
                    severity = Severity[filled.pop("severity").upper()]
                    yield AlarmRow(f"{code}, {one.upper()}" if parts else code, severity, one, reason=reason, **filled)
    except (KeyError, TypeError) as error:
        raise ValueError(f"{file.name}: {code}: missing or unknown: {error}") from error


def _filled(text: str, own: Mapping[str, str]) -> str:
    """Return a `text` with what a part has of its `own` in place of each `<name>`."""
    return _OWN.sub(lambda found: own[found[1]], text)


class ReadAlarm(NamedTuple):
    """An alarm as read from a line: code, severity, text, and simulated time [s] where the line says it, else NaN."""

    code: str
    severity: Severity
    text: str
    time: float = math.nan


_FIGURE = re.compile(r"(\{(\w+):(\+?)\.(\d)f\})")
_OWN = re.compile(r"<(\w+)>")
_CODE = re.compile(r"[A-Z][A-Z0-9]*(_[A-Z0-9]+)*(, [A-Z_]+)?")
_HEAD = re.compile(
    rf"(?:^|(?<=[;:] ))(?:{TIME_KEY.pattern}: )?(?P<code>{_CODE.pattern}) "
    rf"\((?P<severity>{'|'.join(one.word for one in Severity)})\): "
)


def alarms_in(text: str) -> list[ReadAlarm]:
    """Return the alarms that a `text` reports, one or more lines joined by "; "; none where it has no code."""
    heads = list(_HEAD.finditer(text))
    ends = [*(head.start() for head in heads[1:]), len(text)]
    return [
        ReadAlarm(
            head["code"],
            Severity[head["severity"].upper()],
            text[head.end() : end].rstrip("; "),
            math.nan if head[1] is None else float(head[1]),
        )
        for head, end in zip(heads, ends, strict=False)  # a text without a head has one end
    ]


def kind_of(message: str) -> str:
    """Return what stays the same of a `message` of diagnostics while it reports the same: its codes, or its words."""
    return " ".join(alarm.code for alarm in alarms_in(message)) or without_figures(message)


NODE_ALARMS = read_alarms(Path(__file__).with_name("alarms.yaml"))
