"""Added mass of what is lifted, by the simplified expressions that lifting analysts use, and what of it is wet.

Source: DNV-RP-N103 (2017), Modelling and analysis of marine operations, 4.6.3 and 4.6.4 and table A-2; the same are in
its forerunner DNV-RP-H103 (2011). They are for heave, in deep water away from surface and bottom.
"""

from __future__ import annotations

import math

import numpy as np
from heave_node.numerics.compiled import inner_kernel

PLATE_COEFFICIENTS = (
    (1.00, 0.579),
    (1.25, 0.642),
    (1.50, 0.690),
    (1.59, 0.704),
    (2.00, 0.757),
    (2.50, 0.801),
    (3.00, 0.830),
    (3.17, 0.840),
    (4.00, 0.872),
    (5.00, 0.897),
    (6.25, 0.917),
    (8.00, 0.934),
    (10.0, 0.947),
    (math.inf, 1.0),
)
"""Flat rectangular plate: longer over shorter side, and C_A in a motion across it (table A-2)."""

_SOLID_UP_TO, _OPEN_FROM = 0.05, 0.34
"""Perforation below which holes make no difference, and from which on the second expression holds."""


def plate_added_mass(length: float, breadth: float, density: float) -> float:
    """Return the added mass of a flat rectangular plate that moves across itself [kg]: C_A rho (pi/4) a^2 b.

    Parameters
    ----------
    length, breadth : sides [m]; a is the shorter one, b the longer one
    density : of the water [kg/m^3]
    """
    short, long = sorted((length, breadth))
    if short == 0.0:
        return 0.0
    slenderness = [1.0 / ratio for ratio, _ in PLATE_COEFFICIENTS]
    coefficients = [coefficient for _, coefficient in PLATE_COEFFICIENTS]
    coefficient = float(np.interp(short / long, slenderness[::-1], coefficients[::-1]))
    return coefficient * density * 0.25 * math.pi * short**2 * long


def box_added_mass(length: float, breadth: float, height: float, density: float, perforation: float = 0.0) -> float:
    """Return the vertical added mass of a body with vertical sides and a rectangular outline [kg].

    A_33 = (1 + sqrt((1 - k^2)/(2 (1 + k^2)))) A_plate with k = sqrt(A_p)/(h + sqrt(A_p)) (4.6.3.2), reduced by its
    perforation (4.6.4.1).

    Parameters
    ----------
    length, breadth : sides of its horizontal area A_p [m], holes included
    height : h, of its sides [m]; 0 is a plate
    density : of the water [kg/m^3]
    perforation : share of A_p that is open, 0 to 0.5
    """
    width = math.sqrt(length * breadth)
    if width == 0.0:
        return 0.0
    k = (width / (height + width)) ** 2
    solid = (1.0 + math.sqrt((1.0 - k) / (2.0 * (1.0 + k)))) * plate_added_mass(length, breadth, density)
    return solid * perforation_factor(perforation)


def perforation_factor(perforation: float) -> float:
    """Return the added mass of a perforated body over that of a solid one (4.6.4.1).

    `perforation` is the share of its horizontal area that is open, 0 to 0.5.
    """
    percent = 100.0 * perforation
    if perforation <= _SOLID_UP_TO:
        return 1.0
    if perforation < _OPEN_FROM:
        return 0.7 + 0.3 * math.cos(math.pi * (percent - 5.0) / 34.0)
    return math.exp((10.0 - percent) / 28.0)


@inner_kernel
def wet_part(depth: float, height: float, slamming: float, added: float) -> tuple[float, float]:
    """Return the share of a box that is under water [-], and its vertical added mass there [kg].

    Parameters
    ----------
    depth : of its underside below the surface [m]
    height : of the box [m]; 0 means that it is always under water
    slamming : (1/2) rho C_s A of its underside [kg/m], by which the added mass grows where that is faster
    added : vertical added mass under water [kg]
    """
    if height <= 0.0:
        return 1.0, added
    wet = min(max(depth / height, 0.0), 1.0)
    return wet, min(max(slamming * height, added) * wet, added)
