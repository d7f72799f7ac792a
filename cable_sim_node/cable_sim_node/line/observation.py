"""What is seen of the line at the end of an interval: motion of the unit, force on the top end, strains.

The present state is looked at by the equations of `assembly`. All that is asked for in every tick stands at the line's
two ends and in its strains: only its first and its last segment are assembled for it. Arguments as in `assembly`.
"""

from __future__ import annotations

import math

from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inlined_kernel, inner_kernel, kernel

from cable_sim_node.line import layout as at
from cable_sim_node.line.arrays import LineArrays
from cable_sim_node.line.assembly import (
    add_lump,
    add_unit,
    assemble,
    assemble_present,
    assemble_tile,
    swap_sheave,
    take_present_place,
    take_present_tip,
)
from cable_sim_node.line.forces.bending import add_bending
from cable_sim_node.line.forces.body import set_unit
from cable_sim_node.line.forces.contact import add_contact, seabed_force_on_unit
from cable_sim_node.line.forces.direction import direction_of
from cable_sim_node.line.forces.flow import set_flow, set_flow_at
from cable_sim_node.line.forces.surface import set_level
from cable_sim_node.line.tiles import copy_borders, larger, largest_of, take_present


@kernel
def evaluate(line: LineArrays) -> float:
    """Fill tensions and residual of the present state of `line`; return the least strain.

    Row n of the residual is then the force [N] that holds the line's top end: the top segment's tension with half its
    weight, drag and inertia.
    """
    n = int(line.numbers[at.SEGMENTS])
    take_present_tip(line.numbers)
    take_present(line.tiles, n)
    set_flow(line, n, line.numbers[at.NOW + at.TIME])
    if line.numbers[at.UNIT_VARIES] > 0.0:
        set_unit(line, line.numbers[at.NOW + at.TIME], 0.0)
    least, _ = assemble(line, n, 0.0, 0.0)
    if line.numbers[at.BENDING_ON] > 0.0:
        add_bending(line, n)
    return least


@inlined_kernel
def evaluate_top(line: LineArrays, n: int) -> None:
    """Set the residual of the sheave in the present state, as `evaluate` does."""
    tiles = line.tiles
    take_present_tip(line.numbers)
    set_level(line)
    assemble_present(line, n, n - 1)
    below, i = tiles[(n - 1) >> at.SHIFT], ((n - 1) & at.LANES) + 1
    top, j = tiles[n >> at.SHIFT], n & at.LANES
    top[at.RX + j], top[at.RY + j], top[at.RZ + j] = below[at.END_RX + i], below[at.END_RY + i], below[at.END_RZ + i]
    take_present_place(top, j)
    add_lump(tiles, n, 0.0, 0.0)


@inlined_kernel
def evaluate_unit(line: LineArrays, n: int) -> None:
    """Set the residual of the unit in the present state, as `evaluate` does."""
    tile, numbers = line.tiles[0], line.numbers
    assemble_present(line, n, at.NONE)
    if numbers[at.FLOW_VARIES] > 0.0:
        set_flow_at(line, at.NONE, at.NONE, at.NONE, numbers[at.NOW + at.TIME])
    if numbers[at.UNIT_VARIES] > 0.0:
        set_unit(line, numbers[at.NOW + at.TIME], 0.0)
    add_unit(tile, numbers, 0.0, 0.0)
    if numbers[at.BED_ON] > 0.0:
        add_contact(line, 0, 0.0)


@inlined_kernel
def observe_strains(line: LineArrays, n: int) -> None:
    """Note the largest strain and how many segments are slack."""
    largest, slack = -1.0, 0
    for t in range(((n - 1) >> at.SHIFT) + 1):
        tile, count = line.tiles[t], min(at.TILE, n - (t << at.SHIFT))
        for j in range(count):
            dx, dy, dz = (
                tile[at.X + j + 1] - tile[at.X + j],
                tile[at.Y + j + 1] - tile[at.Y + j],
                tile[at.Z + j + 1] - tile[at.Z + j],
            )
            strain = math.sqrt(dx * dx + dy * dy + dz * dz) * tile[at.PER_LENGTH + j] - 1.0
            tile[at.SCRATCH + j] = strain
            slack += 1 if strain <= 0.0 else 0
        largest = larger(largest, largest_of(tile, count))
    line.numbers[at.SEEN_STRAIN], line.numbers[at.SEEN_SLACK] = largest, slack


