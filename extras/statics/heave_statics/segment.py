"""One elastic segment under a uniform load, in closed form, with its exact derivatives.

The tension vector varies linearly along the segment, tau(s) = tau_0 - q s, q the load per unstretched length (weight in
water and drag), and dr/ds = tau (1/T + 1/EA) (thesis Eq. 2.21-2.24). Thesis Eq. 2.31-2.33 integrate it with differences
of inverse hyperbolic sines over the load, which fail for a neutrally buoyant cable. With T0, T1 the end tensions,
d = |tau_1 - tau_0| and a = d/(T0 + T1) the same integral is

    int ds/T = l * 2/(T0 + T1) * atanh(a)/a

in which the limits q -> 0 (a straight segment) and a vertical cable are ordinary points.
"""

from __future__ import annotations

import math

from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inner_kernel, kernel

SERIES_BELOW = 0.2
"""Value of `a` below which power series in a^2 replace the closed forms, which would cancel."""

SERIES_TERMS = 14

SMALLEST_GAP = 1e-24
"""Floor of 1 - a^2: a segment folded upon itself has infinite compliance across; this keeps it a number."""


@inner_kernel
def hyperbolic_functions(a: float, gap: float) -> tuple[float, float, float, float]:
    """Return f = atanh(a)/a, phi = (f - 1)/a^2, psi = f'/a and chi = phi'/a for 0 <= a < 1, `gap` = 1 - a^2."""
    if a < SERIES_BELOW:
        f, phi, psi, chi = 1.0, 0.0, 0.0, 0.0
        power = 1.0
        square = a * a
        for k in range(SERIES_TERMS):  # atanh(a)/a = sum a^2k/(2k + 1)
            f += power * square / (2 * k + 3)
            phi += power / (2 * k + 3)
            psi += power * (2 * k + 2) / (2 * k + 3)
            chi += power * (2 * k + 2) / (2 * k + 5)
            power *= square
        return f, phi, psi, chi
    f = 0.5 * math.log((1.0 + a) * (1.0 + a) / gap) / a
    phi = (f - 1.0) / (a * a)
    psi = (1.0 / gap - f) / (a * a)
    chi = (psi - 2.0 * phi) / (a * a)
    return f, phi, psi, chi


@inner_kernel
def _products(start: Array, load: Array, length: float) -> tuple[float, float, float, float, float, float]:
    """Return T0, T1, tau0.tau1, tau_m.(tau1 - tau0), |tau0 x tau1|^2, |tau1 - tau0|^2; tau_m is the mean of both."""
    dot_start, dot_middle, cross, change_squared, t1 = 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(3):
        end = start[i] - load[i] * length
        t1 += end * end
        dot_start += start[i] * end
        change_squared += (load[i] * length) ** 2
        dot_middle -= load[i] * length * (start[i] - 0.5 * load[i] * length)
        j, k = (i + 1) % 3, (i + 2) % 3
        cross += (length * (start[j] * load[k] - start[k] * load[j])) ** 2
    t0 = math.sqrt(start[0] ** 2 + start[1] ** 2 + start[2] ** 2)
    return t0, math.sqrt(t1), dot_start, dot_middle, cross, change_squared


@kernel
def segment_span(
    start: Array, load: Array, length: float, stiffness: float, span: Array, by_tension: Array, by_load: Array
) -> float:
    """Fill the span of one segment and its derivatives; return the integral of the tension along it [N m].

    Parameters
    ----------
    start : tension vector at the segment's start, pointing along increasing s [N]
    load : external force per unstretched length q [N/m], shape (3,)
    length : unstretched [m]
    stiffness : EA [N]
    span : out, end minus start position [m]
    by_tension : out, shape (3, 3), d span / d start at constant load [m/N]; symmetric and never negative
    by_load : out, shape (3, 3), d span / d load at constant start [m^2/N]
    """
    t0, t1, dot_start, dot_middle, cross, change_squared = _products(start, load, length)
    total = t0 + t1
    if total <= 0.0:
        span[:] = 0.0
        by_tension[:] = 0.0
        by_load[:] = 0.0
        return 0.0
    # T0 T1 + tau0.tau1, without cancellation when the ends pull in opposite directions
    together = t0 * t1 + dot_start if dot_start >= 0.0 else cross / (t0 * t1 - dot_start)
    gap = max(2.0 * together / (total * total), SMALLEST_GAP)
    a = min(math.sqrt(change_squared) / total, 1.0)
    f, phi, psi, chi = hyperbolic_functions(a, gap)
    sigma = 2.0 / total
    j0 = sigma * f
    j1 = -dot_middle * sigma**3 * phi / 4.0
    for i in range(3):
        change_i = -load[i] * length
        middle_i = start[i] + 0.5 * change_i
        span[i] = length * (middle_i * j0 + change_i * j1 + middle_i / stiffness)
        for j in range(3):
            change_j = -load[j] * length
            middle_j = start[j] + 0.5 * change_j
            tangent0 = start[j] / t0 if t0 > 0.0 else 0.0
            tangent1 = (start[j] + change_j) / t1 if t1 > 0.0 else 0.0
            # derivatives by the middle tension at constant change ...
            sigma_m = -0.5 * sigma**2 * (tangent0 + tangent1)
            j0_m = sigma_m / gap
            j1_m = -change_j * sigma**3 * phi / 4.0 - dot_middle * sigma**2 * sigma_m / (4.0 * gap)
            # ... and by the change at constant middle tension
            sigma_c = -0.25 * sigma**2 * (tangent1 - tangent0)
            j0_c = sigma_c / gap + sigma**3 * psi * change_j / 4.0
            j1_c = -middle_j * sigma**3 * phi / 4.0
            j1_c -= dot_middle / 4.0 * (sigma**2 * sigma_c / gap + sigma**5 * chi * change_j / 4.0)
            by_middle = middle_i * j0_m + change_i * j1_m
            by_change = middle_i * j0_c + change_i * j1_c
            if i == j:
                by_middle += j0 + 1.0 / stiffness
                by_change += j1
            by_tension[i, j] = length * by_middle
            by_load[i, j] = -(length**2) * (0.5 * by_middle + by_change)
    energy = 0.5 * (t0 + t1)
    for i in range(3):
        middle_i = start[i] - 0.5 * load[i] * length
        energy += middle_i * (span[i] / length - middle_i / stiffness)
    return 0.5 * length * energy
