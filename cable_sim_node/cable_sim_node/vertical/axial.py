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

from cable_sim_node.errors import PlantError
from cable_sim_node.vertical import axial_layout as at
from cable_sim_node.vertical.axial_kernel import integrate
from cable_sim_node.vertical.axial_line import AxialLine

LARGEST_STEP = 0.01
"""Integration step [s] unless a caller sets another: 0.005 % amplitude error at 1.26 rad/s (BDF2, (w h)^2 / 3)."""


class AxialError(PlantError, ValueError):
    """An axial run that cannot be done or did not converge; the message says what and when."""


@dataclass(frozen=True)
class AxialResponse:
    """Answer of `simulate_axial`, one value per sample.

    Attributes
    ----------
    time : [s], 0 at the first sample
    unit_heave : elevation of the unit above its still-water equilibrium at the initial length with the boom tip at 0
        [m], positive up; cable paid out lowers it
    unit_velocity : [m/s], positive up
    top_tension : force on the top end of the cable [N]
    least_tension : smallest tension along the cable [N]; 0 while any part is slack
    """

    time: Array
    unit_heave: Array
    unit_velocity: Array
    top_tension: Array
    least_tension: Array


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
    fine = np.linspace(0.0, time[-1], (len(heave) - 1) * substeps + 1, dtype=np.float64)
    top, top_velocity = _interpolate(time, heave, fine)
    feed, feed_rate = _interpolate(time, paid, fine)
    shortest = length + float(feed.min())
    if not shortest > 0.0:
        raise AxialError(f"the cable is hauled in to {shortest:g} m: its length must stay positive")
    motion = np.column_stack((top, top_velocity, length + feed, feed_rate))
    answer = np.empty((len(heave), at.ANSWER_COLUMNS))
    failed = integrate(
        axial_arrays(line, segments, allow_slack=allow_slack), motion, sample_period / substeps, substeps, answer
    )
    if failed >= 0:
        raise AxialError(
            f"the axial cable has no solution at {fine[failed]:.3f} s: check the motion at that time or use "
            "shorter steps"
        )
    return _response(time, answer, -length - line.static_stretch(length))


def _response(time: Array, answer: Array, datum: float) -> AxialResponse:
    """Return what the kernel's `answer` at each `time` says, the unit's heave about its place at rest, `datum` [m]."""
    return AxialResponse(
        time=time,
        unit_heave=answer[:, at.UNIT_ELEVATION] - datum,
        unit_velocity=answer[:, at.UNIT_VELOCITY].copy(),
        top_tension=answer[:, at.TOP_TENSION].copy(),
        least_tension=answer[:, at.LEAST_TENSION].copy(),
    )


def axial_arrays(line: AxialLine, segments: int, *, allow_slack: bool = True) -> at.AxialArrays:
    """Return a `line` of so many `segments` as the kernels take it; without `allow_slack` as a linear material."""
    nodes, elements = at.allocate_nodes(segments)
    return at.AxialArrays(
        sections=line.section_table(),
        bodies=np.array([(b.label, b.inertia, b.weight, b.drag) for b in line.clumps]).reshape(-1, 4),
        unit=np.array([line.unit.inertia, line.unit.weight, line.unit.drag]),
        nodes=nodes,
        elements=elements,
        is_linear=not allow_slack,
    )


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


def _interpolate(time: Array, samples: Array, fine: Array) -> tuple[Array, Array]:
    """Return values and rates of the spline through the samples at the times `fine`."""
    spline = CubicSpline(time, samples)
    return np.ascontiguousarray(spline(fine)), np.ascontiguousarray(spline(fine, 1))
