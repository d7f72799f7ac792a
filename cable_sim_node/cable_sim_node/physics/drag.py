"""Drag of moving water on a straight piece of cable (thesis 2.4), and its derivatives.

With the flow u past the piece, u_t its part along the unit vector e and u_n the rest, the drag per metre is

    N abs(u_n) u_n + T abs(u_t) u_t e,    N = (1/2) rho C_N d (Eq. 2.46),    T = (pi/2) rho C_tau d (Eq. 2.47).
"""

from __future__ import annotations

import math

from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inner_kernel, kernel

Vector = tuple[float, float, float]

HARMONIC_DRAG = 8.0 / (3.0 * math.pi)
"""First harmonic of abs(sin) sin: the linear drag that takes the same energy per cycle as quadratic drag."""


@inner_kernel
def resolve(tangent: Vector, x: float, y: float, z: float) -> tuple[float, Vector, float]:
    """Return the part of a velocity (x, y, z) along the unit vector `tangent`, the vector across it, and its size."""
    along = x * tangent[0] + y * tangent[1] + z * tangent[2]
    across = (x - along * tangent[0], y - along * tangent[1], z - along * tangent[2])
    return along, across, math.sqrt(across[0] ** 2 + across[1] ** 2 + across[2] ** 2)


@inner_kernel
def drag_force(normal: float, tangential: float, tangent: Vector, slip: float, across: Vector, speed: float) -> Vector:
    """Return the drag per metre.

    Parameters
    ----------
    normal, tangential : N and T [N s2/m3]
    tangent : unit vector along the cable
    slip : flow along the cable [m/s]
    across : flow across the cable [m/s]
    speed : size of that [m/s]
    """
    pull = normal * speed
    friction = tangential * abs(slip) * slip
    return (
        pull * across[0] + friction * tangent[0],
        pull * across[1] + friction * tangent[1],
        pull * across[2] + friction * tangent[2],
    )


@inner_kernel
def tangent_of(chord: Array) -> tuple[Vector, float]:
    """Return the unit vector along a chord, and the chord's length [m]; a chord without length has no direction."""
    size = math.sqrt(chord[0] ** 2 + chord[1] ** 2 + chord[2] ** 2) + 1e-300
    return (chord[0] / size, chord[1] / size, chord[2] / size), size


@inner_kernel
def fill_slope(
    normal: float, tangential: float, tangent: Vector, slip: float, across: Vector, speed: float, by_flow: Array
) -> None:
    """Fill `by_flow`, shape (3, 3), with the derivative of the drag by the flow [N s/m2].

    The drag is `drag_force(normal, tangential, tangent, slip, across, speed)`.
    """
    for i in range(3):
        for j in range(3):
            projector = (1.0 if i == j else 0.0) - tangent[i] * tangent[j]
            outer = across[i] * across[j] / speed if speed > 0.0 else 0.0
            by_flow[i, j] = normal * (speed * projector + outer)
            by_flow[i, j] += 2.0 * tangential * abs(slip) * tangent[i] * tangent[j]


@kernel
def segment_drag(
    chord: Array, flow: Vector, feed: float, normal: float, tangential: float, by_chord: Array, by_flow: Array
) -> Vector:
    """Return the drag per unstretched length of a straight piece [N/m], and fill its derivatives.

    Parameters
    ----------
    chord : from the piece's start to its end [m], any length but zero
    flow : water velocity [m/s]
    feed : speed at which the cable runs along itself towards its start, as when it is laid [m/s]
    normal, tangential : N and T [N s2/m3]
    by_chord, by_flow : out, shape (3, 3), derivatives by the chord and by the flow
    """
    tangent, size = tangent_of(chord)
    along, across, speed = resolve(tangent, flow[0], flow[1], flow[2])
    slip = along + feed
    fill_slope(normal, tangential, tangent, slip, across, speed, by_flow)
    for i in range(3):
        for j in range(3):
            projector = (1.0 if i == j else 0.0) - tangent[i] * tangent[j]
            outer = across[i] * across[j] / speed if speed > 0.0 else 0.0
            # d across / d tangent = -(tangent flow' + along I); d slip / d tangent = flow
            lever = speed * tangent[i] * across[j] + along * (speed * projector + outer)
            by_chord[i, j] = -normal * lever
            by_chord[i, j] += tangential * abs(slip) * (2.0 * tangent[i] * across[j] + slip * projector)
            by_chord[i, j] /= size
    return drag_force(normal, tangential, tangent, slip, across, speed)
