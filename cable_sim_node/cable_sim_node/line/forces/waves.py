"""Motion of the water in waves: the sum of linear components in deep water (Airy).

With theta = omega_e t - k (x cos d + y sin d) + phase, t counted from the start of the ramp, a component a adds to

    elevation               a cos theta
    velocity along d, up    a omega e^{kz} (cos theta, -sin theta)
    acceleration            -a omega^2 e^{kz} (sin theta, cos theta)

with k = omega^2/g, z taken as 0 above still water. The ramp r multiplies elevation and velocity, and the acceleration
is the derivative of that. Arguments: `line` the arrays, `x`, `y`, `z` [m] a place, `time` [s].
"""

from __future__ import annotations

import math

from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inner_kernel
from heave_node.numerics.kinematics import smooth_ramp_kernel

from cable_sim_node.line import layout as at
from cable_sim_node.line.arrays import LineArrays
from cable_sim_node.line.forces.direction import direction_at

_REACH = 10.0
"""Depth over 1/k below which a component is left out: e^{-10} of its motion at the surface."""


@inner_kernel
def surface_at(line: LineArrays, x: float, y: float, time: float) -> tuple[float, float]:
    """Return the height of the surface [m] and its rate [m/s]."""
    numbers, waves = line.numbers, line.water[int(line.numbers[at.PROFILE_END]) :]
    if numbers[at.WAVES] == 0.0:
        return 0.0, 0.0
    since, height, rate = time - numbers[at.WAVE_START], 0.0, 0.0
    for c in range(waves.shape[0]):
        theta = waves[c, at.WAVE_ENCOUNTER] * since + waves[c, at.WAVE_PHASE]
        theta -= waves[c, at.WAVE_NUMBER_X] * x + waves[c, at.WAVE_NUMBER_Y] * y
        height += waves[c, at.WAVE_AMPLITUDE] * math.cos(theta)
        rate -= waves[c, at.WAVE_AMPLITUDE] * waves[c, at.WAVE_ENCOUNTER] * math.sin(theta)
    ramp, ramp_rate, _ = smooth_ramp_kernel(since, numbers[at.WAVE_RAMP])
    return ramp * height, ramp * rate + ramp_rate * height


@inner_kernel
def add_waves(line: LineArrays, x: float, y: float, z: float, time: float, tile: Array, place: int) -> None:
    """Add the waves' velocity to the flow at a `place` of `tile`, and set its acceleration."""
    numbers, waves = line.numbers, line.water[int(line.numbers[at.PROFILE_END]) :]
    since, wet = time - numbers[at.WAVE_START], min(z, 0.0)
    u = v = w = ax = ay = az = 0.0
    for c in range(waves.shape[0]):
        depth = waves[c, at.WAVE_NUMBER] * wet
        if depth < -_REACH:
            break
        theta = waves[c, at.WAVE_ENCOUNTER] * since + waves[c, at.WAVE_PHASE]
        theta -= waves[c, at.WAVE_NUMBER_X] * x + waves[c, at.WAVE_NUMBER_Y] * y
        speed = waves[c, at.WAVE_SPEED] * math.exp(depth)
        ahead, down = speed * math.cos(theta), speed * math.sin(theta)
        omega, cosine, sine = waves[c, at.WAVE_FREQUENCY], waves[c, at.WAVE_COSINE], waves[c, at.WAVE_SINE]
        u += ahead * cosine
        v += ahead * sine
        w -= down
        ax -= omega * down * cosine
        ay -= omega * down * sine
        az -= omega * ahead
    ramp, ramp_rate, _ = smooth_ramp_kernel(since, numbers[at.WAVE_RAMP])
    tile[at.FLOW_X + place] += ramp * u
    tile[at.FLOW_Y + place] += ramp * v
    tile[at.FLOW_Z + place] += ramp * w
    tile[at.FLOW_AX + place] = ramp * ax + ramp_rate * u
    tile[at.FLOW_AY + place] = ramp * ay + ramp_rate * v
    tile[at.FLOW_AZ + place] = ramp * az + ramp_rate * w


@inner_kernel
def add_wave_force(tile: Array, count: int) -> None:
    """Add the force of accelerated water on the first `count` segments of `tile` to their ends' residuals.

    Half of it at each: (displaced + added mass) of the water's acceleration, less that of the added mass along e.
    """
    for j in range(count):
        ex, ey, ez = direction_at(tile, j)
        half = 0.5 * tile[at.LENGTH + j]
        ax, ay, az = tile[at.FLOW_AX + j + 1], tile[at.FLOW_AY + j + 1], tile[at.FLOW_AZ + j + 1]
        added = half * tile[at.ADDED_MASS + j]
        moved = half * tile[at.DISPLACED + j] + added
        along = added * (ex * ax + ey * ay + ez * az)
        px, py, pz = moved * ax - along * ex, moved * ay - along * ey, moved * az - along * ez
        tile[at.RX + j] -= px
        tile[at.RY + j] -= py
        tile[at.RZ + j] -= pz
        tile[at.END_RX + j + 1] -= px
        tile[at.END_RY + j + 1] -= py
        tile[at.END_RZ + j + 1] -= pz
