"""Direction of a segment from its chord, smooth also where the chord vanishes.

A segment that is slack has ends nearer to each other than it is long: the cable between them hangs in a loop or lies
folded, and points the less in one direction the nearer its ends are. Its mean direction is taken as

    d = f(r) w,   w = chord / unstretched length, r = |w|;
    f = 1/r from r = FOLDED on, below it f = (3 - (r/FOLDED)^2) / (2 FOLDED).

It is a unit vector down to half the length, shrinks to zero at zero chord, and has one continuous derivative
everywhere: at most 1.5/FOLDED per unstretched length. Where it is zero, drag and added mass are isotropic,
as they are of a heap of cable.
"""

from __future__ import annotations

import math

from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inner_kernel, kernel

from cable_sim_node.line import layout as at
from cable_sim_node.physics.drag import Vector

FOLDED = 0.5
"""Chord over unstretched length below which a segment counts as folded.

A taut segment has 1, a loop whose ends hang side by side 0; half of it is what a semicircle has 0.64 of.
"""


@kernel
def folded(ratio: float) -> float:
    """Return f of a folded segment, at `ratio` r below FOLDED."""
    share = ratio / FOLDED
    return (1.5 - 0.5 * share * share) / FOLDED


@inner_kernel
def direction_at(tile: Array, j: int) -> Vector:
    """Return the direction of segment `j` of `tile` in the middle state."""
    dx = tile[at.MIDDLE + at.X + j + 1] - tile[at.MIDDLE + at.X + j]
    dy = tile[at.MIDDLE + at.Y + j + 1] - tile[at.MIDDLE + at.Y + j]
    dz = tile[at.MIDDLE + at.Z + j + 1] - tile[at.MIDDLE + at.Z + j]
    per_length = tile[at.PER_LENGTH + j]
    stretched = math.sqrt(dx * dx + dy * dy + dz * dz)
    ratio = stretched * per_length
    size = 1.0 / (stretched + 1e-300) if ratio >= FOLDED else per_length * folded(ratio)
    return dx * size, dy * size, dz * size


@inner_kernel
def direction_of(ratio: float) -> tuple[float, float]:
    """Return f and its derivative by the chord's size, over that size, at `ratio` r (above 0) of chord to length.

    With them d = f w and the derivative of d by w is f I + (f'/r) w w'.
    """
    if ratio >= FOLDED:
        inverse = 1.0 / ratio
        return inverse, -inverse * inverse * inverse
    return folded(ratio), -1.0 / (FOLDED * FOLDED * FOLDED)
