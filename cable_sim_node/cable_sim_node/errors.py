"""What can go wrong in the plant, by name."""

from __future__ import annotations


class PlantError(RuntimeError):
    """The plant cannot go on; the state is that of the last good moment. The message says what, when and where."""


class NoEquilibriumError(PlantError):
    """There is no hanging equilibrium to start from."""


class StaticsError(PlantError, ValueError):
    """A statics problem that is not well posed; the message says what is wrong."""


class LinearisationError(PlantError, ValueError):
    """A linear model that cannot be made; the message says why."""


class CableTooShortError(PlantError):
    """More cable is hauled in than leaves a segment to compute with."""


class NotConvergedError(PlantError):
    """The equations have no solution that the solver finds, even with very small steps."""


class BadMotionError(PlantError, ValueError):
    """A motion or a length given to the plant is not a finite number, a length jumps, or a duration is not positive."""


LARGEST_JUMP = 1e-6
"""Payout at the start of an interval may differ from the plant's own by this [m]: far above rounding, far below any
winch."""


def refuse_jump(payout: float, payout_start: float, time: float | None = None) -> None:
    """Raise BadMotionError if a payout jumps: cable neither appears nor vanishes.

    Parameters
    ----------
    payout : of the plant [m]
    payout_start : with which the next interval would start [m]
    time : simulated time [s], for the message; None: the plant does not know it
    """
    if abs(payout_start - payout) > LARGEST_JUMP:
        where = "" if time is None else f"at t = {time:g} s: "
        raise BadMotionError(
            f"{where}payout_start {payout_start:.9g} m differs from the plant's payout of {payout:.9g} m; start "
            f"where the last interval ended (within {LARGEST_JUMP:g} m)"
        )
