"""Friction between the wires of a rope: an elastic element that sticks and slides, beside the elastic tension.

While wires stick, the rope is stiffer by a share k of EA; they slide where the element carries a share m of the elastic
tension T, since friction grows with what presses the wires together (a Jenkin element with the limit m T). A rope of
mean tension T_0 that swings by the tension amplitude A T_0, with A small, so has a loop that the frequency does not
change. With the first harmonic of such a loop (Jacobsen & Ayre, Engineering Vibrations, 1958; Caughey, J. Appl. Mech.
27, 1960) its complex stiffness over EA is

    1 + k (p - sin(2 p)/2)/pi + i 4 k r (1 - r)/pi,   r = m/(k A) below 1, cos p = 1 - 2 r.

The loss is largest at r = 1/2: loss factor (k/pi)/(1 + k/2). Larger and smaller swings lose less of their energy, and
swings below r = 1 nothing.
"""

from __future__ import annotations

import math

from heave_node.numerics.compiled import kernel

_LARGEST_AT = 0.5
"""Amplitude at which wires begin to slide over the one with the largest loss."""


@kernel
def jenkin_force(sticking: float, low: float, high: float) -> float:
    """Return the force of a spring that slides: what it has where it sticks, `sticking`, within `low` and `high`."""
    return min(max(sticking, low), high)


def friction_of(loss_factor: float, loss_swing: float) -> tuple[float, float]:
    """Return k and m of a rope, see the text of the module.

    Parameters
    ----------
    loss_factor : loss per cycle over 2 pi times the largest elastic energy of the swing, where it is largest [-]
    loss_swing : A, tension amplitude over mean tension where that is [-]
    """
    sticking = math.pi * loss_factor / (1.0 - _LARGEST_AT * math.pi * loss_factor)
    return sticking, _LARGEST_AT * sticking * loss_swing
