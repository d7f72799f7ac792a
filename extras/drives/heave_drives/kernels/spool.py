"""Rope on a drum: the arm at which it pulls changes from layer to layer; falls (reeving) divide its tension.

Payout is that of the load. With n falls the drum lets out n metres of rope for each metre of payout, and feels T/n.
A layer lies in the grooves of the one below, so that radii differ by sqrt(3)/2 rope diameters; over its last turn it
climbs to the next one.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inner_kernel

from heave_drives.parameters import SpoolParameters


class Spool(NamedTuple):
    """The same in numbers."""

    full: Array  # rope on the drum at which each layer is full [m], shape (layers,)
    radius: Array  # of the rope's centre line in each layer [m], shape (layers,)
    rope_at_zero: float  # rope on the drum at payout 0 [m]
    falls: float  # parts of rope that carry the load [-]


def make_spool(parameters: SpoolParameters, payout_minimum: float, payout_maximum: float) -> Spool:
    """Return the spool of `parameters`, with layers enough for all the rope on the drum at `payout_minimum` [m].

    Raises ValueError where `payout_maximum` [m] needs more rope than there is.
    """
    parameters.check_rope(payout_maximum)
    falls = float(parameters.falls)
    if parameters.turns_per_layer == 0:
        radius = np.array([parameters.radius_of_layer(0)])
        return Spool(np.array([math.inf]), radius, parameters.rope_at_zero, falls)
    most = parameters.rope_at_zero - falls * payout_minimum
    radii = [parameters.radius_of_layer(0)]
    full = [2.0 * math.pi * parameters.turns_per_layer * radii[0]]
    while full[-1] < most:
        radii.append(parameters.radius_of_layer(len(radii)))
        full.append(full[-1] + 2.0 * math.pi * parameters.turns_per_layer * radii[-1])
    return Spool(np.array(full), np.array(radii), parameters.rope_at_zero, falls)


@inner_kernel
def arm_at(spool: Spool, payout: float) -> tuple[float, float]:
    """Return the arm of `spool` [m], metres of payout per radian of the drum, and its change with `payout` [-]."""
    rope = spool.rope_at_zero - spool.falls * payout
    layer, top = 0, spool.radius.size - 1
    while layer < top and rope > spool.full[layer]:
        layer += 1
    radius = spool.radius[layer]
    if layer < top:
        turn = 2.0 * math.pi * radius
        climbed = (rope - spool.full[layer]) / turn + 1.0
        if climbed > 0.0:
            rise = spool.radius[layer + 1] - radius
            return (radius + climbed * rise) / spool.falls, -rise / turn
    return radius / spool.falls, 0.0
