"""Adaptation to the sea that is there: the estimator's driving noise follows the boom-tip motion it sees.

The process noise of the waves goes with the square of their height. Only the noise is scaled, no state changes its
meaning, so that nothing jumps and no redesign is needed; gains do not depend on the height of a sea at all.
"""

from __future__ import annotations

import math

import numpy as np
from heave_node.arrays import Array

from winch_controller_node.design.design import ControllerDesign

MEMORY = 600.0
"""Time constant of the running variances [s]: about 60 waves, a height good to 10 %."""

PATIENCE = 200.0
"""No adaptation before so much has been seen [s]."""

STEP = 0.15
"""The noise is changed when the height has changed by this share since the last time."""

SMALLEST, LARGEST = 0.05, 20.0
"""Range of the height ratio; beyond it the sensor is doubted, not the sea."""


class SeaTracker:
    """Running estimate of the boom-tip motion against that of the design.

    Parameters
    ----------
    design : what the ratios refer to
    """

    def __init__(self, design: ControllerDesign) -> None:
        self._seen = 0.0
        self._variance = 0.0
        self._applied = 1.0
        self.refer_to(design)

    def refer_to(self, design: ControllerDesign) -> None:
        """Refer to another design from now on."""
        self._dt = design.tick_period
        self._design_variance = design.sigma["boom_tip_heave"] ** 2
        self._quiet = design.model.noise_covariance - design.sea_noise
        self._sea_noise = design.sea_noise
        self._applied = 1.0

    @property
    def height_ratio(self) -> float:
        """Height of the boom-tip motion over that of the design; 1 until enough has been seen."""
        if self._seen < PATIENCE:
            return 1.0
        return float(np.clip(math.sqrt(self._variance / self._design_variance), SMALLEST, LARGEST))

    def update(self, heave: float) -> Array | None:
        """Take in the estimated boom-tip heave of a tick [m].

        Returns the covariance of the process noise to use from now on, shape (n, n), when the sea has changed enough;
        else None.
        """
        self._seen += self._dt
        # a plain mean at first, then one that forgets
        share = self._dt / min(self._seen, MEMORY)
        self._variance += share * (heave**2 - self._variance)
        if abs(self.height_ratio / self._applied - 1.0) < STEP:
            return None
        self._applied = self.height_ratio
        return self._quiet + self._applied**2 * self._sea_noise
