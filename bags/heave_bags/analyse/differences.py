"""In what runs differ from one another, and a run from its scenario: changed parameters, scheduled faults."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from heave_node.scenario import CHANGED
from heave_node.system_parameters import own_name

from heave_bags.analyse.reading.stored import as_number
from heave_bags.analyse.run_record import RunRecord

MOST_DIFFERENCES = 3
"""Runs that differ in more are called by the names of their bags."""
FAULTS = "faults"
"""Group of the parameters that schedule the faults of a device."""
CLEAR = "clear"
"""Kind of fault that ends others."""
LISTS_OF_FAULTS = ("kind", "start", "duration", "magnitude")
UNITS = {"duration": "s", "peak_period": "s", "significant_wave_height": "m", "length": "m", "mass": "kg"}


@dataclass(frozen=True)
class Difference:
    """Something in which runs differ: its `name`, and the `values` of the runs in words, in its `unit`."""

    name: str
    values: tuple[str, ...]
    unit: str = ""

    def __str__(self) -> str:
        return f"{self.name}: {' / '.join(dict.fromkeys(self.values))} {self.unit}".rstrip()

    def of(self, number: int) -> str:
        """Return in words what run `number` has."""
        if self.values[number] == "-" and not self.unit:
            return f"no {self.name}"
        return f"{self.name} {self.values[number]} {self.unit}".rstrip()


def differences(records: Sequence[RunRecord]) -> list[Difference]:
    """Return in which parameters the runs `records` differ, what ship and controller share once; the law first."""
    parameters = [{node: _with_faults(own) for node, own in record.parameters.items()} for record in records]
    names = {(node, name) for run in parameters for node, own in run.items() for name in own}
    found: dict[tuple[str, tuple[str, ...]], set[str]] = {}
    for node, name in names:
        values = tuple(_text(run.get(node, {}).get(name)) for run in parameters)
        if len(set(values)) > 1:
            found.setdefault((name.rsplit(".", 1)[-1], values), set()).add(name)
    scenarios = tuple(record.run.get("scenario", "") for record in records)
    own = [Difference("scenario", scenarios)] if len(set(scenarios)) > 1 else []
    others = [
        Difference(
            (short if len(full) > 1 else min(full)).replace("_", " ").replace(".", " "), values, UNITS.get(short, "")
        )
        for (short, values), full in found.items()
    ]
    return own + sorted(others, key=lambda one: (one.name != "law", one.name == "seed", one.name))


def changes(record: RunRecord) -> dict[str, str]:
    """Return what the run `record` changed of its scenario, and the faults that were scheduled in it, in words.

    Both are the differences from the same run without them.
    """
    places = [place for place in record.run.get(CHANGED, "").split(", ") if place]

    def is_changed(node: str, name: str) -> bool:
        return any(place in (name, f"{node}.{name}") or name == own_name(node, place) for place in places)

    plain = {
        node: {name: value for name, value in own.items() if not (_is_of_faults(name) or is_changed(node, name))}
        for node, own in record.parameters.items()
    }
    found = differences([replace(record, parameters=plain), record])
    faults = [one for one in found if one.name.endswith(FAULTS)]
    return {
        "changed": "; ".join(one.of(1) for one in found if one not in faults),
        "faults": "; ".join(one.of(1).replace(f"{FAULTS} ", "", 1) for one in faults),
    }


@dataclass(frozen=True)
class ScheduledFault:
    """A fault that the parameters of a run schedule."""

    device: str  # in words
    kind: str  # as stated
    magnitude: str  # as stated
    start: float  # simulated time [s]
    duration: float  # [s]; 0: until cleared, or to the end

    def __str__(self) -> str:
        size = f" {self.magnitude}" if self.magnitude else ""
        lasting = f" for {self.duration:g} s" if self.duration else ""
        return f"{self.kind}{size} from {self.start:g} s{lasting}"

    @property
    def end(self) -> float:
        """End of the fault [s]; infinite: until cleared, or to the end."""
        return self.start + self.duration if self.duration else math.inf

    @property
    def words(self) -> str:
        """Which device has what fault, and how large, without its time."""
        if self.kind == CLEAR:
            return f"faults of the {self.device} cleared"
        size = f", {self.magnitude}" if self.magnitude else ""
        return f"injected fault of the {self.device}: {self.kind.replace('_', ' ')}{size}"


def scheduled_faults(record: RunRecord) -> list[ScheduledFault]:
    """Return the faults of all devices that the parameters of the run `record` schedule."""
    groups = ((own, _group_of_faults(name)) for own in record.parameters.values() for name in own)
    found = [_faults(own, group) for own, group in groups if group is not None]
    return [fault for of_device in found for fault in of_device]


def _is_of_faults(name: str) -> bool:
    """Return whether the parameter `name` is one of the lists of faults of a device."""
    return any(f".{name}".endswith(f".{FAULTS}.{last}") for last in LISTS_OF_FAULTS)


def _group_of_faults(name: str) -> str | None:
    """Return the group of the faults of a device whose kinds are the parameter `name`; None of another parameter."""
    return name.removesuffix(".kind") if f".{name}".endswith(f".{FAULTS}.kind") else None


def _with_faults(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Return the `parameters` of a node with the four lists of faults of a device as one value, in words."""
    found = dict(parameters)
    for group in [group for name in parameters if (group := _group_of_faults(name)) is not None]:
        for name in LISTS_OF_FAULTS:
            found.pop(f"{group}.{name}", None)
        found[group] = ", ".join(map(str, _faults(parameters, group)))
    return found


