"""Columns of the plain arrays that the compiled functions of statics share, and the arrays together. SI units, z up."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from heave_node.numerics.arrays import Array

# A segment: unstretched length [m], EA [N], weight in water [N/m], drag per speed squared across and along [N s2/m3].
LENGTH, STIFFNESS, WEIGHT, NORMAL, TANGENTIAL = range(5)
SEGMENT_COLUMNS = 5

# A node: steady force x, y, z [N]; drag per speed squared along each axis, and of an isotropic body
# [N s2/m2].
FORCE, AXIS_DRAG, BODY_DRAG = 0, 3, 6
NODE_COLUMNS = 7


class CableTables(NamedTuple):
    """A cable, the water around it, and how its drag is taken."""

    segments: Array  # shape (n, SEGMENT_COLUMNS)
    nodes: Array  # shape (n + 1, NODE_COLUMNS)
    current: Array  # profile of `physics.current`
    factor: float  # factor on the current [-]
    feed: float  # speed at which the cable runs along itself towards s = 0 [m/s], as when it is laid
    # true takes the segments' drag from `ShapeTables.drag` as a dead load, False computes it and leaves it there
    frozen: bool


class ShapeTables(NamedTuple):
    """A shape, as `march` fills it."""

    positions: Array  # shape (n + 1, 3) [m]
    lower: Array  # tension vector at each segment's lower end, shape (n, 3) [N]
    upper: Array  # tension vector at each segment's upper end, shape (n, 3) [N]
    drag: Array  # drag on each segment, shape (n, 3) [N/m]
    end: Array  # tension vector beyond node n, shape (3,): the force that holds the other end [N]
    partials: Array  # (position of node n, `end`) by (origin, start), shape (6, 6)


def allocate_shape(count: int) -> ShapeTables:
    """Return tables for a shape of `count` segments, with nothing known of the drag (NaN)."""
    return ShapeTables(
        positions=np.empty((count + 1, 3)),
        lower=np.empty((count, 3)),
        upper=np.empty((count, 3)),
        drag=np.full((count, 3), np.nan),
        end=np.empty(3),
        partials=np.empty((6, 6)),
    )
