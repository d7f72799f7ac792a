"""The passive compensator that may carry the sheave: spring, damper and stops along z.

Arguments as in `line.assembly`.
"""

from __future__ import annotations

import math

from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inner_kernel

from cable_sim_node.line import layout as at


@inner_kernel
def add_compensator(tile: Array, j: int, numbers: Array, c_mass: float, c_velocity: float) -> bool:
    """Make node `j` of `tile` the sheave on a passive compensator, free along z only.

    Stroke s = z_tip - z_n, upward force on the sheave F0 + k s + c s', beyond the half stroke stiffened by the stops.
    The preload F0 carries the moving mass as well, so that the static stroke is 0 where F0 is the static top
    tension. Returns whether a stop is near.
    """
    stroke = numbers[at.MIDWAY + at.TIP_Z] - tile[at.MIDDLE + at.Z + j]
    speed = numbers[at.MIDWAY + at.TIP_VZ] - tile[at.MIDDLE + at.VZ + j]
    force = numbers[at.SPRING_PRELOAD] + numbers[at.SPRING_STIFFNESS] * stroke + numbers[at.SPRING_DAMPING] * speed
    stiffness = numbers[at.SPRING_STIFFNESS] + c_velocity * numbers[at.SPRING_DAMPING]
    over = abs(stroke) - numbers[at.SPRING_HALF_STROKE]
    if over > 0.0:
        side = math.copysign(1.0, stroke)
        push = numbers[at.SPRING_STOP] * over + numbers[at.SPRING_STOP_DAMPING] * side * speed
        if push > 0.0:
            force += side * push
            stiffness += numbers[at.SPRING_STOP] + c_velocity * numbers[at.SPRING_STOP_DAMPING]
    tile[at.RX + j] = tile[at.RY + j] = 0.0
    tile[at.RZ + j] += numbers[at.SPRING_MASS] * tile[at.MIDDLE + at.AZ + j] - force
    tile[at.DZZ + j] += c_mass * numbers[at.SPRING_MASS] + stiffness
    tile[at.DXX + j] = tile[at.DYY + j] = 1e30
    tile[at.DXY + j] = tile[at.DXZ + j] = tile[at.DYZ + j] = 0.0
    return over > -0.1 * numbers[at.SPRING_HALF_STROKE]
