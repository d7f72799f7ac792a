"""The water's surface: where it is, and how it moves. It is that of still water, z = 0, and the waves of `forces.flow`.

Arguments: `numbers` of the line; `x`, `y` [m] where it is asked for, `time` [s].
"""

from __future__ import annotations

import math

from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inner_kernel

from cable_sim_node.line.layout import WAVE_AMPLITUDE, WAVE_FREQUENCY, WAVE_NUMBER, WAVE_X, WAVE_Y


@inner_kernel
def surface_at(x: float, y: float, time: float, numbers: Array) -> tuple[float, float]:
    """Return the height of the surface [m] and its rate [m/s]."""
    if numbers[WAVE_AMPLITUDE] == 0.0:
        return 0.0, 0.0
    phase = numbers[WAVE_NUMBER] * (numbers[WAVE_X] * x + numbers[WAVE_Y] * y) - numbers[WAVE_FREQUENCY] * time
    amplitude = numbers[WAVE_AMPLITUDE]
    return amplitude * math.cos(phase), amplitude * numbers[WAVE_FREQUENCY] * math.sin(phase)
