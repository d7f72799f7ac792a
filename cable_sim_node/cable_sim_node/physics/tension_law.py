"""The tension law of a cable: T = EA e (1 + q e + c e^2) at strain e > 0.

Arguments: `stiffness` is EA [N], `quadratic` and `cubic` are the coefficients q and c.
"""

from __future__ import annotations

import math

from heave_node.numerics.compiled import inner_kernel, kernel


@inner_kernel
def stiffening(quadratic: float, cubic: float, strain: float) -> float:
    """Return the tension at `strain` over that of a linear cable with the same EA."""
    return 1.0 + strain * (quadratic + cubic * strain)


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
