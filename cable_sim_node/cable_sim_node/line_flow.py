"""Motion of the water along the line: current profile with a factor in time, and one regular deep-water wave (Airy)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cable_sim_node.compiled import kernel
from cable_sim_node.line_layout import TIME, WAVE_AMPLITUDE, WAVE_FREQUENCY, WAVE_NUMBER, WAVE_X, WAVE_Y

Array = NDArray[np.float64]


@kernel
def interpolate(at: float, table: Array, column: int) -> float:
    """Interpolate `table[:, column]` over the increasing `table[:, 0]`, constant beyond its ends."""
    last = table.shape[0] - 1
    if at <= table[0, 0]:
        return table[0, column]
    if at >= table[last, 0]:
        return table[last, column]
    low, high = 0, last
    while high - low > 1:
        middle = (low + high) // 2
        if table[middle, 0] <= at:
            low = middle
        else:
            high = middle
    share = (at - table[low, 0]) / (table[high, 0] - table[low, 0])
    return table[low, column] + share * (table[high, column] - table[low, column])


@kernel
def set_flow(
    n: int,
    x: Array,
    moving: Array,
    settings: Array,
    current: Array,
    schedule: Array,
    flow: Array,
    flow_acceleration: Array,
) -> None:
    """Set the water's velocity [m/s] and acceleration [m/s^2]: row 0 at the unit, row i + 1 at the middle of segment i.

    `current` has rows (depth, u_x, u_y), `schedule` rows (time, factor). Wave crests pass the origin at time 0.
    """
    time = moving[TIME]
    factor = interpolate(time, schedule, 1)
    uniform = current.shape[0] == 1
    amplitude = settings[WAVE_AMPLITUDE]
    ux, uy = factor * current[0, 1], factor * current[0, 2]
    for i in range(n + 1):
        if not uniform:
            z = x[0, 2] if i == 0 else 0.5 * (x[i - 1, 2] + x[i, 2])
            ux = factor * interpolate(-z, current, 1)
            uy = factor * interpolate(-z, current, 2)
        flow[i, 0], flow[i, 1], flow[i, 2] = ux, uy, 0.0
    if amplitude == 0.0:
        return
    omega, number = settings[WAVE_FREQUENCY], settings[WAVE_NUMBER]
    dx, dy = settings[WAVE_X], settings[WAVE_Y]
    for i in range(n + 1):
        j = i - 1 if i > 0 else 0
        px, py, pz = 0.5 * (x[j, 0] + x[i, 0]), 0.5 * (x[j, 1] + x[i, 1]), 0.5 * (x[j, 2] + x[i, 2])
        phase = number * (dx * px + dy * py) - omega * time
        speed = amplitude * omega * math.exp(number * min(pz, 0.0))
        cosine, sine = speed * math.cos(phase), speed * math.sin(phase)
        flow[i, 0] += cosine * dx
        flow[i, 1] += cosine * dy
        flow[i, 2] += sine
        flow_acceleration[i, 0] = omega * sine * dx
        flow_acceleration[i, 1] = omega * sine * dy
        flow_acceleration[i, 2] = -omega * cosine
