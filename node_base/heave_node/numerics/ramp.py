"""A start from rest that is twice differentiable, so that neither cable nor filters are kicked."""

from __future__ import annotations

from heave_node.numerics.compiled import inner_kernel

PEAK_OF_RAMP = 1.875
"""Largest rate of the ramp over its mean rate."""


def smooth_ramp(time: float, duration: float) -> tuple[float, float, float]:
    """Return the quintic ramp r(time / duration) from 0 to 1 and its first two time derivatives.

    Parameters
    ----------
    time : since the start of the ramp [s]
    duration : of the ramp [s]; 0 gives r = 1
    """
    if time >= duration:
        return 1.0, 0.0, 0.0
    if time <= 0.0:
        return 0.0, 0.0, 0.0
    x = time / duration
    value = x**3 * (10.0 + x * (6.0 * x - 15.0))
    rate = 30.0 * x**2 * (1.0 - x) ** 2 / duration
    acceleration = 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x) / duration**2
    return value, rate, acceleration


smooth_ramp_kernel = inner_kernel(smooth_ramp)
"""The same for kernels."""
