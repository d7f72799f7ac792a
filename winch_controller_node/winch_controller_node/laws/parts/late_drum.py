"""What a state feedback may ask of a drum that the boom tip outruns: turn early, and catch up without haste.

A sea that asks for more acceleration than the winch has makes the drum late. A linear law sees a large error then and
asks for all of the winch's speed to take it back; the drum that comes too late cannot stop where it should, and soon
moves against the boom tip: the unit swings more than without compensation. Here the drum

- turns before the boom tip does, as far as its acceleration limit will make it late, so that it is early as long as it
  is late, and moves with the boom tip on the whole;
- takes an error back no faster than it can stop again, with a small part of its acceleration: what is beyond that is
  forgiven, as if the drum stood nearer.

While the acceleration of the boom tip is within the limit, and the drum follows it to a centimetre, both are next to
nothing.
"""

from __future__ import annotations

import math

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel

from winch_controller_node.laws.parts.governor import drum_ahead
from winch_controller_node.laws.parts.tip_ahead import tip_ahead
from winch_controller_node.laws.parts.winch_limits import WinchLimits
from winch_controller_node.parameters.model import WinchModelParameters

HORIZON = 2.5
"""Time that the boom tip's speed is foreseen [s]: to its next turn in a steep sea."""

CATCHING_UP = 0.1
"""Share of the acceleration limit with which a drum that catches up can stop; the boom tip takes the rest."""


class LateDrum:
    """Foresees where the drum will be late, and bounds what its error may ask for.

    Parameters
    ----------
    model : augmented model, one input
    winch : that it describes, a speed servo
    limits : of that winch
    gain : of the law, u = -gain x, shape (n,)
    largest_share : of the command that the unit's own error may ask for [m/s]
    """

    def __init__(
        self,
        model: LinearModel,
        winch: WinchModelParameters,
        limits: WinchLimits,
        *,
        gain: Array,
        largest_share: float,
    ) -> None:
        assert model.dt is not None
        self._dt = model.dt
        heave, rate, _ = tip_ahead(model, winch.command_delay)
        # payout lowers the unit: what is paid out beyond the boom tip's heave
        self._error = drum_ahead(model, winch)[0] - heave
        rows = [rate]
        for _ in range(round(HORIZON / model.dt)):
            rows.append(rows[-1] @ model.A)
        self._tip_rates = np.array(rows)
        self._payout_gain = float(gain[model.state("payout")])
        self._unit_gain = float(gain[model.state("unit_heave")])
        self._largest_share = largest_share
        self.take_limits(limits)

    def take_limits(self, limits: WinchLimits) -> None:
        """Count with other limits of the winch from now on."""
        self._acceleration = limits.acceleration
        self._gained = limits.acceleration * self._dt * np.arange(len(self._tip_rates))

    def forgiven(self, x: Array) -> float:
        """Return how much of the drum's error at state `x`, shape (n,), the law is not to see [m], down positive.

        The error is that of the moment at which the command takes effect. From sqrt(2 a s) a drum stops over s. On a
        short cable the unit hangs where the drum has let it, and its error may ask for the contrary: that comes on top.
        """
        error = float(self._error @ x)
        size = abs(error)
        speed = math.sqrt(2.0 * CATCHING_UP * self._acceleration * size)
        contrary = min(max(self._unit_gain, 0.0) * size, self._largest_share)
        seen = (speed + contrary) / self._payout_gain if self._payout_gain > 0.0 else math.inf
        return math.copysign(max(size - seen, 0.0), error)

    def turn_early(self, x: Array) -> float:
        """Return by how much the drum is to be ahead of the boom tip at state `x`, shape (n,) [m/s], to turn in time.

        At each time foreseen the drum can reach the boom tip's speed if now it is no further off than it can gain.
        """
        rates = self._tip_rates @ x
        highest, lowest = np.min(rates + self._gained), np.max(rates - self._gained)
        return float(highest + lowest - 2.0 * rates[0])
