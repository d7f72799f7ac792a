"""Whether the boom tip moves so that the winch comes near to its limits in following it."""

from __future__ import annotations

import math

from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel

from winch_controller_node.laws.parts.winch_limits import WinchLimits

BEGINS, ENDS = 0.8, 0.4
"""Share of a limit from which on it is near, and below which it is no longer: a sea at the limits comes in groups."""

MEMORY = 30.0
"""Time constant with which a wave is forgotten [s]: a few groups."""


class NearLimits:
    """Compares speed and acceleration of the boom tip with what the winch can do.

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
        """Forget the waves that were seen."""
        self._share = 0.0
        self._are_near = False

    def are_near(self, x: Array) -> bool:
        """Return whether limits are near at state `x`, shape (n,), or were shortly before; to be asked every tick."""
        speed = abs(float(self._speed @ x)) / self._limits.speed
        acceleration = abs(float(self._acceleration @ x)) / self._limits.acceleration
        self._share = max(speed, acceleration, self._kept * self._share)
        self._are_near = self._share > (ENDS if self._are_near else BEGINS)
        return self._are_near
