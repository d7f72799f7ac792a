"""The catalogue: cables, units and winches with published particulars, which a scenario names instead of their values.

>>> find("cable", "wire_28mm_6x36").values["diameter"]
0.028
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from importlib import resources
from typing import Any

from heave_node.files.bounded_yaml import parse_yaml
from heave_node.parameters import Given, ParameterError

KINDS = ("cable", "unit", "winch")
"""Kinds of entries in the catalogue, by the group under `system.` that an entry fills."""
FROM = "from"
"""Names the entry in a group that has values of its own beside it: `cable: {from: NAME, normal_drag: 1.6}`."""
_NUMBER = re.compile(r"\d+")
_LIKE_SIZE = 0.2
"""Share of the size in an unknown name by which that of a proposed name may differ."""


@dataclass(frozen=True)
class Entry:
    """One cable, unit or winch."""

    kind: str  # cable, unit or winch
    name: str  # by which a scenario takes it
    title: str  # what it is
    sources: tuple[str, ...]  # where its particulars are from
    values: Mapping[str, object]  # by the parameter's name in the group `system.KIND`

    @property
    def breaking_force(self) -> float:
        """Of a rope [N]; 0: not known, or no rope."""
        force = self.values.get("breaking_force", 0.0)
        return float(force) if isinstance(force, int | float) else 0.0


@cache
def entries(kind: str) -> dict[str, Entry]:
    """Return the entries of a `kind` by name."""
    text = (resources.files("heave_node") / "catalogue.yaml").read_text(encoding="utf-8")
    found = [entry for name, given in parse_yaml(text)[kind].items() for entry in _entries(kind, name, given)]
    return {entry.name: entry for entry in found}


def _entries(kind: str, name: str, given: Mapping[str, Any]) -> list[Entry]:
    title, sources = str(given["title"]), tuple(given["sources"])
    if "values" in given:
        return [Entry(kind, name, title, sources, given["values"])]
    return [_of_diameter(Entry(kind, name, title, sources, {}), given, number) for number in given["diameters"]]


def _of_diameter(family: Entry, given: Mapping[str, Any], number: int) -> Entry:
    """Return the rope of a nominal diameter of `number` millimetres out of a family."""
    diameter = 1e-3 * number
    values = {name: float(value) for name, value in given.get("constants", {}).items()}
    values |= {name: float(f"{factor * diameter:.6g}") for name, factor in given["of_diameter"].items()}
    values |= {name: float(f"{factor * diameter**2:.6g}") for name, factor in given["of_square"].items()}
    return replace(family, name=family.name.format(number), values=values)


def find(kind: str, name: object, where: str = "") -> Entry:
    """Return an entry of the catalogue.

    Parameters
    ----------
    kind : cable, unit or winch
    name : of the entry
    where : opens the message for a name that is not there

    Raises ParameterError for such a name, with the nearest one.
    """
    known = entries(kind)
    if isinstance(name, str) and name in known:
        return known[name]
    near = _nearest(str(name), list(known))
    hint = f"did you mean {near}?" if near else f"heave list {kind} lists them"
    opening = f"{where}: " if where else ""
    raise ParameterError(f"{opening}there is no {kind} {name} in the catalogue; {hint}")


def _nearest(name: str, known: Sequence[str]) -> str:
    """Return the known name most like `name`; of those that differ in a number, the one with the nearest.

    "" where none is like it, or its size is another: by more than a fifth, or by letters alone.
    """
    number = _NUMBER.search(name)
    alike = [one for one in known if number and _NUMBER.sub("#", one) == _NUMBER.sub("#", name)]
    if number and alike:
        wanted = int(number[0])
        off, near = min((abs(int(_NUMBER.findall(one)[0]) - wanted), one) for one in alike)
        return near if off <= _LIKE_SIZE * wanted else ""
    same_size = [one for one in known if not number or _NUMBER.findall(one)[:1] == [number[0]]]
    return next(iter(difflib.get_close_matches(name, same_size, n=1)), "")


def with_entries(given: Mapping[str, Given]) -> dict[str, Given]:
    """Return values in which each name of the catalogue stands for the values of its entry; others win over these.

    `given` is by dotted name; `system.cable` or `system.cable.from` names a cable, and so on. Raises ParameterError for
    a name that is not in the catalogue.
    """
    taken: dict[str, Given] = {}
    own = dict(given)
    for kind in KINDS:
        group = f"system.{kind}"
        named = [own.pop(name) for name in (group, f"{group}.{FROM}") if name in own]
        for one in named:
            entry = find(kind, one.value, f"{one.where}: {one.name}")
            taken |= {f"{group}.{name}": replace(one, value=value) for name, value in entry.values.items()}
    return {**taken, **own}
