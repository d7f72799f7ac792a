"""Whether a unit that is lowered has landed, and whether one that is lifted off hangs again.

A cable is unloaded by the seabed, and by a unit that swings. While the winch lowers at speed v, a landed unit stands
still and its cable of stiffness k loses k v of tension each second, until it is slack. Depth sensor, load cell and the
mean payout tell, each by its trend over a window in which the winch lowers by some centimetres. Soft and long cables
are known to have landed long before they are unloaded.

Without depth readings the tension alone shows it, and later: whatever a hanging unit does in waves, on average over a
whole swing its cable carries the weight.

What else does both at once is ruled out. While lowering gains speed, the inertia of a hanging unit keeps it behind for
seconds: lowering must have been steady for as long as such a unit needs to follow. At the lowest point of a swing a
unit stands too and the tension falls, but from above the weight, which the cable of a landed unit no longer carries.
And a unit that hangs would sink: that is worked out from boom tip and drum, and the depth sensor must read a landed one
above the estimate as well.

Under a brake nobody lowers, and a unit may have stood from the start, on the bottom or on deck. Its cable then carries
too little of the weight on average over a whole swing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from winch_controller_node.core.estimation.loop_tick import Sensed
from winch_controller_node.core.estimation.tension import MEMORY, TensionMean
from winch_controller_node.core.supervision.checks import Trend
from winch_controller_node.core.supervision.modes import Mode, ModeOutput
from winch_controller_node.parameters.laws import TensionLawParameters

LOWERED = 0.15
"""Distance that the winch lowers within a window [m]: some standard deviations of a depth sensor."""

SHORTEST, LONGEST = 0.6, 8.0
"""Least and largest length of a window [s]."""

WINDOWS = (1.0, 2.0, 3.0)
"""Windows that are looked at, longer ones for noisier sensors."""

LEAST_RATE = 0.01
"""The winch lowers above this speed [m/s]."""

STEADY_SHARE = 0.85
"""Lowering is steady over a window whose mean speed is at least this share of the speed now."""

STANDING_SHARE = 0.4
"""A unit stands that moves at no more than this share of the speed at which it is lowered."""

RELIEF_SHARE = 0.5
"""A cable is relieved by a standing unit that loses at least this share of what its stiffness makes of the lowering."""

CERTAIN = 3.0
"""Standard errors by which a trend must be more than nothing."""

INNOVATION_ABOVE = 1.0
"""Standard deviations by which the depth sensor reads a landed unit above a hanging one, on average over a window."""

UNCONFIRMED_TIME = 3.0
"""Longest time of an unconfirmed touchdown, in windows: then compensation is judged again."""

MEAN_ERROR = 0.3
"""Error of the mean tension over its memory, over the standard deviation of the tension: a swell of 20 s leaves
sqrt(2)/(w t) = 0.15 of its own, and a group of waves, or a cable that goes slack and snaps, twice that."""


class LandingEvent(Enum):
    """What has just happened, by the code of its alarm."""

    TOUCHDOWN = "TOUCHDOWN"
    LIFTED_OFF = "UNIT_SUSPENDED"


@dataclass(frozen=True, slots=True)
class HangingLoad:
    """What is known of the load and its cable.

    Attributes
    ----------
    static_tension : at the top while the unit hangs under water [N]
    weight : of the unit in water [N]
    stiffness : of the cable [N/m]
    following_time : that the hanging unit needs to follow the winch, a quarter of its free swing [s]
    swing_time : of a free swing or a wave, whichever is longer [s]
    cable_weight : of the cable in water [N/m]
    """

    static_tension: float
    weight: float
    stiffness: float
    following_time: float = 0.0
    swing_time: float = 10.0
    cable_weight: float = 0.0

    def weight_share(self, tension: float) -> float:
        """Return the share of the unit's weight that the cable carries under a `tension` at the top [N]."""
        return (tension - self.static_tension) / self.weight + 1.0

    def mean_share(self, tension: TensionMean, more: float) -> tuple[float, float]:
        """Return the share of the weight that the cable carries on average, and its error.

        Parameters
        ----------
        tension : mean at the top
        more : cable that is out beyond that of the static tension [m]
        """
        averaged = min(max(tension.time / MEMORY, 1e-3), 1.0)
        error = MEAN_ERROR * tension.sigma / (averaged * self.weight)
        return self.weight_share(tension.value - self.cable_weight * more), error


