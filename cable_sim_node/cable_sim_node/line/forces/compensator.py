"""The passive compensator that may carry the sheave: spring, damper and stops along z.

Arguments as in `line.assembly`.
"""

from __future__ import annotations

import math

from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inner_kernel

from cable_sim_node.line.layout import (
    AZ,
    DXX,
    DXY,
    DXZ,
    DYY,
    DYZ,
    DZZ,
    MIDDLE,
    MIDWAY,
    RX,
    RY,
    RZ,
    SPRING_DAMPING,
    SPRING_HALF_STROKE,
    SPRING_MASS,
    SPRING_PRELOAD,
    SPRING_STIFFNESS,
    SPRING_STOP,
    SPRING_STOP_DAMPING,
    TIP_VZ,
    TIP_Z,
    VZ,
    Z,
)


@inner_kernel
def add_compensator(tile: Array, j: int, numbers: Array, c_mass: float, c_velocity: float) -> bool:
    """Make node `j` of `tile` the sheave on a passive compensator, free along z only.

    Stroke s = z_tip - z_n, upward force on the sheave F0 + k s + c s', beyond the half stroke stiffened by the stops.
    The preload F0 carries the moving mass as well, so that the static stroke is 0 where F0 is the static top
    tension. Returns whether a stop is near.
    """
    stroke = numbers[MIDWAY + TIP_Z] - tile[MIDDLE + Z + j]
    speed = numbers[MIDWAY + TIP_VZ] - tile[MIDDLE + VZ + j]
    force = numbers[SPRING_PRELOAD] + numbers[SPRING_STIFFNESS] * stroke + numbers[SPRING_DAMPING] * speed
    stiffness = numbers[SPRING_STIFFNESS] + c_velocity * numbers[SPRING_DAMPING]
    over = abs(stroke) - numbers[SPRING_HALF_STROKE]
    if over > 0.0:
        side = math.copysign(1.0, stroke)
        push = numbers[SPRING_STOP] * over + numbers[SPRING_STOP_DAMPING] * side * speed
        if push > 0.0:
            force += side * push
            stiffness += numbers[SPRING_STOP] + c_velocity * numbers[SPRING_STOP_DAMPING]
    tile[RX + j] = tile[RY + j] = 0.0
    tile[RZ + j] += numbers[SPRING_MASS] * tile[MIDDLE + AZ + j] - force
    tile[DZZ + j] += c_mass * numbers[SPRING_MASS] + stiffness
    tile[DXX + j] = tile[DYY + j] = 1e30
    tile[DXY + j] = tile[DXZ + j] = tile[DYZ + j] = 0.0
    return over > -0.1 * numbers[SPRING_HALF_STROKE]
