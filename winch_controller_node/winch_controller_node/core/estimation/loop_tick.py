"""One tick of the loop as a value: the row of the core. Nothing in it changes."""

from __future__ import annotations

import math
from collections import namedtuple
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from heave_core.look_table import MOTIONS
from heave_core.sense_table import TICK

FIELDS = (*(row.name for row in TICK.rows if row.kind is not MOTIONS), *(row.name for row in MOTIONS.rows))
"""Numbers of a tick, with their meanings and units in the tables TICK and MOTIONS of the core."""

MORE = ("rows", "estimate", "mean_state", "said", "lost", "depths", "observed", "inconsistency")
"""What a tick has beside them, see `LoopTick`."""

TENSION_MEMORY = 30.0
"""Time constant of the mean tension [s]: of a wave it leaves 1/(w T), as much as a plain mean over twice the time may.
It holds a wave and a half of the longest swell, of 20 s; the motion of the boom tip is averaged over it as well."""


class TensionMean(NamedTuple):
    """Mean of the tension at the top over waves, which is what stays of it under a brake.

    The mean acceleration of a unit that goes nowhere is 0, so that it is the weight that the cable carries: it
    distinguishes a unit that stands from one that hangs, where a reading, or a low-pass of a second, shows the wave.
    """

    value: float = math.nan  # [N]; NaN where there is none
    sigma: float = 0.0  # standard deviation of the tension about it [N]
    time: float = 0.0  # for which the situation has been the same [s]


def free_swing(heave: float, rate: float, inertia: float) -> float:
    """Return the amplitude [m] of a unit's free swing: `heave` [m], `rate` [m/s]; `inertia` is a of its cable [s^2]."""
    return math.hypot(heave, math.sqrt(inertia) * rate)


class CommandShares(NamedTuple):
    """A command in the terms of the model, in two shares: what is `compensating`, and what moves the `mean` payout."""

    compensating: float = 0.0
    mean: float = 0.0

    @property
    def total(self) -> float:
        """The command."""
        return self.compensating + self.mean


if TYPE_CHECKING:
    # numbers by the names of the tables, which no checker knows
    LoopTick: TypeAlias = Any
else:

    class LoopTick(namedtuple("LoopTick", (*FIELDS, *MORE))):
        """What is known of the loop at a tick: the numbers of the core's Tick by their names, and more.

        Attributes
        ----------
        rows : of the model whose states these are
        estimate : state of the loop without the mean payout's own motion, shape (n,)
        mean_state : state that the mean payout alone brings about, shape (n,)
        said : innovation, its standard deviation, its normalised square and whether it was accepted, of each
            measurement of the filter (m, 4); NaN where there was no reading
        lost : why each lost sensor counts as lost, by name
        depths : depth readings of the tick: stamp [s] and depth, positive down [m]
        observed : readings of the tick, by the columns of the core's Observed
        inconsistency : why the readings are not consistent yet; empty where they are

        By linearity the loop's motion is the sum of what the mean payout brings about, which is known exactly, and of
        the rest, which is estimated.
        """

        __slots__ = ()

        @property
        def command(self) -> CommandShares:
            """Command active until now."""
            return CommandShares(self.compensating, self.mean)

        @property
        def mean_tension(self) -> TensionMean:
            """Tension at the top, over the waves since the unit and the mean payout are where they are."""
            return TensionMean(self.tension_mean, self.tension_sigma, self.tension_time)
