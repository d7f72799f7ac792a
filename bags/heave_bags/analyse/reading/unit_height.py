"""Where a depth sensor says that the unit is; in air, where it reads nothing, how far the drum has paid out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from heave_node.interface.sensors import DEPTH, Water
from heave_node.numerics.constants import SEAWATER_DENSITY, STANDARD_GRAVITY

from heave_bags.analyse.reading.stored import number
from heave_bags.signals import Signal

LEAST_DEPTH = 1.0
"""Depth below which a sensor is taken to be in the water [m]: what it reads in air is its offset and the weather."""


def measured_height(pressure: Signal, payout: Signal, water: Water) -> Signal:
    """Return the height of the unit above still `water`, positive up [m]; empty where its sensor never got wet.

    The `pressure` is absolute [Pa]; `payout` is that of the drum, positive lowers the unit [m]: without it heights in
    air stay unknown.
    """
    depth = np.array([DEPTH.decode((one,), water)[0] for one in pressure.value.tolist()])
    wet = depth > LEAST_DEPTH
    if not wet.any() or not payout.size:
        return Signal(pressure.time[wet], -depth[wet])
    out = payout.at(pressure)
    by_drum = out + np.interp(pressure.time, pressure.time[wet], (depth - out)[wet])
    return Signal(pressure.time, -np.where(wet, depth, by_drum))


def water_of(parameters: Mapping[str, Any]) -> Water:
    """Return the water that the `parameters` of a controller assume; seawater where they are not known."""
    density, gravity = (("water_density", SEAWATER_DENSITY), ("gravity", STANDARD_GRAVITY))
    return Water(number(parameters, *density), number(parameters, *gravity))