@inner_kernel
def note_tension(line: LineArrays, n: int) -> None:
    """Note the force on the top end in the present state, and its largest size until now."""
    numbers = line.numbers
    copy_borders(line.tiles, n, at.X, at.MOTION_COLUMNS)
    if numbers[at.BENDING_ON] > 0.0:
        evaluate(line)
    else:
        evaluate_top(line, n)
    observe_top(line, n)
    numbers[at.SEEN_LARGEST] = max(numbers[at.SEEN_LARGEST], numbers[at.SEEN_TENSION])


@kernel
def observe(line: LineArrays) -> None:
    """Note what is seen of the present state of `line`, see `layout`."""
    numbers = line.numbers
    n = int(numbers[at.SEGMENTS])
    note_tension(line, n)
    observe_strains(line, n)
    if numbers[at.BENDING_ON] == 0.0:
        evaluate_unit(line, n)
    observe_unit(line)
    if numbers[at.BED_ON] > 0.0:
        numbers[at.SEEN_BED] = seabed_force_on_unit(line)


@inlined_kernel
def observe_top(line: LineArrays, n: int) -> None:
    """Note the force [N] on the top end, node `n`, from its residual, and its size; 0 where the line would push."""
    tile, j, numbers = line.tiles[n >> at.SHIFT], n & at.LANES, line.numbers
    below, k = line.tiles[(n - 1) >> at.SHIFT], (n - 1) & at.LANES
    size = pull = 0.0
    for axis in range(3):
        force = -tile[at.RX + axis * at.STRIDE + j]
        numbers[at.SEEN_FX + axis] = force
        size += force * force
        pull += force * (below[at.X + axis * at.STRIDE + k] - tile[at.X + axis * at.STRIDE + j])
    numbers[at.SEEN_TENSION] = math.sqrt(size) if pull > 0.0 else 0.0


@inlined_kernel
def observe_unit(line: LineArrays) -> None:
    """Note the acceleration [m/s^2] that the forces on the unit give it now, from its residual.

    The integrator's own acceleration a leaves the residual R = M a - F there. M = D - A e e', with A the added mass of
    half of the lowest segment, is inverted by the formula of Sherman and Morrison.
    """
    tile, numbers = line.tiles[0], line.numbers
    half = 0.5 * tile[at.LENGTH]
    added, mass = half * tile[at.ADDED_MASS], half * (tile[at.MASS] + tile[at.ADDED_MASS])
    dx, dy, dz = tile[at.X + 1] - tile[at.X], tile[at.Y + 1] - tile[at.Y], tile[at.Z + 1] - tile[at.Z]
    ratio = math.sqrt(dx * dx + dy * dy + dz * dz) * tile[at.PER_LENGTH] + 1e-300
    factor = direction_of(ratio)[0] * tile[at.PER_LENGTH]
    by_e, e_by_e = 0.0, 0.0
    for axis in range(3):
        e = factor * (tile[at.X + axis * at.STRIDE + 1] - tile[at.X + axis * at.STRIDE])
        inertia = numbers[at.UNIT_INERTIA + axis] + mass
        by_e += e * tile[at.RX + axis * at.STRIDE] / inertia
        e_by_e += e * e / inertia
    by_e *= added / (1.0 - added * e_by_e)
    for axis in range(3):
        e = factor * (tile[at.X + axis * at.STRIDE + 1] - tile[at.X + axis * at.STRIDE])
        inertia = numbers[at.UNIT_INERTIA + axis] + mass
        numbers[at.SEEN_AX + axis] = (
            tile[at.AX + axis * at.STRIDE] - (tile[at.RX + axis * at.STRIDE] + by_e * e) / inertia
        )


@kernel
def snapshot(tiles: Array, numbers: Array, water: Array, band: Array, positions: Array, tensions: Array) -> None:
    """Write the present positions [m] of all nodes to `positions` and the tensions [N] of all segments to `tensions`.

    The line's arrays `tiles`, `numbers`, `water` and `band` are taken one by one, see `step.advance`.
    """
    line = LineArrays(tiles, numbers, water, band)
    n = int(numbers[at.SEGMENTS])
    take_present_tip(numbers)
    take_present(tiles, n)
    swap_sheave(line, n)
    for t in range(((n - 1) >> at.SHIFT) + 1):
        tile, count = tiles[t], min(at.TILE, n - (t << at.SHIFT))
        assemble_tile(tile, count, numbers, 0.0, 0.0)
        for j in range(count):
            tensions[(t << at.SHIFT) + j] = tile[at.TENSION + j]
    for i in range(n + 1):
        tile, j = tiles[i >> at.SHIFT], i & at.LANES
        positions[i, 0], positions[i, 1], positions[i, 2] = tile[at.X + j], tile[at.Y + j], tile[at.Z + j]
