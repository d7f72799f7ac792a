"""A load in words: what it weighs in air and in water. Added mass is no part of either."""

from __future__ import annotations

from heave_node.numerics.constants import SEAWATER_DENSITY


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
