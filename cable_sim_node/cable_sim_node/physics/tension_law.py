"""The tension law of a cable: T = EA e (1 + q e + c e^2) at strain e > 0.

Arguments: `stiffness` is EA [N], `quadratic` and `cubic` are the coefficients q and c.
"""

from __future__ import annotations

import math

from heave_node.numerics.compiled import inner_kernel, kernel
from heave_node.numerics.constants import LARGEST_STRAIN


@inner_kernel
def stiffening(quadratic: float, cubic: float, strain: float) -> float:
    """Return the tension at `strain` over that of a linear cable with the same EA."""
    return 1.0 + strain * (quadratic + cubic * strain)


def yielding_words(quadratic: float, cubic: float) -> str:
    """Return in words that the law with these coefficients does not carry a cable at rest."""
    return (
        "the cable's tension law carries no load at the static strain: with stiffness_quadratic = "
        f"{quadratic:g} and stiffness_cubic = {cubic:g} the tension falls there as the strain rises"
    )


def overstrained_words(strain: float, stiffness: float) -> str:
    """Return in words that a cable is strained too much at rest; "" where its `strain` [-] is at most LARGEST_STRAIN.

    `stiffness` is the EA [N] that the user gave.
    """
    if strain <= LARGEST_STRAIN:
        return ""
    return (
        f"the cable would be strained by {100.0 * strain:.3g} % at rest, more than {100.0 * LARGEST_STRAIN:g} %: it "
        f"would part; check cable.axial_stiffness ({stiffness:g} N: kN or MN taken for N?)"
    )


@kernel
def tangent_stiffness(stiffness: float, quadratic: float, cubic: float, strain: float) -> float:
    """Return the derivative of the tension by the strain [N] at `strain`."""
    return stiffness * (1.0 + strain * (2.0 * quadratic + 3.0 * cubic * strain))


@kernel
def strain_at(stiffness: float, quadratic: float, cubic: float, tension: float) -> float:
    """Return the strain at which the law gives `tension` [N]; NaN where it does not reach it."""
    strain = tension / stiffness
    for _ in range(50):
        value = stiffness * strain * stiffening(quadratic, cubic, strain) - tension
        slope = tangent_stiffness(stiffness, quadratic, cubic, strain)
        if slope <= 0.0:
            return math.nan
        change = value / slope
        strain -= change
        if abs(change) < 1e-15 * (1e-12 + abs(strain)):
            break
    return strain


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
