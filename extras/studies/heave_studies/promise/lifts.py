"""The lift itself, drawn: a rope of the catalogue, its length, a unit, a sea, as `heave new` would make a scenario.

The controller knows all of it: what it does wrong there it does wrong in a nominal run.
"""

from __future__ import annotations

from collections.abc import Mapping

from heave_node.catalogue import Entry, entries
from heave_node.numerics import hydrostatics
from heave_node.numerics.constants import SEAWATER_DENSITY, STANDARD_GRAVITY

from heave_studies.promise.deviation import Chance, Settings
from heave_studies.promise.table import sea_of

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
