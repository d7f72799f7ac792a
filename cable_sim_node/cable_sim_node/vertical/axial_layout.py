"""Columns of the plain arrays that the axial model's kernels share, and the arrays together. SI units, z up."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from heave_node.numerics.arrays import Array

# What a metre of cable brings: 1/EA [1/N], mass [kg/m], weight [N/m], drag [N s2/m3], internal damping over EA [s].
COMPLIANCE, MASS, WEIGHT, DRAG, DELAY = range(5)
QUANTITIES = 5

# A section: label of its start [m]; of each quantity its amount per metre and its integral from the unit to the start.
START = 0
DENSITY = 1
TOTAL = DENSITY + QUANTITIES
SECTION_COLUMNS = TOTAL + QUANTITIES

# A body on the cable: label [m], inertia [kg], weight [N], drag [N s2/m2].
LABEL, BODY_INERTIA, BODY_WEIGHT, BODY_DRAG = range(4)

# The unit: mass with added mass [kg], weight [N], drag [N s2/m2].
UNIT_INERTIA, UNIT_WEIGHT, UNIT_DRAG = range(3)

# The moving top at one instant: elevation and its rate [m], [m/s]; length of the cable out and its rate [m], [m/s].
TOP, TOP_VELOCITY, LENGTH, LENGTH_RATE = range(4)

# A node: elevation less label P [m] now and one and two steps ago, velocity [m/s] likewise; mass [kg], weight [N] and
# drag [N s2/m2] of its lump; its row of the tridiagonal system.
(
    POSITION,
    BEFORE,
    EARLIER,
    VELOCITY,
    VELOCITY_BEFORE,
    VELOCITY_EARLIER,
    LUMP_MASS,
    LUMP_WEIGHT,
    LUMP_DRAG,
    LOWER,
    DIAGONAL,
    UPPER,
    RIGHT,
) = range(13)
NODE_COLUMNS = 13

# An element: stiffness [N/m], damping [N s/m], tension [N], 1 where it carries load and 0 where it is slack.
STIFFNESS, DAMPING, TENSION, TAUT = range(4)
ELEMENT_COLUMNS = 4

# A sample of the answer: elevation of the unit [m], its velocity [m/s], top tension and smallest tension [N].
UNIT_ELEVATION, UNIT_VELOCITY, TOP_TENSION, LEAST_TENSION = range(4)
ANSWER_COLUMNS = 4


class AxialArrays(NamedTuple):
    """The axial cable as its kernels take it; rows are sections, bodies, nodes and elements from the unit upwards."""

    sections: Array
    bodies: Array
    unit: Array
    nodes: Array
    elements: Array
    is_linear: bool  # true lets an element carry compression, as a linear material would


def allocate_nodes(segments: int) -> tuple[Array, Array]:
    """Return the nodes and elements of a cable of `segments` elements."""
    return np.zeros((segments + 1, NODE_COLUMNS)), np.zeros((segments, ELEMENT_COLUMNS))