def _faults(parameters: Mapping[str, Any], group: str) -> list[ScheduledFault]:
    """Return the faults that the four lists of a `group` schedule; a bag may state anything."""
    lists = [parameters.get(f"{group}.{name}", ()) for name in LISTS_OF_FAULTS]
    rows = zip(*(one if isinstance(one, list | tuple) else () for one in lists), strict=False)
    device = group.removesuffix(FAULTS).rstrip(".").replace("sensors.", "sensor ") or "winch"
    device = device.replace("_", " ").replace(".", " ")
    return [
        ScheduledFault(device, _text(kind), _text(size) if size else "", as_number(start), as_number(duration, 0.0))
        for kind, start, duration, size in rows
    ]


def _text(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:g}"
    if value is None or value in ("", [], ()):
        return "-"  # an empty list that one bag states, and another does not, is no difference
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_text(item) for item in value) + "]"
    return str(value)


def labels(records: Sequence[RunRecord]) -> list[str]:
    """Return what to call each of the runs `records` beside the others: what differs, or else the name of its bag."""
    found = differences(records) if len(records) > 1 else []
    if not 0 < len(found) <= MOST_DIFFERENCES:
        return [record.name for record in records]
    if len(found) == 1 and found[0].name in ("law", "scenario"):
        called = list(found[0].values)
    else:
        called = [", ".join(one.of(n) for one in found) for n in range(len(records))]
    return [
        f"{label} ({record.name})" if called.count(label) > 1 else label
        for label, record in zip(called, records, strict=True)
    ]


def title(records: Sequence[RunRecord]) -> str:
    """Return what a report of the runs `records` is about: the lift or its scenario and, of several, what differs."""
    scenarios = list(dict.fromkeys(record.title or record.run.get("scenario") or record.name for record in records))
    if len(records) == 1:
        return scenarios[0]
    found = [one for one in differences(records) if one.name != "scenario"]
    shown = "; ".join(str(one) for one in found[:MOST_DIFFERENCES])
    more = f"; {len(found) - MOST_DIFFERENCES} more differences" if len(found) > MOST_DIFFERENCES else ""
    return f"{' and '.join(scenarios)}: {shown}{more}" if shown else " and ".join(scenarios)
