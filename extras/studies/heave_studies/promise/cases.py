"""Cases: what is drawn for a kind, a seed of the day and an index; the same on every machine.

The controller knows all of it: what it does wrong there it does wrong in a nominal run.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from heave_bringup.scenarios import Scenario, load_scenario
from heave_node.catalogue import Entry, entries
from heave_node.numerics import hydrostatics
from heave_node.numerics.constants import SEAWATER_DENSITY, STANDARD_GRAVITY

from heave_studies.promise.deviation import (
    BELIEF,
    LOST_KINDS,
    Chance,
    Deviation,
    Fault,
    Nominal,
    Row,
    Settings,
    nominal,
)
from heave_studies.promise.table import CHANGING_SEAS, DEVIATIONS, OPERATIONS, SEAS, sea_of

SCENARIOS = (
    "b2_calm_300",
    "b3_deep_900",
    "b4_limit_900_tp8",
    "b4_limit_900_tp10",
    "b4_limit_900_tp12",
    "b10_real_mru_swell",
    "unit_1500",
)
LAWS = ("lqg", "mpc")

DURATION = 390.0
"""Duration of a run [s]."""

OPERATED = 0.35
"""Share of the draws with deviations in which an operation is under way besides."""


@dataclass(frozen=True)
class Case:
    """What is run."""

    kind: str  # of the draw
    day: int  # of the draw
    index: int  # of the draw
    scenario: str  # of the run
    law: str  # of the run
    seed: int  # of the run
    deviations: tuple[str, ...] = ()  # names of what differs, and of the operation under way; a lift in words
    settings: Settings = field(default_factory=dict)  # of the run, but for law, seed and length
    parts: tuple[str, ...] = ()  # what a finding may blame
    # sensors of which a fault leaves nothing to read, each with the times from and to [s]
    lost: tuple[tuple[str, float, float], ...] = ()
    excused: tuple[tuple[float, float], ...] = ()  # see `Deviation`
    actions: tuple[tuple[float, str, float], ...] = ()  # see `Deviation`

    @property
    def words(self) -> str:
        """Return what was drawn, in a line."""
        values = ", ".join(f"{name.split('.', 1)[1]} {_shown(value)}" for name, value in self.settings.items())
        acts = "".join(f", {what} {value:g} at {time:.0f} s" for time, what, value in self.actions)
        shown = "" if self.kind == "lifts" else f": {values}{acts}"
        return f"{self.index:3d} {self.scenario} {self.law} seed {self.seed}: {'; '.join(self.deviations)}{shown}"

    def load(self, duration: float = DURATION) -> Scenario:
        """Return the scenario of a run of a `duration` [s]."""
        run = {"all.duration": duration, "all.transient": 0.0, "all.seed": self.seed, f"{BELIEF}.law": self.law}
        return load_scenario(
            self.scenario, settings=[f"{name}={_text(value)}" for name, value in {**self.settings, **run}.items()]
        )


def draw(kind: str, day: int, index: int) -> Case:
    """Return draw `index` of a `kind` on a `day`, which is the seed."""
    chance = Chance("draws", kind, day, index)
    return KINDS[kind](chance, Case(kind, day, index, "", "", chance.number(1, 1_000_000), settings={}))


def _few(chance: Chance, case: Case) -> Case:
    return _with_deviations(chance, case, chance.number(1, 2))


def _stacked(chance: Chance, case: Case) -> Case:
    return _with_deviations(chance, case, chance.number(3, 5))


def _with_deviations(chance: Chance, case: Case, count: int) -> Case:
    """Return a case with so many deviations, and sometimes an operation."""
    case = _placed(chance, case)
    rows = _chosen(chance, DEVIATIONS, count)
    if chance.happens(OPERATED):
        taken = {row.slot for row in rows}
        rows += _chosen(chance, [row for row in OPERATIONS if not row.slot or row.slot not in taken], 1)
    return _with(case, rows, chance)


def _seas(chance: Chance, case: Case) -> Case:
    case = _placed(chance, case)
    return _with(case, _chosen(chance, [*SEAS, *CHANGING_SEAS], 1), chance)


def _lifts(chance: Chance, case: Case) -> Case:
    words, settings = lift(chance)
    return replace(case, scenario=MODEL, law=chance.one_of(LAWS), deviations=(words,), settings=settings)


KINDS: dict[str, Callable[[Chance, Case], Case]] = {"few": _few, "stacked": _stacked, "seas": _seas, "lifts": _lifts}
"""Kinds of draws: one or two deviations, three to five, another sea alone, another lift."""


def _placed(chance: Chance, case: Case) -> Case:
    return replace(case, scenario=chance.one_of(SCENARIOS), law=chance.one_of(LAWS))


def _chosen(chance: Chance, rows: Sequence[Row], count: int) -> list[Row]:
    """Return so many different `rows`, no two of one slot."""
    left, chosen = list(rows), []
    for _ in range(count):
        row = chance.one_of(left, [one.weight for one in left])
        chosen.append(row)
        left = [one for one in left if one is not row and not (one.slot and one.slot == row.slot)]
    return chosen


def _with(case: Case, rows: Sequence[Row], chance: Chance) -> Case:
    """Return the `case` with what the `rows` draw."""
    base: Nominal = nominal(case.scenario)
    drawn = [(row, row.draw(chance, base)) for row in rows]
    settings: dict[str, object] = {}
    for _, one in drawn:
        settings |= one.settings
    faults = [fault for _, one in drawn for fault in one.faults]
    return replace(
        case,
        deviations=tuple(one.name or row.name for row, one in drawn),
        settings=settings | _fault_lists(faults),
        parts=tuple(dict.fromkeys(part for row, one in drawn for part in _parts(row, one))),
        lost=tuple(lost for fault in faults for lost in _lost(fault)),
        excused=tuple(span for _, one in drawn for span in one.excused),
        actions=tuple(sorted(action for _, one in drawn for action in one.actions)),
    )


def _parts(row: Row, deviation: Deviation) -> tuple[str, ...]:
    """Return what may be blamed: of a fault in mid-run the sensor that has it."""
    return row.parts or tuple(_sensor(fault) for fault in deviation.faults)


def _sensor(fault: Fault) -> str:
    return fault.group.rsplit(".", 1)[-1]


def _lost(fault: Fault) -> list[tuple[str, float, float]]:
    """Return the sensor and the time without anything to read of it; empty: there is none."""
    if fault.kind not in LOST_KINDS:
        return []
    return [(_sensor(fault), fault.start, fault.start + fault.duration if fault.duration > 0.0 else DURATION)]


def _fault_lists(faults: Sequence[Fault]) -> dict[str, object]:
    """Return the `faults` as the lists of parameters that they stand in."""
    lists: dict[str, object] = {}
    for group in dict.fromkeys(fault.group for fault in faults):
        its = [fault for fault in faults if fault.group == group]
        lists[f"{group}.faults.kind"] = [fault.kind for fault in its]
        for name in ("start", "duration", "magnitude"):
            lists[f"{group}.faults.{name}"] = [getattr(fault, name) for fault in its]
    return lists


def _text(value: object) -> str:
    """Return a value as an option of the command line has it."""
    if isinstance(value, list):
        return "[" + ", ".join(map(_text, value)) + "]"
    return repr(value) if isinstance(value, float) else str(value)


def _shown(value: object) -> str:
    """Return a value for a reader."""
    if isinstance(value, list):
        return "[" + ", ".join(map(_shown, value)) + "]"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


MODEL = "b3_deep_900"
"""Scenario that `heave new` begins with."""

SAFETY = 3.0
"""A rope breaks at no less than so many times the tension at rest."""

STRAINS = (1e-4, 5e-3)
"""Strain at rest of a rope that one takes for such a unit."""

CATALOGUE_UNITS = 0.3
"""Share of the units that are those of the catalogue; others are drawn."""


def lift(chance: Chance) -> tuple[str, Settings]:
    """Return a lift that `chance` draws in words, and its settings on top of scenario `MODEL`."""
    cables, units = list(entries("cable").values()), list(entries("unit").values())
    while True:
        cable, length = chance.one_of(cables), chance.spread(50.0, 3000.0)
        is_listed = chance.happens(CATALOGUE_UNITS)
        listed = chance.one_of(units)
        unit = listed.values if is_listed else _unit(chance)
        if _fits(cable, length, unit):
            break
    height, period = sea_of(chance)
    name = listed.name if is_listed else f"unit of {float(unit['mass']) / 1e3:.1f} t"  # type: ignore[arg-type]
    settings = {
        "system.cable": cable.name,
        "system.length": length,
        **{f"system.unit.{key}": value for key, value in unit.items()},
        "system.sea.significant_wave_height": height,
        "system.sea.peak_period": period,
    }
    return f"{name} on {length:.0f} m of {cable.name} in Hs {height:.1f} m, Tp {period:.1f} s", settings


def _unit(chance: Chance) -> Mapping[str, object]:
    """Return a unit of 1 to 150 t: from a clump weight to a float that is nearly weightless, from a ball to a plate."""
    mass = chance.spread(1e3, 150e3)
    return {
        "mass": mass,
        "volume": mass / SEAWATER_DENSITY * chance.between(0.13, 0.9),
        "added_mass": 3 * [mass * chance.spread(0.1, 2.0)],
        "drag_coefficient": 3 * [1.5],
        "drag_area": 3 * [mass ** (2.0 / 3.0) * chance.spread(0.002, 0.02)],
    }


def _fits(cable: Entry, length: float, unit: Mapping[str, object]) -> bool:
    """Tell whether a rope of a `length` [m] is one for the `unit`."""

    def of(values: Mapping[str, object], name: str) -> float:
        return float(values[name])  # type: ignore[arg-type]

    diameter = of(cable.values, "displaced_diameter" if "displaced_diameter" in cable.values else "diameter")
    area = hydrostatics.displaced_area(diameter, 0.0)
    per_metre = hydrostatics.weight_in_fluid(
        of(cable.values, "mass_per_length"), area, SEAWATER_DENSITY, STANDARD_GRAVITY
    )
    weight = hydrostatics.weight_in_fluid(of(unit, "mass"), of(unit, "volume"), SEAWATER_DENSITY, STANDARD_GRAVITY)
    top = weight + per_metre * length
    strain = max(top, weight) / of(cable.values, "axial_stiffness")
    is_strong = cable.breaking_force == 0.0 or cable.breaking_force >= SAFETY * max(top, weight)
    return is_strong and top > 0.5 * weight and STRAINS[0] <= strain <= STRAINS[1]
