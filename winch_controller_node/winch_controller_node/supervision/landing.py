"""Whether a unit that is lowered has landed, and whether one that is lifted off hangs again.

A cable is unloaded by the seabed, and by a unit that swings. A landed unit stands still, a swinging one falls faster
than it is lowered: the depth sensor alone tells, without a model of the cable, and so also where the model is wrong, as
an unstable loop shows it to be.
"""

from __future__ import annotations

from collections import deque
from enum import Enum

import numpy as np

from winch_controller_node.estimation.loop_tick import Sensed
from winch_controller_node.motion.mean_motion import RETURN_SPEED
from winch_controller_node.parameters.laws import TensionLawParameters
from winch_controller_node.supervision.modes import Mode, ModeOutput

INNOVATION_ABOVE = 3.0
"""Standard deviations by which the depth sensor reads a landed unit above a hanging one, at least."""

WINDOW = 1.0
"""Time over which the speed is measured [s]; readings of 2 cm at 10 Hz give it to 2 cm/s."""

STANDING_SHARE = 0.25
"""A unit stands that falls more slowly than this share of the speed at which it is lowered..."""

STANDING_SPEED = 0.05
"""...or than this, which noise alone may show [m/s]."""


class LandingEvent(Enum):
    """What has just happened."""

    TOUCHDOWN = "touchdown"
    LIFTED_OFF = "unit hangs"


class FallRate:
    """Speed of the unit from the depth readings of the last second alone."""

    def __init__(self) -> None:
        self._readings: deque[tuple[float, float]] = deque()

    def add(self, time: float, depth: float) -> None:
        """Take a good reading in: its stamp `time` [s] and `depth`, positive down [m]."""
        self._readings.append((time, depth))
        while time - self._readings[0][0] > WINDOW and len(self._readings) > 2:
            self._readings.popleft()

    @property
    def value(self) -> float:
        """Speed of the unit, positive down [m/s], the slope of a straight line; 0 before there are two readings."""
        times, depths = np.array(self._readings).reshape(-1, 2).T
        if times.size < 2 or times[-1] <= times[0]:
            return 0.0
        about = times - times.mean()
        return float(about @ depths / (about @ about))

    def shows_standing(self, lowering_rate: float) -> bool:
        """Tell whether the unit stands while it is lowered at `lowering_rate` [m/s]."""
        return self.value < max(STANDING_SHARE * lowering_rate, STANDING_SPEED)


class Landing:
    """Where the unit is between hanging and standing, by its weight and by what the depth sensor sees.

    Parameters
    ----------
    parameters : shares of the weight at which it has landed, and hangs again

    Attributes
    ----------
    unit_stands : on the seabed
    """

    def __init__(self, parameters: TensionLawParameters) -> None:
        self._parameters = parameters
        self.unit_stands = False
        self._is_lifting = False
        self._fall_rate = FallRate()
        self._depth_innovation = 0.0

    def observe(self, sensed: Sensed) -> None:
        """Take in what the depth sensor `sensed` in a tick."""
        for time, depth in sensed.depths:
            self._fall_rate.add(time, depth)
        if sensed.depth_innovation is not None:
            self._depth_innovation = sensed.depth_innovation

    def update(
        self, sensed: Sensed, weight_share: float, mode: ModeOutput, lowering_rate: float
    ) -> LandingEvent | None:
        """Return what has happened in this tick; None: nothing.

        Parameters
        ----------
        sensed : readings of the tick
        weight_share : share of the unit's weight that the cable carries, as measured
        mode : of the tick
        lowering_rate : of the mean payout [m/s]
        """
        if self._touches_down(sensed, weight_share, mode, lowering_rate):
            self.unit_stands, self._is_lifting = True, False
            return LandingEvent.TOUCHDOWN
        if self._is_lifting and weight_share > self._parameters.lift_off_ratio:
            self.unit_stands, self._is_lifting = False, False
            return LandingEvent.LIFTED_OFF
        return None

    def begin_lift_off(self) -> None:
        """Expect a standing unit to be lifted off from now on."""
        self._is_lifting = True

    def _touches_down(self, sensed: Sensed, weight_share: float, mode: ModeOutput, lowering_rate: float) -> bool:
        if self.unit_stands:
            return False
        is_lowering = mode.mode is Mode.COMPENSATING and lowering_rate > RETURN_SPEED
        is_relieved = mode.authority > 0.5 and weight_share < self._parameters.touchdown_ratio
        return is_lowering and is_relieved and self._stands(sensed, lowering_rate)

    def _stands(self, sensed: Sensed, lowering_rate: float) -> bool:
        """Tell whether the depth sensor sees the unit stand, above where a hanging one would have fallen.

        A unit that swings unloads the cable too, but falls as the model says, and falls in any case. Without a depth
        sensor the tension alone tells.
        """
        if not sensed.has_depth:
            return True
        return self._depth_innovation > INNOVATION_ABOVE and self._fall_rate.shows_standing(lowering_rate)
