"""The line's arrays, together, as the compiled kernels take them. Allocated once.

Columns are named in `layout`. The arrays are few and wide: each one that a kernel takes is compiled into nine
arguments, in every kernel again.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from heave_node.numerics.arrays import Array
from numpy.typing import NDArray

from cable_sim_node.line import layout as at


class LineArrays(NamedTuple):
    """What is known of a line. Rows are nodes or segments from the unit upwards; only the first ones are in use.

    The properties are views, for Python; kernels see the fields alone.
    """

    now: Array
    """Position, velocity and acceleration of each node."""
    middle: Array
    """The same where the equations hold."""
    top: Array
    """Boom tip, time and length: now, where the equations hold, and at the end of the step."""
    grid: Array
    """Properties of each grid segment and of the point below it; never change."""
    parts: Array
    """Properties of each segment in use, those of the grid but for the top one, and of the lump on the node below."""
    unit: Array
    current: Array
    """Current profile, rows (depth, u_x, u_y)."""
    schedule: Array
    """Factor of the current, rows (time, factor)."""
    settings: Array
    """Numbers of the whole line: step, scheme, tension law, seabed, compensator, wave."""
    flow: Array
    """Motion of the water along the line."""
    equations: Array
    """The linear equations of each node, and the tension of the segment above it."""
    band: Array
    """The wide system of a line with bending; three rows more are scratch for a hinge. One row without bending."""
    counters: NDArray[np.int64]
    """Segments in use, and what has been counted."""

    @property
    def x(self) -> Array:
        """Node positions [m], shape (rows, 3)."""
        return self.now[:, at.X : at.Z + 1]

    @property
    def v(self) -> Array:
        """Node velocities [m/s], shape (rows, 3)."""
        return self.now[:, at.VX : at.VZ + 1]

    @property
    def a(self) -> Array:
        """Node accelerations [m/s^2], shape (rows, 3)."""
        return self.now[:, at.AX : at.AZ + 1]

    @property
    def grid_s(self) -> Array:
        """Material coordinate of each grid point [m], from the unit."""
        return self.grid[:, at.START]

    @property
    def tensions(self) -> Array:
        """Tension of each segment [N]."""
        return self.equations[:, at.TENSION]

    @property
    def residual(self) -> Array:
        """Residual of each node's equations [N], shape (rows, 3)."""
        return self.equations[:, at.RX : at.RZ + 1]


def allocate(
    grid: Array, unit: Array, current: Array, schedule: Array, settings: Array, *, bending: bool
) -> LineArrays:
    """Return arrays for a line at rest that is not yet in equilibrium.

    Parameters
    ----------
    grid : material points, shape (rows - 1, GRID_COLUMNS)
    unit : shape (UNIT_COLUMNS,)
    current, schedule : profile of the current and its factor over time, see `physics.current`
    settings : shape (SETTING_COLUMNS,)
    bending : whether the line has bending stiffness
    """
    rows = len(grid) + 1
    parts = np.zeros((rows, at.PART_COLUMNS))
    parts[:-1] = grid[:, : at.PART_COLUMNS]
    return LineArrays(
        now=np.zeros((rows, at.NODE_COLUMNS)),
        middle=np.zeros((rows, at.NODE_COLUMNS)),
        top=np.zeros((3, at.TOP_COLUMNS)),
        grid=grid,
        parts=parts,
        unit=unit,
        current=current,
        schedule=schedule,
        settings=settings,
        flow=np.zeros((rows, at.FLOW_COLUMNS)),
        equations=np.zeros((rows, at.EQUATION_COLUMNS)),
        band=np.zeros((3 * rows + 3 if bending else 1, at.BAND_COLUMNS)),
        counters=np.zeros(at.COUNTER_COLUMNS, dtype=np.int64),
    )
