"""Motion of the water along the line: current profile with a factor in time, and one regular deep-water wave (Airy)."""

from __future__ import annotations

import math

from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inner_kernel

from cable_sim_node.line.layout import (
    FLOW_AX,
    FLOW_AY,
    FLOW_AZ,
    FLOW_X,
    FLOW_Y,
    FLOW_Z,
    WAVE_AMPLITUDE,
    WAVE_FREQUENCY,
    WAVE_NUMBER,
    WAVE_X,
    WAVE_Y,
    X,
    Y,
    Z,
)
from cable_sim_node.physics.current import FLOW, between, locate


@inner_kernel
def set_flow(n: int, time: float, nodes: Array, settings: Array, current: Array, schedule: Array, flow: Array) -> None:
    """Set the water's velocity [m/s] and acceleration [m/s^2]: row 0 at the unit, row i + 1 at the middle of segment i.

    Parameters
    ----------
    n : segments in use
    time : [s]
    nodes, settings, flow : arrays of `LineArrays`
    current, schedule : profile of `physics.current`, and rows of time and factor
    """
    low, high, share = locate(time, schedule)
    factor = between(schedule, low, high, share, 1)
    waves = settings[WAVE_AMPLITUDE] > 0.0
    for i in range(n + 1):
        lower, upper, water = nodes[i - 1 if i > 0 else 0], nodes[i], flow[i]
        z = 0.5 * (lower[Z] + upper[Z])
        low, high, share = locate(-z, current)
        water[FLOW_X] = factor * between(current, low, high, share, FLOW)
        water[FLOW_Y] = factor * between(current, low, high, share, FLOW + 1)
        water[FLOW_Z] = 0.0
        if waves:
            add_wave(time, 0.5 * (lower[X] + upper[X]), 0.5 * (lower[Y] + upper[Y]), z, settings, water)


@inner_kernel
def add_wave(time: float, x: float, y: float, z: float, settings: Array, water: Array) -> None:
    """Add the wave's velocity at (x, y, z) to `water`, a row of the flow, and set its acceleration.

    Crests pass the origin at `time` 0 and travel in the direction of `settings`.
    """
    omega, number = settings[WAVE_FREQUENCY], settings[WAVE_NUMBER]
    dx, dy = settings[WAVE_X], settings[WAVE_Y]
    phase = number * (dx * x + dy * y) - omega * time
    speed = settings[WAVE_AMPLITUDE] * omega * math.exp(number * min(z, 0.0))
    cosine, sine = speed * math.cos(phase), speed * math.sin(phase)
    water[FLOW_X] += cosine * dx
    water[FLOW_Y] += cosine * dy
    water[FLOW_Z] += sine
    water[FLOW_AX] = omega * sine * dx
    water[FLOW_AY] = omega * sine * dy
    water[FLOW_AZ] = -omega * cosine
