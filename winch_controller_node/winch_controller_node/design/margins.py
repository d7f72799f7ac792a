"""Stability margins of the loop at the winch command, with the exact delay, by python-control."""

from __future__ import annotations

import math
from dataclasses import dataclass

import control
import numpy as np
from heave_node.numerics.arrays import Array, ComplexArray

from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.design.prediction import equivalent_filter
from winch_controller_node.model.lqr import DesignError

FREQUENCIES = 2000


@dataclass(frozen=True)
class Margins:
    """Margins of a loop gain L, broken at the command."""

    gain_up: float  # factor by which the loop gain may grow [-]; inf: without limit
    gain_down: float  # factor by which the loop gain may shrink [-]; 0: without limit
    phase: float  # smallest phase to instability at abs(L) = 1 [rad]; inf: never 1
    delay: float  # smallest further delay to instability [s]; inf: none
    sensitivity_peak: float  # largest abs(1/(1 + L)) [-]


def frequencies(tick_period: float) -> Array:
    """Return angular frequencies up to half the tick rate [rad/s], for a `tick_period` [s]."""
    return np.geomspace(1e-3, math.pi / tick_period, FREQUENCIES)


def state_feedback_loop(design: ControllerDesign, gain: Array, omegas: Array) -> ComplexArray:
    """Return L = G (zI - A)^-1 B at `omegas` [rad/s] when all states are known (LQR).

    G is `gain`, shape (n,); A and B are those of `design`.
    """
    return _transfer(design.model.A, design.model.B[:, 0], gain, design.tick_period, omegas)


def output_feedback_loop(design: ControllerDesign, gain: Array, omegas: Array) -> ComplexArray:
    """Return L at `omegas` [rad/s] with the stationary Kalman filter in the loop of `design` (LQG).

    `gain` has shape (n,). A sensor slower than the tick is treated as one at the tick with the same information per
    second.
    """
    filter_ = equivalent_filter(design)
    n = len(filter_.A)
    G = np.zeros(n)
    G[: design.model.order] = gain
    B = np.zeros(n)
    B[: design.model.order] = design.model.B[:, 0]
    correct = np.eye(n) - filter_.K @ filter_.H
    controller = correct @ (filter_.A - np.outer(B, G))
    L = np.empty(len(omegas), dtype=np.complex128)
    for i, z in enumerate(np.exp(1j * omegas * design.tick_period)):
        measured = filter_.H @ np.linalg.solve(z * np.eye(n) - filter_.A, B)
        L[i] = G @ np.linalg.solve(z * np.eye(n) - controller, z * (filter_.K @ measured))
    return L


def _transfer(A: Array, B: Array, C: Array, dt: float, omegas: Array) -> ComplexArray:
    z = np.exp(1j * omegas * dt)
    resolvent = z[:, None, None] * np.eye(len(A)) - A
    solution: ComplexArray = np.linalg.solve(resolvent, np.broadcast_to(B[:, None], (len(z), len(B), 1)))[:, :, 0]
    return np.asarray(solution @ C)


def margins(omegas: Array, L: ComplexArray) -> Margins:
    """Return the margins of a loop that is stable as it is; `L` is its gain at `omegas` [rad/s].

    Raises DesignError for arrays of different or no length.
    """
    if len(omegas) != len(L) or not len(L):
        raise DesignError("margins need a loop gain at each frequency")
    loop = np.abs(L), np.degrees(np.unwrap(np.angle(L))), omegas
    gains, phases, _, _, crossover, _ = control.stability_margins(loop, returnall=True)
    phases = np.radians(phases)
    return Margins(
        gain_up=float(min(gains[gains > 1.0], default=math.inf)),
        gain_down=float(max(gains[gains < 1.0], default=0.0)),
        phase=float(min(np.abs(phases), default=math.inf)),
        delay=float(min(phases % (2.0 * math.pi) / crossover, default=math.inf)),
        sensitivity_peak=float(np.max(1.0 / np.abs(1.0 + L))),
    )
