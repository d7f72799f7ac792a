"""Steady drag of a current on a straight piece of cable (thesis 2.4), and the current itself, with derivatives."""

from __future__ import annotations

import math

from heave_node.arrays import Array
from numba import njit


@njit(cache=True, error_model="numpy")
def current_at(depth: float, depths: Array, velocities: Array, factor: float, flow: Array, gradient: Array) -> None:
    """Fill the current [m/s] and its derivative by depth [1/s] at `depth` [m].

    Straight between the points of the profile and constant beyond them; shapes (k,) and (k, 3); `factor` multiplies it.
    """
    last = len(depths) - 1
    gradient[:] = 0.0
    if depth <= depths[0]:
        for i in range(3):
            flow[i] = factor * velocities[0, i]
        return
    if depth >= depths[last]:
        for i in range(3):
            flow[i] = factor * velocities[last, i]
        return
    row = 0
    while depth > depths[row + 1]:
        row += 1
    size = depths[row + 1] - depths[row]
    share = (depth - depths[row]) / size
    for i in range(3):
        change = velocities[row + 1, i] - velocities[row, i]
        flow[i] = factor * (velocities[row, i] + share * change)
        gradient[i] = factor * change / size


@njit(cache=True, error_model="numpy")
def segment_drag(
    chord: Array,
    flow: Array,
    feed: float,
    normal: float,
    tangential: float,
    force: Array,
    by_chord: Array,
    by_flow: Array,
) -> None:
    """Fill the drag per unstretched length of a straight piece and its derivatives.

    Parameters
    ----------
    chord : from the piece's start to its end [m], any length but zero
    flow : water velocity [m/s]
    feed : speed at which the cable runs along itself towards its start, as when it is laid [m/s]
    normal, tangential : (1/2) rho C_N d (thesis Eq. 2.46) and (pi/2) rho C_tau d (Eq. 2.47) [N s2/m3]
    force : out [N/m]
    by_chord, by_flow : out, shape (3, 3), derivatives by the chord and by the flow
    """
    size = math.sqrt(chord[0] ** 2 + chord[1] ** 2 + chord[2] ** 2) + 1e-300
    tx, ty, tz = chord[0] / size, chord[1] / size, chord[2] / size
    tangent = (tx, ty, tz)
    along = flow[0] * tx + flow[1] * ty + flow[2] * tz
    across = (flow[0] - along * tx, flow[1] - along * ty, flow[2] - along * tz)
    speed = math.sqrt(across[0] ** 2 + across[1] ** 2 + across[2] ** 2)
    slide = along + feed
    for i in range(3):
        force[i] = normal * speed * across[i] + tangential * abs(slide) * slide * tangent[i]
    for i in range(3):
        for j in range(3):
            unit = 1.0 if i == j else 0.0
            projector = unit - tangent[i] * tangent[j]
            # d across / d flow is the projector, and by_across = normal (speed I + across across'/speed)
            outer = across[i] * across[j] / speed if speed > 0.0 else 0.0
            by_flow[i, j] = normal * (speed * projector + outer)
            by_flow[i, j] += 2.0 * tangential * abs(slide) * tangent[i] * tangent[j]
            # d across / d tangent = -(tangent flow' + along I); d slide / d tangent = flow
            lever = speed * tangent[i] * across[j] + along * (speed * projector + outer)
            by_chord[i, j] = -normal * (lever)
            by_chord[i, j] += tangential * abs(slide) * (2.0 * tangent[i] * across[j] + slide * projector)
            by_chord[i, j] /= size
