"""Quadratic drag in a model that is linear: the unit's damping follows the speed that it is seen to have.

Gains are designed for a unit that hardly moves. One that no winch holds may move by metres, and near the resonance its
motion is then ruled by a drag several times that of the design. At the speed v of the tick the damping is drag |v|, so
that the state moves as quadratic drag lets it. It is split off the exact step of the linear model: half of what it
takes of the unit's speed goes before the step and half after it (Strang, SIAM J. Numer. Anal. 5 (1968) 506).
"""

from __future__ import annotations

import math

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel

from winch_controller_node.model.blocks import CableModel
from winch_controller_node.model.estimator import KalmanEstimator
from winch_controller_node.model.models import shadow_model

DOUBT = 0.3
"""Standard deviation of the drag that is more than the design's damping, as a share of it: coefficients of bodies that
oscillate are known to a third."""

DOUBT_TIME = 1.0
"""Time over which it errs in one direction [s]: a fraction of a wave."""


def kept_speed(cable: CableModel, speed: float, time: float) -> float:
    """Return the share of its speed that drag leaves a unit, beyond what the linear damping of the `cable` takes.

    Parameters
    ----------
    cable : with its quadratic drag
    speed : of the unit [m/s], of either sign
    time : that passes [s]
    """
    return math.exp(-_excess(cable, speed) / cable.a * time)


def _excess(cable: CableModel, speed: float) -> float:
    """Return by how much the damping at a speed [m/s] is more than the linear one [s]."""
    return max(cable.drag * abs(speed) - cable.b, 0.0)


class DragFollower:
    """Has an estimator damp the unit as fast as it sees it move.

    Parameters
    ----------
    model : sampled, of the estimator; its damping is b of the cable
    cable : with its quadratic drag
    """

    def __init__(self, model: LinearModel, cable: CableModel) -> None:
        self._model, self._cable = model, cable
        self._rate = model.state("unit_heave_rate")
        self._noise = model.noise_covariance
        self._is_fast = False

    def take_noise(self, covariance: Array) -> None:
        """Take another `covariance` of the process noise of a tick than the model's, shape (n, n)."""
        self._noise = covariance

    def follow(self, estimator: KalmanEstimator) -> None:
        """Prepare the `estimator` for its next tick; a unit that is slow again gets the model's own matrices back."""
        rate = self._rate
        speed = abs(float(estimator.estimate[rate]))
        excess = _excess(self._cable, speed)
        if excess == 0.0 and not self._is_fast:
            return
        self._is_fast = excess > 0.0
        model, dt = self._model, self._model.dt or 0.0
        half = kept_speed(self._cable, speed, 0.5 * dt)
        transition, command, covariance = model.A.copy(), model.B.copy(), self._noise.copy()
        for matrix in (transition, command, covariance):
            matrix[rate] *= half
        for matrix in (transition, covariance):
            matrix[:, rate] *= half
        covariance[rate, rate] += (DOUBT * excess / self._cable.a * speed) ** 2 * DOUBT_TIME * dt
        estimator.set_step(transition, command, covariance)


class ShadowUnit:
    """The unit as it would move with the winch locked.

    Parameters
    ----------
    cable : that it hangs on
    tick_period : [s]

    Attributes
    ----------
    state : heave [m] and heave rate [m/s], shape (2,)
    """

    def __init__(self, cable: CableModel, tick_period: float) -> None:
        self.state: Array = np.zeros(2)
        self.take_cable(cable, tick_period)

    def take_cable(self, cable: CableModel, tick_period: float) -> None:
        """Go on with another `cable`, in ticks of `tick_period` [s]."""
        self._cable, self._dt = cable, tick_period
        self._model = shadow_model(cable, tick_period)

    def continue_at(self, state: Array) -> None:
        """Go on from another `state`, shape (2,)."""
        self.state = state

    def step(self, boom_tip: Array) -> Array:
        """Advance by a tick and return the state.

        `boom_tip` is its heave [m] and heave rate [m/s] at the start of the tick, shape (2,).
        """
        half = np.array([1.0, kept_speed(self._cable, self.state[1], 0.5 * self._dt)])
        self.state = half * (self._model.A @ (half * self.state) + self._model.B @ boom_tip)
        return self.state
