"""The guard's checks over seconds: what drum and unit do, against the motion of boom tip and uncompensated unit."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from heave_node.interface.alarm import Alarm

from winch_controller_node.core.estimation.loop_tick import Motion
from winch_controller_node.core.supervision.checks import AmplitudeCheck, AmplitudeLimit, Countdown, DetrendedHeave
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.laws.parts.effort import Effort
from winch_controller_node.laws.parts.winch_limits import WinchLimits

DRUM = AmplitudeLimit(time=2.0, ratio=1.5, floor=0.1)
"""Speed of the drum that is not intended, against that of the boom tip [m/s]."""

SWING = AmplitudeLimit(time=3.0, ratio=1.2, floor=math.inf)
"""Swing of the unit against the uncompensated one [m]; the floor of this and the next two follows `guard.floor`."""

DEPTH = AmplitudeLimit(time=6.0, ratio=1.3, floor=math.inf)
"""Heave that the depth sensor reads against the uncompensated one [m]."""

MISMATCH = AmplitudeLimit(time=8.0, ratio=0.8, floor=math.inf)
"""Depth sensor less estimate, against the uncompensated heave [m]."""

FLOOR_FACTOR = 10.0
"""Multiple of `guard.floor` below which these checks ignore heave: that is left to the comparison over waves."""

CATCH_UP_TIME = 15.0
"""Time that the drum is not checked after a lost sensor is back [s]: the law has to catch up with what it missed."""

LEFT_OVER_TIME = 30.0
"""Time in which compensation has to take out a swing that it has found [s]: that of a sudden stop, or one not seen."""

LARGEST_LEFT_OVER = 2.0
"""Largest swing that compensation may find, over the uncompensated one."""

RESTART = 0.1
"""Rest of the last allowance at which a swing that waves have left is allowed again."""

BEYOND = 0.02
"""A sea is beyond the winch's limits where so much of the largest speed is missing."""

OUT_OF_REACH = 2.0
"""Allowed error of the drum's speed at its limits, over that of a drum that follows the intended speed within them."""

SWING_WORK = 2.0
"""Speed of the drum that stops a swinging unit, over the speed of the unit."""

LEAST_AUTHORITY = 0.5
"""The drum is checked against this share of the boom tip's speed at least."""


@dataclass(frozen=True)
class GuardedLoop:
    """What the guard must know of the loop it watches.

    Attributes
    ----------
    limits : of the winch
    effort : of the law
    inertia : a of the two-state cable [s^2]; 0: unknown
    feeds_back_unit : the law feeds the unit's motion back, so that the loop can become unstable
    fade_time : shortest time over which authority goes from 0 to 1 or back [s]
    """

    limits: WinchLimits
    effort: Effort = field(default_factory=Effort)
    inertia: float = 0.0
    feeds_back_unit: bool = True
    fade_time: float = 10.0


class GuardedMotions(NamedTuple):
    """What the guard compares at a tick, all about the mean depth.

    Attributes
    ----------
    unit : estimated motion of the unit, compensated
    free_unit : the same with the winch locked
    boom_tip : estimated motion of the boom tip
    payout_rate : estimated speed of the drum, without that of the mean payout [m/s]
    measured_heave : heave of the unit as the depth sensor reads it [m]; None: no reading came
    depth_noise : standard deviation of that sensor's noise, as far as it is known [m]
    mean_acceleration : of the mean payout [m/s^2]
    """

    unit: Motion
    free_unit: Motion
    boom_tip: Motion
    payout_rate: float = 0.0
    measured_heave: float | None = None
    depth_noise: float = 0.0
    mean_acceleration: float = 0.0


class Swings(NamedTuple):
    """Squared amplitudes z^2 + a z'^2 of a unit that swings by itself [m^2].

    Attributes
    ----------
    unit, free_unit : compensated, and with the winch locked
    """

    unit: float
    free_unit: float

    @classmethod
    def of(cls, motions: GuardedMotions, inertia: float) -> Swings:
        """Return those of the `motions` on a cable with an `inertia` a [s^2]."""
        return cls(_swing(motions.unit, inertia), _swing(motions.free_unit, inertia))


