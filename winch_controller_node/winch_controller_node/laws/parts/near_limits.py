"""Whether the winch comes near to its limits in following the boom tip, or in holding a unit that is far off."""

from __future__ import annotations

import math

from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel

from winch_controller_node.laws.parts.winch_limits import WinchLimits

BEGINS, ENDS = 0.8, 0.4
"""Share of a limit from which on it is near, and below which it is no longer: a sea at the limits comes in groups."""

MEMORY = 30.0
"""Time constant with which a wave, or a swing of the unit, decays [s]: a few groups."""


class NearLimits:
    """Compares speed and acceleration of the boom tip, and what the unit asks for, with what the winch can do.

    Parameters
    ----------
    model : augmented model, sampled
    limits : of the winch
    """

    def __init__(self, model: LinearModel, limits: WinchLimits) -> None:
        assert model.dt is not None
        self._speed = model.row("boom_tip_heave_rate")
        self._acceleration = (self._speed @ model.A - self._speed) / model.dt
        self._kept = math.exp(-model.dt / MEMORY)
        self.take_limits(limits)
        self.reset()

    def take_limits(self, limits: WinchLimits) -> None:
        """Count with other limits of the winch from now on."""
        self._limits = limits

    def reset(self) -> None:
        """Discard the waves that were seen."""
        self._share = 0.0
        self._are_near = False

    def are_near(self, x: Array, unit_use: float) -> bool:
        """Return whether limits are near, or were shortly before; to be asked every tick.

        Parameters
        ----------
        x : state, shape (n,)
        unit_use : what the unit's own error asks for, over what it may [-]
        """
        speed = abs(float(self._speed @ x)) / self._limits.usual_speed
        acceleration = abs(float(self._acceleration @ x)) / self._limits.acceleration
        self._share = max(speed, acceleration, unit_use, self._kept * self._share)
        self._are_near = self._share > (ENDS if self._are_near else BEGINS)
        return self._are_near
