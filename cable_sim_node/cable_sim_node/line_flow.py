"""Motion of the water along the line: current profile with a factor in time, and one regular deep-water wave (Airy)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cable_sim_node.compiled import inner_kernel
from cable_sim_node.line_layout import (
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

Array = NDArray[np.float64]


@inner_kernel
def locate(at: float, table: Array) -> tuple[int, int, float]:
    """Return the rows of `table` around `at` in its increasing first column, and the share of the way from one to the
    other; the same row twice beyond the ends.
    """
    low, high = 0, table.shape[0] - 1
    if at <= table[low, 0]:
        return low, low, 0.0
    if at >= table[high, 0]:
        return high, high, 0.0
    while high - low > 1:
        middle = (low + high) // 2
        if table[middle, 0] <= at:
            low = middle
        else:
            high = middle
    return low, high, (at - table[low, 0]) / (table[high, 0] - table[low, 0])


@inner_kernel
def set_flow(n: int, time: float, nodes: Array, settings: Array, current: Array, schedule: Array, flow: Array) -> None:
    """Set the water's velocity [m/s] and acceleration [m/s^2]: row 0 at the unit, row i + 1 at the middle of segment i.

    `current` has rows (depth, u_x, u_y), `schedule` rows (time, factor). Wave crests pass the origin at time 0.
    """
    low, high, share = locate(time, schedule)
    factor = schedule[low, 1] + share * (schedule[high, 1] - schedule[low, 1])
    uniform = current.shape[0] == 1
    amplitude = settings[WAVE_AMPLITUDE]
    ux, uy = factor * current[0, 1], factor * current[0, 2]
    for i in range(n + 1):
        if not uniform:
            z = nodes[0, Z] if i == 0 else 0.5 * (nodes[i - 1, Z] + nodes[i, Z])
            low, high, share = locate(-z, current)
            ux = factor * (current[low, 1] + share * (current[high, 1] - current[low, 1]))
            uy = factor * (current[low, 2] + share * (current[high, 2] - current[low, 2]))
        flow[i, FLOW_X], flow[i, FLOW_Y], flow[i, FLOW_Z] = ux, uy, 0.0
    if amplitude == 0.0:
        return
    omega, number = settings[WAVE_FREQUENCY], settings[WAVE_NUMBER]
    dx, dy = settings[WAVE_X], settings[WAVE_Y]
    for i in range(n + 1):
        lower, upper = nodes[max(i - 1, 0)], nodes[i]
        px, py, pz = 0.5 * (lower[X] + upper[X]), 0.5 * (lower[Y] + upper[Y]), 0.5 * (lower[Z] + upper[Z])
        phase = number * (dx * px + dy * py) - omega * time
        speed = amplitude * omega * math.exp(number * min(pz, 0.0))
        cosine, sine = speed * math.cos(phase), speed * math.sin(phase)
        flow[i, FLOW_X] += cosine * dx
        flow[i, FLOW_Y] += cosine * dy
        flow[i, FLOW_Z] += sine
        flow[i, FLOW_AX] = omega * sine * dx
        flow[i, FLOW_AY] = omega * sine * dy
        flow[i, FLOW_AZ] = -omega * cosine
