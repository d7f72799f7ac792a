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
    loop = control.ss(design.model.A, design.model.B, gain[None], 0.0, design.tick_period)
    return np.asarray(loop(np.exp(1j * omegas * design.tick_period)))


def output_feedback_loop(design: ControllerDesign, gain: Array, omegas: Array) -> ComplexArray:
    """Return L at `omegas` [rad/s] with the stationary Kalman filter in the loop of `design` (LQG).

    `gain` has shape (n,). A sensor slower than the tick is treated as one at the tick with the same information per
    second.
    """
    filter_ = equivalent_filter(design)
    A, H, K, n, dt = filter_.A, filter_.H, filter_.K, len(filter_.A), design.tick_period
    G, B = np.zeros((1, n)), np.zeros((n, 1))
    G[0, : design.model.order], B[: design.model.order] = gain, design.model.B
    plant = control.ss(A, B, H, 0.0, dt)
    controller = control.ss((np.eye(n) - K @ H) @ (A - B @ G), K, G, 0.0, dt)
    z = np.exp(1j * omegas * dt)
    return np.asarray(z * np.einsum("jk,jk->k", controller(z)[0], plant(z)[:, 0]))


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
