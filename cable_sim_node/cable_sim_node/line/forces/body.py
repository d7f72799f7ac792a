"""What the unit weighs, moves along and is held back by, where that depends on its place and its motion.

- Over the Keulegan-Carpenter number KC = 2 pi z_m/D of its heave, tables give vertical added mass and drag. z_m is the
  root of 2 times the mean square of its path through the water, both with the time constant `memory`: of a harmonic
  motion its amplitude. At rest KC is 0; a unit that sinks steadily gets to the end of the table.
- A unit with a box is wet by the share s of its height that is below the surface: so are its buoyancy, its drag and its
  horizontal added mass. While it enters, underside below the surface and top above it, water slams with
  (1/2) rho C_s A_p U^2, A_p length times breadth, holes included, U the speed through the surface. In DNV-RP-N103
  C_s = 2/(rho A_p) dA_33/dh: slam is the growth of the added mass, and counts once. So the vertical added mass grows
  as (1/2) rho C_s A_p h with the wet height h, and slam ends where that is all that it has under water: the momentum
  A_33 U lost to the water is then what was gained by it (von Karman). A box too low for that has s of its added mass
  and is slammed until its top is under. What it gains beyond the slam costs it nothing, as with C_s = 0: a way in and
  out takes the work of the slam. Nothing pulls on the unit when it leaves.

Everything is taken in the middle state, and holds for a whole step: what a predicted position misses is of the third
order in the step. Arguments: `line` the arrays, `time` [s].
"""

from __future__ import annotations

import math

from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inner_kernel

from cable_sim_node.line import layout as at
from cable_sim_node.line.arrays import LineArrays
from cable_sim_node.line.forces.waves import surface_at
from cable_sim_node.physics.current import between, locate
from cable_sim_node.physics.hydrodynamics import wet_part


@inner_kernel
def keulegan_carpenter(numbers: Array) -> float:
    """Return the KC of the unit's heave through the water until now, from the `numbers` of the line."""
    if numbers[at.HEAVE_WEIGHT] == 0.0:
        return 0.0
    amplitude = math.sqrt(2.0 * numbers[at.HEAVE_SQUARE] / numbers[at.HEAVE_WEIGHT])
    return 2.0 * math.pi * amplitude / numbers[at.KC_WIDTH]


@inner_kernel
def follow_heave(line: LineArrays, h: float) -> None:
    """Take the unit's heave in a step of `h` [s], which it has made, into its path and the mean square of that.

    For a unit with a table over KC only.
    """
    numbers, tile = line.numbers, line.tiles[0]
    memory = numbers[at.KC_MEMORY]
    kept = math.exp(-h / memory)
    path = kept * numbers[at.HEAVE_PATH] + (1.0 - kept) * memory * (tile[at.VZ] - tile[at.FLOW_Z])
    numbers[at.HEAVE_PATH] = path
    numbers[at.HEAVE_SQUARE] = kept * numbers[at.HEAVE_SQUARE] + (1.0 - kept) * path * path
    numbers[at.HEAVE_WEIGHT] = kept * numbers[at.HEAVE_WEIGHT] + 1.0 - kept


@inner_kernel
def look_up(key: float, numbers: Array, first: int, rows: int) -> tuple[float, float]:
    """Return what the table of so many `rows` of three numbers from `first` on gives at `key`: second and third."""
    table = numbers[first : first + 3 * rows].reshape((rows, 3))
    low, high, share = locate(key, table)
    return between(table, low, high, share, 1), between(table, low, high, share, 2)


@inner_kernel
def vertical_coefficients(line: LineArrays) -> tuple[float, float]:
    """Return vertical added mass [kg] and (1/2) rho C_D S [kg/m] of the unit, all of it wet."""
    numbers = line.numbers
    rows = int(numbers[at.KC_ROWS])
    if rows > 0:
        return look_up(keulegan_carpenter(numbers), numbers, at.NUMBERS + 3 * int(numbers[at.PROFILE_ROWS]), rows)
    added = numbers[at.DEEP + at.UNIT_INERTIA + 2] - numbers[at.UNIT_MASS]
    return added, numbers[at.DEEP + at.UNIT_DRAG + 2]


@inner_kernel
def entering(depth: float, sunk: float, end: float) -> float:
    """Return the share of a step in which the underside is less than `end` [m] under the surface, and not above it.

    `depth` [m] is that in the middle of the step, in which it gets deeper by `sunk` [m].
    """
    if sunk <= 0.0:
        return 1.0 if 0.0 < depth < end else 0.0
    return max(min(depth + 0.5 * sunk, end) - max(depth - 0.5 * sunk, 0.0), 0.0) / sunk


@inner_kernel
def set_unit(line: LineArrays, time: float, h: float) -> None:
    """Set the inertia, drag and force of a unit that varies, and what moving water accelerates of it.

    They are for a step of `h` [s], 0 for one moment.
    """
    numbers, tile = line.numbers, line.tiles[0]
    level, rise = surface_at(line, tile[at.MIDDLE + at.X], tile[at.MIDDLE + at.Y], time)
    depth = level - tile[at.MIDDLE + at.Z]
    added, drag = vertical_coefficients(line)
    height, slamming, full, slam = numbers[at.BOX_HEIGHT], numbers[at.SLAMMING], added, 0.0
    wet, added = wet_part(depth, height, slamming, full)
    if height > 0.0 and slamming > 0.0:
        speed = max(rise - tile[at.MIDDLE + at.VZ], 0.0)
        slam = slamming * speed * speed * entering(depth, speed * h, min(height, full / slamming))
    mass = numbers[at.UNIT_MASS]
    displaced = numbers[at.DEEP + at.UNIT_FLUID + 2] - (numbers[at.DEEP + at.UNIT_INERTIA + 2] - mass)
    for axis in range(3):
        sideways = wet * (numbers[at.DEEP + at.UNIT_INERTIA + axis] - mass)
        moved = added if axis == 2 else sideways
        numbers[at.UNIT_INERTIA + axis] = mass + moved
        numbers[at.UNIT_FLUID + axis] = wet * displaced + moved
        numbers[at.UNIT_DRAG + axis] = wet * (drag if axis == 2 else numbers[at.DEEP + at.UNIT_DRAG + axis])
        numbers[at.UNIT_FORCE + axis] = numbers[at.DEEP + at.UNIT_FORCE + axis]
    numbers[at.UNIT_BODY_DRAG] = wet * numbers[at.DEEP + at.UNIT_BODY_DRAG]
    numbers[at.UNIT_FORCE + 2] += slam - (1.0 - wet) * numbers[at.BUOYANCY]
