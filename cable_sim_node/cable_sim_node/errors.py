"""What can go wrong in the plant, by name."""

from __future__ import annotations


class PlantError(RuntimeError):
    """The plant cannot go on; the state is that of the last good moment. The message says what, when and where."""


class NoEquilibriumError(PlantError):
    """There is no hanging equilibrium to start from."""


class CableTooShortError(PlantError):
    """More cable is hauled in than leaves a segment to compute with."""


class NotConvergedError(PlantError):
    """The equations have no solution that the solver finds, even with very small steps."""


class BadMotionError(PlantError, ValueError):
    """A motion or a length given to the plant is not a finite number, or a duration not positive."""