def _swing(motion: Motion, inertia: float) -> float:
    return motion.heave**2 + inertia * motion.rate**2


class DrumCheck:
    """Compares the speed of the drum that is not intended with that of the boom tip, and what stopping a swing asks.

    Parameters
    ----------
    window : memory of the waves [s]
    tick_period : [s]

    Attributes
    ----------
    is_out_of_reach : the sea asks for more speed than the winch can give now
    """

    def __init__(self, window: float, tick_period: float) -> None:
        self._dt = tick_period
        self._check = AmplitudeCheck(DRUM, window, tick_period)
        self._exchanged_swing = self._reachable = self._to_gain_speed = 0.0
        self._catch_up = Countdown(tick_period)
        self.is_out_of_reach = False

    def allow_catch_up(self) -> None:
        """Do not check the drum for some seconds: the law has to catch up with what it could not see."""
        self._catch_up.start(CATCH_UP_TIME)

    def update(
        self, motions: GuardedMotions, loop: GuardedLoop, authority: float, change: float, swings: Swings
    ) -> None:
        """Take in a tick.

        While authority A moves, the unit goes over to (1 - A) of its uncompensated motion: by thesis Eq. 6.2 that asks
        for payout = A tip + 2 a A' z_off' (b and A'' left out), with a z_off'' = tip - z_off.

        Parameters
        ----------
        motions : of it
        loop : that is watched
        authority : authority of compensation now
        change : of the authority in this tick
        swings : of unit and uncompensated unit
        """
        tip = motions.boom_tip
        largest = self._dt / loop.fade_time
        authority_rate = min(max(change, -largest), largest) / self._dt
        intended = authority * tip.rate + authority_rate * (3.0 * tip.heave - 2.0 * motions.free_unit.heave)
        error = motions.payout_rate - intended
        allowed = (1.0 + loop.effort.rate_error) * max(authority, LEAST_AUTHORITY) * tip.rate
        # a law has to stop a unit that swings, and while authority moves to take it out of its uncompensated swing;
        # where that is large, as at a resonance, the drum does no harm before it is as fast
        faded = self._exchanged_swing * (1.0 - self._dt / SWING.time)
        self._exchanged_swing = faded if change == 0.0 else swings.free_unit
        to_stop = SWING_WORK**2 * (swings.unit + self._exchanged_swing) + swings.free_unit
        work = to_stop / loop.inertia if loop.inertia > 0.0 else 0.0
        self._follow_mean(motions.mean_acceleration, loop.inertia)
        out_of_reach = intended - self._follow_within_limits(intended, loop.limits)
        self.is_out_of_reach = abs(out_of_reach) > BEYOND * loop.limits.speed
        self._check.add(error**2, allowed**2 + work + self._to_gain_speed**2 + (OUT_OF_REACH * out_of_reach) ** 2)
        if self._catch_up.step() or authority <= 0.0:
            self._check.restart()

    def _follow_mean(self, acceleration: float, inertia: float) -> None:
        """Notice what speed of the drum an `acceleration` of the mean payout asks for [m/s^2].

        The unit gains speed with it once its cable is longer by a times the acceleration, on a soft cable by metres.
        The law pays that out within the memory of the check, and hauls it in while the unit comes along.
        """
        fading = self._dt / max(math.sqrt(inertia), self._dt)
        self._to_gain_speed = max(inertia * abs(acceleration) / DRUM.time, (1.0 - fading) * self._to_gain_speed)

    def _follow_within_limits(self, intended: float, limits: WinchLimits) -> float:
        """Return the speed of a drum that follows an `intended` one within the winch's `limits` [m/s]."""
        largest = limits.acceleration * self._dt
        reached = self._reachable + min(max(intended - self._reachable, -largest), largest)
        self._reachable = min(max(reached, -limits.speed), limits.speed)
        return self._reachable

    @property
    def harm(self) -> Alarm | None:
        """What the drum does that is harmful; None: nothing."""
        if not self._check.is_exceeded:
            return None
        return ALARMS.alarm("DRUM_SPEED_OFF", error=self._check.amplitude)


