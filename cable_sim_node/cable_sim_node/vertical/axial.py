"""Vertical motion of unit and cable of changing length (thesis chapter 3).

Small and fast, for identification and as an independent check of the three-dimensional solver. The cable hangs straight
down in still water; the boom tip's heave and the paid-out length are given as samples; slack, quadratic drag and
sections are in. `axial_kernel` has the method.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from heave_node.numerics.arrays import Array
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline

from cable_sim_node.vertical.axial_line import AxialLine
from cable_sim_node.vertical.axial_stepper import AxialError, AxialInput, AxialStepper

LARGEST_STEP = 0.01
"""Integration step [s] unless a caller sets another: 0.005 % amplitude error at 1.26 rad/s (BDF2, (w h)^2 / 3)."""


@dataclass(frozen=True)
class AxialResponse:
    """Answer of `simulate_axial`, one value per sample."""

    time: Array  # [s], 0 at the first sample
    # elevation of the unit above its still-water equilibrium at the initial length with the boom tip at 0 [m], positive
    # up; cable paid out lowers it
    unit_heave: Array
    unit_velocity: Array  # [m/s], positive up
    top_tension: Array  # force on the top end of the cable [N]
    least_tension: Array  # smallest tension along the cable [N]; 0 while any part is slack


def simulate_axial(
    line: AxialLine,
    length: float,
    boom_tip_heave: ArrayLike,
    sample_period: float,
    *,
    payout: ArrayLike | None = None,
    segments: int = 40,
    largest_step: float = LARGEST_STEP,
    allow_slack: bool = True,
) -> AxialResponse:
    """Return the response to sampled boom-tip heave and payout.

    Parameters
    ----------
    line : cable and unit; `axial_line` makes it from the node's parameters
    length : unstretched length out at payout 0 [m]
    boom_tip_heave : samples of the boom tip's elevation [m], positive up
    sample_period : of the samples, and of the answer [s]
    payout : samples of the cable let out beyond `length` [m], positive lowers; None for a locked winch
    segments : elements along the cable
    largest_step : the sample period is divided into equal steps no longer than this [s]
    allow_slack : False lets the cable carry compression (a linear material, for comparison with linear theory)

    Both inputs are interpolated by a cubic spline. At the first sample the whole cable and the unit move steadily at
    the speed of the cable's top end, so start the samples gently, or leave out the first transient.

    Raises
    ------
    AxialError
        for samples that are not finite or too few, a length that is hauled in to nothing, or a step without solution.
    """
    heave = _samples(boom_tip_heave, "boom_tip_heave")
    paid = np.zeros_like(heave) if payout is None else _samples(payout, "payout", len(heave))
    if not (sample_period > 0.0 and largest_step > 0.0 and segments >= 1):
        raise AxialError(
            f"sample_period {sample_period}, largest_step {largest_step} and segments {segments} must be positive"
        )
    substeps = max(1, math.ceil(sample_period / largest_step - 1e-9))
    time = sample_period * np.arange(len(heave), dtype=np.float64)
    ends = np.column_stack(
        [series for values in (heave, paid) for series in (values, CubicSpline(time, values)(time, 1))]
    )
    stepper = AxialStepper(
        line,
        length,
        AxialInput(*ends[0]),
        segments=segments,
        duration=sample_period,
        substeps=substeps,
        allow_slack=allow_slack,
    )
    states = np.vstack([stepper.state, stepper.follow(ends[1:])])
    return AxialResponse(time, *np.ascontiguousarray(states.T))


def _samples(values: ArrayLike, name: str, count: int | None = None) -> Array:
    samples = np.asarray(values, dtype=np.float64)
    if samples.ndim != 1 or len(samples) < 4:
        raise AxialError(f"{name} must be a series of at least 4 samples; got shape {samples.shape}")
    if not np.all(np.isfinite(samples)):
        raise AxialError(f"{name}[{int(np.argmin(np.isfinite(samples)))}] is not a finite number")
    if count is not None and len(samples) != count:
        raise AxialError(
            f"{name} has {len(samples)} samples and boom_tip_heave {count}: both must have the same number"
        )
    return samples
