"""What the parts of a lift can carry, and the safety factor that a load leaves: capacity over largest load.

>>> Strength("rope_safety_factor", "rope", "breaking force", 494e3, SAFETY_FACTOR).under(530e3).state
'FAILED'
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from heave_node.numerics.constants import SEAWATER_DENSITY

SAFETY_FACTOR = 2.535
"""Breaking force over largest dynamic load that a lift should have [-]: 1.3 (load) x 1.3 (consequence) x 1.5 (certified
steel wire rope), the nominal safety factor of GL Noble Denton 0027/ND rev. 11.2 (2016), 7.3 to 7.10, where bends,
terminations and wear reduce nothing; its least is 2.3.
"""

RATED = 1.0
"""A rated pull, which has its maker's safety factor in it, over the largest load [-]."""

LEAST = 1.0
"""Factor below which a part carries more than it can [-]."""

ROPE, WINCH_PULL, ATTACHMENT = "rope_safety_factor", "winch_pull_factor", "attachment_safety_factor"
"""Keys of the factors among the figures of merit."""

FACTORS = (ROPE, WINCH_PULL, ATTACHMENT)


@dataclass(frozen=True)
class Strength:
    """What one part of the lift can carry."""

    key: str  # of its factor among the figures of merit
    part: str  # its factor's name for people
    kind: str  # what the capacity is: breaking force, rated pull
    capacity: float  # [N]
    required: float  # least factor [-]

    def under(self, load: float) -> LoadCheck:
        """Return how the part stands under its largest `load` [N]."""
        return LoadCheck(self, load)


@dataclass(frozen=True)
class LoadCheck:
    """A part under its largest load."""

    strength: Strength  # of the part
    load: float  # the largest [N]; NaN: unknown

    @property
    def factor(self) -> float:
        """Capacity over load [-]; infinite without a load, NaN where the load is unknown."""
        return safety_factor(self.strength.capacity, self.load)

    @property
    def is_overloaded(self) -> bool:
        """Whether the part carries more than it can."""
        return self.factor < LEAST

    @property
    def is_short(self) -> bool:
        """Whether the part can carry the load, but with less than the required factor."""
        return LEAST <= self.factor < self.strength.required

    @property
    def is_failed(self) -> bool:
        """Whether the required factor is not reached."""
        return self.is_overloaded or self.is_short

    @property
    def state(self) -> str:
        """The result in a word: FAILED, met, or unknown."""
        if math.isnan(self.factor):
            return "unknown"
        return "FAILED" if self.is_failed else "met"

    def __str__(self) -> str:
        one = self.strength
        return (
            f"{one.part} {_number(self.factor, 2)} ({one.kind} {1e-3 * one.capacity:.4g} kN, largest tension "
            f"{_number(1e-3 * self.load, 1)} kN, required at least {one.required:.4g}): {self.state}"
        )

    def to_json(self) -> dict[str, object]:
        """Return it as plain data, SI units in the names."""
        one = self.strength
        return {
            "part": one.part,
            "capacity_n": one.capacity,
            "load_n": self.load,
            "factor": self.factor,
            "required": one.required,
            "state": self.state,
        }


def _number(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if math.isfinite(value) else "-"


def safety_factor(capacity: float, load: float) -> float:
    """Return a `capacity` [N] over a `load` [N]; infinite without a load, NaN where either is unknown (NaN)."""
    if math.isnan(capacity) or math.isnan(load):
        return math.nan
    return capacity / load if load > 0.0 else math.inf


def strengths(plant: Mapping[str, Any], winch: Mapping[str, Any]) -> tuple[Strength, ...]:
    """Return what the parts of a lift can carry, of those whose capacity is stated.

    Parameters
    ----------
    plant : parameters of cable and unit by dotted name: `cable.breaking_force`, `cable.safety_factor`,
        `unit.attachment_breaking_force`, `unit.attachment_safety_factor`; the controller has them by the same names
    winch : parameters of the winch by name: `rated_pull`
    """
    rope_factor = plant.get("cable.safety_factor", SAFETY_FACTOR)
    attachment_factor = plant.get("unit.attachment_safety_factor", SAFETY_FACTOR)
    parts: tuple[tuple[str, str, str, Any, Any], ...] = (
        (ROPE, "Safety factor of the rope", "breaking force", plant.get("cable.breaking_force"), rope_factor),
        (WINCH_PULL, "Rated pull over largest tension", "rated pull", winch.get("rated_pull"), RATED),
        (
            ATTACHMENT,
            "Safety factor of the load's attachment",
            "breaking force",
            plant.get("unit.attachment_breaking_force"),
            attachment_factor,
        ),
    )
    return tuple(
        Strength(key, part, kind, float(capacity), float(required))
        for key, part, kind, capacity, required in parts
        if _is_stated(capacity) and _is_stated(required)
    )


def load_checks(parts: Iterable[Strength], *, top: float, unit: float) -> tuple[LoadCheck, ...]:
    """Return how the `parts` stand under their largest loads.

    Parameters
    ----------
    parts : whose strength is stated
    top : largest tension at the boom tip, the load of rope and winch [N]
    unit : largest tension at the unit, the load of its attachment [N]; NaN where unknown
    """
    return tuple(part.under(unit if part.key == ATTACHMENT else top) for part in parts)


def _is_stated(value: object) -> bool:
    """Return whether a parameter states a number above 0; one out of a bag may be anything."""
    return isinstance(value, int | float) and math.isfinite(value) and value > 0.0


def payload_words(mass: float, volume: float, density: float = SEAWATER_DENSITY) -> str:
    """Return a load as a lift plan states it: 12 t in air, 8.93 t in water.

    Parameters
    ----------
    mass : in air [kg]
    volume : of the displaced water [m^3]
    density : of the water [kg/m^3]

    >>> payload_words(12000.0, 3.0)
    '12 t in air, 8.93 t in water'
    """
    return f"{mass_words(mass)} in air, {mass_words(mass - density * volume)} in water"


def mass_words(mass: float) -> str:
    """Return a `mass` [kg] in t, or in kg below half a tonne, with three figures."""
    return f"{mass:.3g} kg" if abs(mass) < 500.0 else f"{float(f'{1e-3 * mass:.3g}'):g} t"