class UnitCheck:
    """Compares the unit with the uncompensated one, as estimated and as the depth sensor reads it.

    Parameters
    ----------
    window : memory of the waves [s]
    floor : heave that is never too large [m]
    tick_period : [s]
    """

    def __init__(self, window: float, floor: float, tick_period: float) -> None:
        self._dt = tick_period
        self._swing, self._depth, self._mismatch = (
            AmplitudeCheck(replace(limit, floor=floor), window, tick_period) for limit in (SWING, DEPTH, MISMATCH)
        )
        self._measured, self._error = DetrendedHeave(tick_period), DetrendedHeave(tick_period)
        self._left_over = 0.0
        self._is_corrected = False

    def allow_left_over(self) -> None:
        """Do not hold the swing that the unit has now against the loop."""
        self._is_corrected = True

    def reset_mismatch(self) -> None:
        """Compare depth sensor and estimate again: one of them has been corrected."""
        self._mismatch.restart()
        self._error = DetrendedHeave(self._dt)

    def update(
        self, motions: GuardedMotions, inertia: float, authority: float, swings: Swings, *, is_out_of_reach: bool
    ) -> None:
        """Take in a tick.

        Parameters
        ----------
        motions : of it
        inertia : a of the cable [s^2]
        authority : authority of compensation now
        swings : of it
        is_out_of_reach : the sea is beyond the winch's limits
        """
        self._swing.add(swings.unit, swings.free_unit)
        self._update_left_over(motions, inertia, authority, is_out_of_reach=is_out_of_reach)
        # the mean square of a heave is half that of its swing
        free_heave = 0.5 * swings.free_unit
        heave, noise = motions.measured_heave, motions.depth_noise
        self._depth.take_off(noise)
        self._mismatch.take_off(noise)
        self._measured.add(heave, noise)
        self._depth.add(self._measured.value**2, free_heave)
        self._error.add(None if heave is None else heave - motions.unit.heave, noise)
        self._mismatch.add(self._error.value**2, free_heave)
        if authority <= 0.0:
            self._swing.restart(self._swing.reference)
            self._depth.restart()

    def _update_left_over(
        self, motions: GuardedMotions, inertia: float, authority: float, *, is_out_of_reach: bool
    ) -> None:
        """Do not hold against the loop the swing that it has found.

        While the winch stands, the unit less the uncompensated one is a free swing, and would go on for long: whoever
        stops the winch suddenly sets it going. So does a wrong belief that has been corrected, and a wave that is
        beyond the winch's limits: of a compensated unit all of its motion is that.
        """
        unit, free = motions.unit, motions.free_unit
        if authority <= 0.0:
            unit = Motion(unit.heave - free.heave, unit.rate - free.rate)
        found = min(math.sqrt(_swing(unit, inertia)), LARGEST_LEFT_OVER * math.sqrt(self._swing.reference))
        if authority <= 0.0 or self._is_corrected:
            self._left_over = found
        else:
            self._left_over *= 1.0 - self._dt / LEFT_OVER_TIME
            if is_out_of_reach and self._left_over < RESTART * found:
                self._left_over = found  # once: what keeps growing is no swing that a wave has left
        self._is_corrected = False
        self._swing.allow(self._left_over)
        self._depth.allow(math.sqrt(0.5) * self._left_over)

    @property
    def mismatch(self) -> float | None:
        """By how much depth sensor and estimate disagree, 1 sigma [m]; None: they agree."""
        return self._mismatch.amplitude if self._mismatch.is_exceeded else None

    @property
    def harm_to_swing(self) -> Alarm | None:
        """What the estimate shows of harm; None: nothing."""
        return ALARMS.alarm("UNIT_SWING_HIGH", swing=self._swing.amplitude) if self._swing.is_exceeded else None

    @property
    def harm_by_depth(self) -> Alarm | None:
        """What the depth sensor shows of harm; None: nothing."""
        return ALARMS.alarm("UNIT_HEAVE_HIGH", heave=self._depth.amplitude) if self._depth.is_exceeded else None
