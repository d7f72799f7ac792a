"""What is believed of the loop: gates, estimator, sea, and the shadow of the uncompensated unit, tick by tick.

The estimator sees the loop without the mean payout's own motion, see `mean_motion`.
"""

from __future__ import annotations

import math

import numpy as np
from heave_node.arrays import Array

from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.estimation.handover import hand_over, hand_over_standing
from winch_controller_node.estimation.observation import Observer
from winch_controller_node.estimation.sea_adaptation import SeaTracker
from winch_controller_node.interface.readings import Measurements
from winch_controller_node.interface.sensors import DEPTH_BIAS
from winch_controller_node.model.loop_rows import loop_rows
from winch_controller_node.model.models import shadow_model
from winch_controller_node.motion.mean_motion import MeanMotion


class LoopEstimation:
    """Estimate of the loop and of what the unit would do with the winch locked.

    Parameters
    ----------
    design : model, measurements and noise
    motion : of the mean payout

    Attributes
    ----------
    estimator, observer : the filter and the gates in front of it
    rows : of the design's model
    uncompensated : heave and rate of the unit with the winch locked, shape (2,) [m], [m/s]
    depth_reading : heave that the depth sensor read in this tick, the mean payout's share off [m]; None: none came
    """

    def __init__(self, design: ControllerDesign, motion: MeanMotion) -> None:
        self._motion = motion
        self.estimator = design.make_estimator()
        self.observer = Observer(design, design.parameters.health)
        self.uncompensated: Array = np.zeros(2)
        self.depth_reading: float | None = None
        self._sea = SeaTracker(design)
        self.take_design(design)

    def take_design(self, design: ControllerDesign) -> None:
        """Refer to a design from now on, whose model the estimator has already."""
        self._design = design
        self.observer.take_design(design)
        self.rows = loop_rows(design.model)
        self._shadow = shadow_model(design.cable, design.tick_period)
        self._sea.refer_to(design)

    def carry(self, design: ControllerDesign, matrix: Array, tick: int) -> None:
        """Go on at `tick` with an estimator of `design`, whose states are `matrix` times the present ones."""
        estimate, covariance = matrix @ self.estimator.estimate, matrix @ self.estimator.covariance @ matrix.T
        self.estimator = design.make_estimator()
        self.estimator.reset(estimate, covariance)
        self.estimator.step(tick, 0.0, [])
        self._motion.state = matrix @ self._motion.state
        self.observer.forget_shares()

    def step(self, tick: int, measurements: Measurements, command: float) -> Array:
        """Gate, take the mean payout's share off, estimate; return the estimate at t_k, shape (n,).

        `command` is the share of the last command that compensated, in the terms of the model.
        """
        self.observer.remember_share(tick, self._motion.state)
        rate = float(self.rows.payout_rate @ (self.estimator.estimate + self._motion.state))
        readings = self.observer.observe(tick, measurements, self.estimator, rate)
        estimate = self.estimator.step(tick, command, readings)
        self.depth_reading = next((r.value for r in reversed(readings) if r.name == "unit_heave"), None)
        self.observer.learn(self.estimator)
        self._follow_sea(estimate)
        return estimate

    def _follow_sea(self, estimate: Array) -> None:
        """Let the estimator's driving noise follow the sea that is there."""
        if not self._design.parameters.estimator.sea_adaptation:
            return
        tip, rate = self.rows.tip @ estimate
        noise = self._sea.update(float(tip), float(rate))
        if noise is not None:
            self.estimator.set_process_noise(noise)

    def advance_shadow(self, estimate: Array) -> Array:
        """Advance what the unit would do with the winch locked; return its heave and rate, shape (2,)."""
        self.uncompensated = self._shadow.A @ self.uncompensated + self._shadow.B @ (self.rows.tip @ estimate)
        return self.uncompensated

    def restart_shadow(self, estimate: Array) -> None:
        """Let the shadow go on from where the unit is, about the payout that is out."""
        self.uncompensated = estimate[self.rows.unit_states] + self.rows.winch @ estimate

    def unit_heave(self, estimate: Array) -> float:
        """Return the unit's heave about where the mean payout would have it at rest [m]."""
        mean_state = self._motion.state
        return float(self.rows.unit @ (estimate + mean_state) + self.rows.payout @ mean_state)

    @property
    def mean_depth(self) -> float:
        """Estimated mean depth of the unit, positive down [m]; NaN before the first depth reading."""
        zero = self.observer.depth_zero
        if zero is None:
            return math.nan
        payout = float(self.rows.payout @ self._motion.state) + self._motion.left_over.point.payout
        return zero + self._depth_bias() + payout * (1.0 + self.observer.stretch_per_payout)

    def payout_at(self, depth: float) -> float:
        """Return the mean payout [m] that brings the unit to a mean depth [m]; NaN before the first depth reading."""
        zero = self.observer.depth_zero
        if zero is None:
            return math.nan
        return (depth - zero - self._depth_bias()) / (1.0 + self.observer.stretch_per_payout)

    def _depth_bias(self) -> float:
        """Return how much deeper the mean is than the first reading [m]."""
        model = self._design.model
        return -float(self.estimator.estimate[model.state(DEPTH_BIAS)]) if model.has_state(DEPTH_BIAS) else 0.0

    def hand_over(self, tick: int, *, tension: float | None) -> None:
        """Make the present depth of the unit the mean and go on from there; see `handover`.

        Parameters
        ----------
        tick : the present one
        tension : measured top tension [N] under a unit that stood until now; None: it hung
        """
        motion = self._motion
        now = (self._design.model, self.estimator.estimate, self.estimator.covariance, motion.state)
        if tension is None:
            after = hand_over(*now)
        else:
            cable = self._design.cable
            pull = (tension - cable.static_tension) / cable.stiffness
            heave = self.observer.unit_heave_reading(motion.state, self.rows.unit_states[0])
            after = hand_over_standing(*now, pull=pull, heave=heave)
        motion.mean.jump_to(motion.mean.point.payout + after.lowered)
        motion.state = after.mean_state
        self.estimator.reset(after.estimate, after.covariance)
        self.estimator.step(tick, 0.0, [])
        motion.left_over.jump_to(0.0)
