"""What every source of the vessel's motion is."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod

from heave_node.interface.waves import NO_WAVES, Waves

from wave_vessel_node.vessel.motion import VesselMotion


class MotionSource(ABC):
    """Gives the vessel's motion tick by tick."""

    @abstractmethod
    def motion(self, tick: int) -> VesselMotion:
        """Return the motion at tick * tick_period; ticks are asked for in rising order, each once."""

    def nominal_sea(self) -> tuple[float, float]:
        """Return height [m] and period [s] that describe the sea of a source without a spectrum; NaN: not known."""
        return math.nan, math.nan

    def waves(self) -> Waves:
        """Return the components of the sea about the boom tip; none where it has none, or none that last."""
        return NO_WAVES
