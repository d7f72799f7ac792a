"""The line's arrays, together, as the compiled kernels take them. Allocated once.

Columns are named in `layout`. The arrays are few and wide: each one costs a tenth of a microsecond on the way into a
kernel from Python, and nine arguments to compile in every kernel.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from heave_node.numerics.arrays import Array

from cable_sim_node.line import layout as at


class LineArrays(NamedTuple):
    """What is known of a line. Nodes and segments are counted from the unit upwards; only the first ones are in use.

    The methods are for Python; kernels see the fields alone.
    """

    tiles: Array  # nodes, parts, grid, water and equations along the line
    numbers: Array  # unit, boom tip, counters, what is seen, and settings
    # rows of the current's profile (depth, u_x, u_y, u_z), and of the waves
    water: Array
    # the wide system of a line with bending; three rows more are scratch for a hinge. One row without bending.
    band: Array

    @property
    def segments(self) -> int:
        """Number of segments in use."""
        return int(self.numbers[at.SEGMENTS])

    @property
    def grid_points(self) -> Array:
        """Unstretched length from the unit to each grid point [m]."""
        points = self.column(at.START, at.TILE * len(self.tiles))
        return points[: int(np.argmax(points)) + 1]

    def read(self, first: int, columns: int, rows: int) -> Array:
        """Return a copy of so many `columns` from `first` on of so many nodes or segments, shape (rows, columns)."""
        block = self._columns(first, columns)
        return block.transpose(0, 2, 1).reshape(-1, columns)[:rows].copy()

    def column(self, column: int, rows: int) -> Array:
        """Return a copy of one `column` of so many nodes or segments, shape (rows,)."""
        return self.read(column, 1, rows)[:, 0]

    def write(self, first: int, values: Array) -> None:
        """Set columns from `first` on of the first nodes or segments to `values`, shape (rows, columns)."""
        rows, columns = values.shape
        block = self._columns(first, columns)
        for tile in range((rows - 1) // at.TILE + 1):
            part = values[tile * at.TILE : (tile + 1) * at.TILE]
            block[tile, :, : len(part)] = part.T

    def _columns(self, first: int, columns: int) -> Array:
        start = first // at.STRIDE
        return self.tiles.reshape(len(self.tiles), at.TILE_COLUMNS, at.STRIDE)[:, start : start + columns, : at.TILE]


def allocate(grid: Array, points: Array, numbers: Array, profile: Array, *, bending: bool) -> LineArrays:
    """Return arrays for a line at rest that is not yet in equilibrium.

    Parameters
    ----------
    grid : parts between the grid's points, shape (k, PART_COLUMNS)
    points : unstretched length from the unit to each grid point [m], shape (k,)
    numbers : unit and settings, shape (NUMBERS + 3 rows of the seabed's profile,)
    profile : of the current, see `physics.current`
    bending : whether the line has bending stiffness
    """
    rows = len(grid) + 1
    tiles = np.zeros((rows // at.TILE + 1, at.TILE_COLUMNS * at.STRIDE))
    water = np.zeros((len(profile), at.WATER_COLUMNS))
    water[:, : profile.shape[1]] = profile
    line = LineArrays(
        tiles=tiles,
        numbers=numbers,
        water=water,
        band=np.zeros((3 * rows + 3 if bending else 1, at.BAND_COLUMNS)),
    )
    line.write(at.PART, grid)
    line.write(at.GRID + at.PART, grid)
    line.write(at.START, points[:, None])
    return line
