"""What every source of the vessel's motion is."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod

from heave_node.interface.waves import NO_WAVES, Waves
from heave_node.numerics.arrays import Array

from wave_vessel_node.sea.realisation import HarmonicSum
from wave_vessel_node.vessel.motion import VesselMotions

BLOCK = 64
"""Ticks that are computed at once: a call costs as much as their numbers."""


def block_from(tick: int) -> range:
    """Return the ticks from `tick` to the last one before a multiple of BLOCK."""
    return range(tick, (tick // BLOCK + 1) * BLOCK)


class MotionSource(ABC):
    """Gives the vessel's motion in blocks of ticks."""

    @abstractmethod
    def motions(self, ticks: range) -> VesselMotions:
        """Return the motion at `ticks` times tick_period; they are asked for in rising order, each once.

        It may return fewer, the first of them, where it ends. Raises ValueError where none is left.
        """

    def nominal_sea(self) -> tuple[float, float]:
        """Return height [m] and period [s] that describe the sea of a source without a spectrum; NaN: not known."""
        return math.nan, math.nan

    def point_heave(self, lever: Array) -> HarmonicSum | None:  # noqa: ARG002
        """Return the vertical motion of a point as one sum; None: it has none. `lever` is its row, shape (6,)."""
        return None

    def waves(self) -> Waves:
        """Return the components of the sea about the boom tip; none where it has none, or none that last."""
        return NO_WAVES
