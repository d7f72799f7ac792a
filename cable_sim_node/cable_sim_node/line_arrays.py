"""The line's arrays, together, as the compiled kernels take them. Allocated once.

Columns are named in `line_layout`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cable_sim_node.kernel_cache import drop_stale
from cable_sim_node.line_layout import COUNTER_COLUMNS, STATE_COLUMNS

Array = NDArray[np.float64]

# before any kernel of the line is looked up: all their modules import this one first
drop_stale(("line_*", "equilibrium"))


class LineArrays(NamedTuple):
    """What is known of a line. Rows are nodes or segments from the unit upwards; only the first ones are in use."""

    x: Array
    """Node positions [m], shape (rows, 3)."""
    v: Array
    """Node velocities [m/s]."""
    a: Array
    """Node accelerations [m/s^2]."""
    grid: Array
    """Properties of each grid segment, as `seg`; never change."""
    grid_s: Array
    """Material coordinate of each grid point [m], from the unit."""
    grid_lump: Array
    """Lump on each grid point."""
    seg: Array
    """Properties of each segment in use: those of the grid but for the top one."""
    lump: Array
    """Lump on each node in use."""
    unit: Array
    current: Array
    """Current profile, rows (depth, u_x, u_y)."""
    schedule: Array
    """Factor of the current, rows (time, factor)."""
    settings: Array
    moving: Array
    """Time and length now."""
    tip: Array
    """Boom tip now: rows position, velocity, acceleration."""
    middle: Array
    """Time and length where the equations hold."""
    middle_tip: Array
    """Boom tip where the equations hold."""
    end: Array
    """Time and length at the end of the step."""
    end_tip: Array
    """Boom tip at the end of the step."""
    flow: Array
    flow_acceleration: Array
    x_middle: Array
    v_middle: Array
    a_middle: Array
    diagonal: Array
    upper: Array
    residual: Array
    sweep: Array
    correction: Array
    hinge: Array
    """Scratch of the bending, shape (3, 9)."""
    tensions: Array
    band: Array
    """Scratch of the solve with bending, shape (3 rows, 17); one row without bending."""
    counters: NDArray[np.int64]


def allocate(
    grid: Array,
    grid_s: Array,
    grid_lump: Array,
    unit: Array,
    current: Array,
    schedule: Array,
    settings: Array,
    *,
    bending: bool,
) -> LineArrays:
    """Return arrays for a line on this grid of material points, at rest and not yet in equilibrium."""
    rows = len(grid_s) + 1

    def scratch(columns: int) -> Array:
        return np.zeros((rows, columns))

    return LineArrays(
        x=scratch(3),
        v=scratch(3),
        a=scratch(3),
        grid=grid,
        grid_s=grid_s,
        grid_lump=grid_lump,
        seg=grid.copy(),
        lump=np.vstack([grid_lump, np.zeros((1, grid_lump.shape[1]))]),
        unit=unit,
        current=current,
        schedule=schedule,
        settings=settings,
        moving=np.zeros(STATE_COLUMNS),
        tip=np.zeros((3, 3)),
        middle=np.zeros(STATE_COLUMNS),
        middle_tip=np.zeros((3, 3)),
        end=np.zeros(STATE_COLUMNS),
        end_tip=np.zeros((3, 3)),
        flow=scratch(3),
        flow_acceleration=scratch(3),
        x_middle=scratch(3),
        v_middle=scratch(3),
        a_middle=scratch(3),
        diagonal=scratch(6),
        upper=scratch(6),
        residual=scratch(3),
        sweep=scratch(9),
        correction=scratch(3),
        hinge=np.zeros((3, 9)),
        tensions=np.zeros(rows),
        band=np.zeros((3 * rows if bending else 1, 17)),
        counters=np.zeros(COUNTER_COLUMNS, dtype=np.int64),
    )
