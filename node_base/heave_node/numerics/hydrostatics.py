"""Weight and buoyancy of what hangs in water. One definition each; SI units."""

from __future__ import annotations

import math

from heave_node.numerics.constants import SEAWATER_DENSITY, STANDARD_GRAVITY


def displaced_area(diameter: float, displaced_diameter: float = 0.0) -> float:
    """Return the cross-section of the water that a cable displaces [m^2], which is its displaced volume per metre.

    Parameters
    ----------
    diameter : outer diameter [m]
    displaced_diameter : diameter of the displaced water, where water enters the cable [m]; 0 means the outer diameter
    """
    return 0.25 * math.pi * (displaced_diameter or diameter) ** 2


def weight_in_fluid(
    mass: float, volume: float, density: float = SEAWATER_DENSITY, gravity: float = STANDARD_GRAVITY
) -> float:
    """Return weight minus buoyancy, positive down [N]; per metre [N/m] where mass and volume are per metre.

    Parameters
    ----------
    mass : in air [kg] or [kg/m]
    volume : of the displaced fluid [m^3] or [m^2]
    density : of the fluid [kg/m^3]
    gravity : [m/s^2]
    """
    return (mass - density * volume) * gravity