class HangingUnit(NamedTuple):
    """What a unit would do that only hangs on its cable, whatever is read of it.

    Attributes
    ----------
    depth : about that at rest, positive down [m]
    stretch : by which its cable is longer than at rest [m]
    """

    depth: float
    stretch: float


class Landing:
    """Where the unit is between hanging and standing.

    Parameters
    ----------
    parameters : shares of the weight at which it has landed, and hangs again
    load : on the cable

    Attributes
    ----------
    unit_stands : on the seabed
    may_stand : the unit may just have landed: its readings are no check on the estimate of a hanging unit
    is_unloaded : the winch is braked over a cable that does not carry the unit, on average
    share : of the weight that the cable has carried then
    """

    def __init__(self, parameters: TensionLawParameters, load: HangingLoad) -> None:
        self._parameters = parameters
        self._load = load
        self.unit_stands = False
        self.may_stand = self.is_unloaded = False
        self.share = 1.0
        self._is_lifting = False
        self._depth, self._hanging, self._tension, self._payout, self._innovation = (Trend() for _ in range(5))
        self._hanging_share = Trend()
        self._may_stand_since = -math.inf

    def take_load(self, load: HangingLoad) -> None:
        """Judge another load, or another length of its cable, from now on."""
        self._load = load

    def observe(self, time: float, sensed: Sensed, mean_payout: float, hanging: HangingUnit) -> None:
        """Take in what is known at a tick.

        Parameters
        ----------
        time : of the tick [s]
        sensed : in it
        mean_payout : of the drum [m]
        hanging : what it would be of a unit that hangs
        """
        for stamp, depth in sensed.depths:
            self._depth.add(stamp, depth)
        if "load_cell" in sensed.lost:
            # what it read last, again and again, is no tension
            self._tension = Trend()
        elif math.isfinite(sensed.tension):
            self._tension.add(time, sensed.tension)
        self._payout.add(time, mean_payout)
        self._hanging.add(time, hanging.depth)
        load = self._load
        share = load.weight_share(load.static_tension + load.stiffness * hanging.stretch)
        self._hanging_share.add(time, min(1.0, share))
        if sensed.depth_innovation is not None:
            self._innovation.add(time, sensed.depth_innovation)

    def update(self, time: float, sensed: Sensed, mode: ModeOutput) -> LandingEvent | None:
        """Return what has happened in this tick; None: nothing.

        Parameters
        ----------
        time : of the tick [s]
        sensed : in this tick
        mode : the active one
        """
        share = self._load.weight_share(sensed.filtered_tension)
        if not self.unit_stands and self._touches_down(time, sensed, share, mode):
            self.unit_stands, self.may_stand, self._is_lifting = True, False, False
            return LandingEvent.TOUCHDOWN
        if self._is_lifting and share > 1.0:
            self.unit_stands, self._is_lifting = False, False
            return LandingEvent.LIFTED_OFF
        return None

    @property
    def hangs(self) -> bool:
        """Tell whether the unit hangs, as far as is known."""
        return not (self.unit_stands or self.is_unloaded)

    def weigh(self, tension: TensionMean, more: float) -> float:
        """Take in what the cable carries under a brake; what is known stays until the tension shows another thing.

        Returns for how long the tension must be averaged still [s]; 0 where it has not been too low so far either.

        Parameters
        ----------
        tension : mean at the top, in one situation
        more : cable that is out beyond that of the static tension [m]
        """
        share, error = self._load.mean_share(tension, more)
        is_low, wait = share < self._parameters.touchdown_ratio, self._load.swing_time - tension.time
        if wait > 0.0:
            return wait if is_low else 0.0
        if abs(share - self._parameters.touchdown_ratio) > error:
            self.is_unloaded, self.share = is_low, share
        return 0.0

    def forget_weight(self) -> None:
        """Take the unit to hang, as without a load cell: what that has said is old."""
        self.is_unloaded = False

    def begin_hold(self) -> None:
        """Take a unit that does not hang, and whose tension is held on request, for one that has landed."""
        self.unit_stands |= self.is_unloaded
        self.is_unloaded = False

    def begin_lift_off(self) -> None:
        """Expect a standing unit to be lifted off from now on."""
        self._is_lifting = True

    def _touches_down(self, time: float, sensed: Sensed, share: float, mode: ModeOutput) -> bool:
        is_compensating = mode.mode is Mode.COMPENSATING and mode.authority > 0.5
        rate = self.lowering_rate if is_compensating else 0.0
        if rate < LEAST_RATE:
            self.may_stand = False
            return False
        if not sensed.sees_landing:
            return self._is_relieved_throughout(rate)
        if not sensed.depths:
            return False
        window = min(max(LOWERED / rate, SHORTEST), LONGEST)
        self._watch_unconfirmed(time, window, rate)
        return any(self._shows_landing(factor * window, rate, share) for factor in WINDOWS)

    @property
    def lowering_rate(self) -> float:
        """Speed at which the winch lowers [m/s]; 0 before that is known."""
        slope = None if self._payout.has_stood(SHORTEST) else self._payout.slope(SHORTEST)
        return 0.0 if slope is None else slope.value

    def _shows_landing(self, window: float, rate: float, share: float) -> bool:
        """Tell whether the unit has stood for a `window` [s] in which the winch lowered and the cable was relieved.

        `rate` is that of lowering now [m/s], `share` that of the weight which the cable carries.
        """
        depth, payout, tension = (trend.slope(window) for trend in (self._depth, self._payout, self._tension))
        before = self._payout.slope(window + self._load.following_time)
        hanging = self._hanging.slope(window)
        if depth is None or payout is None or before is None or hanging is None:
            return False
        if min(payout.value, before.value) < max(LEAST_RATE, STEADY_SHARE * rate):
            return False
        sinking = min(payout.value, hanging.value)
        if abs(depth.value) > STANDING_SHARE * sinking or sinking - depth.value < CERTAIN * depth.error:
            return False
        if self._innovation.mean(window) < INNOVATION_ABOVE:
            return False
        relief = RELIEF_SHARE * self._load.stiffness * payout.value
        is_relieved = tension is not None and -tension.value > max(relief, CERTAIN * tension.error)
        relieved_share = 1.0 - relief * window / self._load.weight
        return (is_relieved and share < relieved_share) or share < self._parameters.touchdown_ratio

    def _is_relieved_throughout(self, rate: float) -> bool:
        """Tell whether a cable that is lowered at a `rate` [m/s] has lost the weight on average over a whole swing.

        Within a swing, and while lowering gains speed, that of a hanging unit may lose all of it.
        """
        time = self._load.swing_time
        payout, tension = self._payout.slope(time), self._tension.slope(time)
        if payout is None or tension is None or payout.value < max(LEAST_RATE, STEADY_SHARE * rate):
            return False
        share = self._load.weight_share(self._tension.mean(time))
        return share < self._parameters.touchdown_ratio * self._hanging_share.mean(time)

    def _watch_unconfirmed(self, time: float, window: float, rate: float) -> None:
        """Notice within half a window that the unit may have landed."""
        depth, tension = self._depth.slope(0.5 * window), self._tension.slope(0.5 * window)
        stands = depth is not None and abs(depth.value) < STANDING_SHARE * rate
        relieved = tension is None or tension.value < 0.0
        may_stand = stands and relieved and self._innovation.mean(0.5 * window) > INNOVATION_ABOVE
        if may_stand and time - self._may_stand_since > 4.0 * UNCONFIRMED_TIME * window:
            self._may_stand_since = time
        self.may_stand = may_stand and time - self._may_stand_since < UNCONFIRMED_TIME * window
