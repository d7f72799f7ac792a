"""Never worse than off: compares the residual with what the unit would do uncompensated, live, from estimates.

Over some waves exponentially weighted variances of both are compared: compensation must be better than none. A loop
that is lost pumps energy into a unit that then swings for minutes, so that the guard must not wait for waves. Over
seconds it compares

- the speed of the drum, where the law did not mean it, with the speed of the boom tip: a loop that grows shows there
  first, long before the heavy unit has answered;
- the swing of the unit, z^2 + a z'^2, with that of the uncompensated one;
- the heave that the depth sensor reads with the uncompensated one, and with the estimate: it knows where that is led
  astray (a motion reference unit of the wrong sign), and nothing can be tried before they agree again.

Compensation that does harm is faded out; after a hold time, which becomes longer with every harm, it is tried again
once the sea asks for no more than the winch can give.
"""

from __future__ import annotations

from dataclasses import dataclass

from winch_controller_node.laws.effort import Effort
from winch_controller_node.laws.governor import WinchLimits
from winch_controller_node.parameters.laws import GuardParameters
from winch_controller_node.supervision.comparison import MeasuredHeave, QuickComparison, Quickness, RunningSigma

FULL_SHARE = 0.95
"""Share of the wanted authority from which on compensation is judged."""

PEAK = 3.0
"""Peak amplitude over standard deviation of a sea, over some minutes."""

SIGNIFICANT = 2.0
"""Significant amplitude over standard deviation of a narrow-banded sea."""

GROUP_TIME, GROUP_PEAK = 8.0, 2.2
"""Memory that sees a group of high waves come [s], and peak amplitude over standard deviation within one."""

DRUM = Quickness(time=2.0, ratio=1.5, floor=0.1)
"""Speed of the drum that was not meant, against that of the boom tip [m/s]."""

EXCUSE_TIME = 15.0
"""Time that a law has to catch up after a lost sensor is back [s]."""

SWING_WORK = 2.0
"""Speed of the drum that stops a unit, over the speed of that."""

SWING_TIME, SWING_RATIO = 3.0, 1.2
"""Swing of the unit against the uncompensated one: memory [s] and ratio."""

DEPTH_TIME, DEPTH_RATIO = 6.0, 1.3
"""Heave that the depth sensor reads against the uncompensated one: memory [s] and ratio."""

DOUBT_TIME, DOUBT_RATIO = 8.0, 0.8
"""Depth sensor against the estimate, over the uncompensated heave: memory [s] and ratio."""

LEAST_AUTHORITY = 0.5
"""The drum's error is judged against this share of the boom tip's speed at least."""

QUICK_FLOORS = 10.0
"""Quick comparisons of heave: below so many times the floor it is left to the slow one."""

HOLD_GROWTH = 4.0
"""The hold time grows by this factor with each harm: what all tries do together stays little."""

Motion = tuple[float, float]
"""Heave [m] and heave rate [m/s]."""


@dataclass(frozen=True)
class Seen:
    """What the controller knows of a tick, all about the mean depth.

    Attributes
    ----------
    residual, uncompensated : estimated heave [m] and rate [m/s] of the unit with and without compensation
    tip_rate : estimated heave rate of the boom tip [m/s]
    drum_error : speed of the drum less what compensating that share of the sea asks for [m/s]
    depth : heave as the depth sensor reads it [m]; None: no reading
    """

    residual: Motion
    uncompensated: Motion
    tip_rate: float
    drum_error: float = 0.0
    depth: float | None = None


class HarmGuard:
    """Says when compensation shall be faded out, and when it may be tried again.

    Parameters
    ----------
    parameters : window, ratio, hold times
    limits : of the winch, for what the sea may ask for
    tick_period : [s]
    depth_noise : standard deviation of the depth sensor's noise [m]

    Attributes
    ----------
    effort : of the law in force
    is_harming : compensation is to be off
    trusts_estimate : the depth sensor bears the estimate out
    reason : in words, empty when all is well
    """

    def __init__(
        self, parameters: GuardParameters, limits: WinchLimits, *, tick_period: float, depth_noise: float = 0.0
    ) -> None:
        self._parameters = parameters
        self._limits = limits
        self._dt = tick_period
        self.effort = Effort()
        self.is_harming = False
        self.trusts_estimate = True
        self.reason = ""
        self._hold = parameters.hold_time
        self._off_time = 0.0
        self._on_time = 0.0
        self._reset_sigmas()
        window, floor = parameters.window, QUICK_FLOORS * parameters.floor
        self._drum = QuickComparison(DRUM, window, tick_period)
        self._swing = QuickComparison(Quickness(SWING_TIME, SWING_RATIO, floor), window, tick_period)
        self._depth = QuickComparison(Quickness(DEPTH_TIME, DEPTH_RATIO, floor, depth_noise), window, tick_period)
        self._measured = MeasuredHeave(tick_period)
        self._doubt = QuickComparison(Quickness(DOUBT_TIME, DOUBT_RATIO, floor, depth_noise), window, tick_period)
        self._difference = MeasuredHeave(tick_period)
        self._authority_before = 0.0
        self._exchanged = 0.0
        self._excused = 0.0
        self._tip_rate = RunningSigma(window, tick_period)
        self._tip_acceleration = RunningSigma(window, tick_period)
        self._group_rate = RunningSigma(GROUP_TIME, tick_period)
        self._group_acceleration = RunningSigma(GROUP_TIME, tick_period)
        self._last_rate: float | None = None

    def _reset_sigmas(self) -> None:
        self._residual = RunningSigma(self._parameters.window, self._dt)
        self._uncompensated = RunningSigma(self._parameters.window, self._dt)

    @property
    def residual_sigma(self) -> float:
        """Residual motion of the unit, estimated [m]."""
        return self._residual.sigma

    @property
    def uncompensated_sigma(self) -> float:
        """What it would be with the winch locked, estimated [m]."""
        return self._uncompensated.sigma

    @property
    def demand(self) -> float:
        """What the sea asks of the winch over its limits: significant amplitude of speed or acceleration [-]."""
        speed = SIGNIFICANT * self._tip_rate.sigma / self._limits.speed
        acceleration = SIGNIFICANT * self._tip_acceleration.sigma / self._limits.acceleration
        return max(speed, acceleration)

    @property
    def authority_limit(self) -> float:
        """Largest authority that keeps a law without limits of its own off the winch's limits, by the sea seen now."""
        speed = max(PEAK * self._tip_rate.sigma, GROUP_PEAK * self._group_rate.sigma)
        acceleration = max(PEAK * self._tip_acceleration.sigma, GROUP_PEAK * self._group_acceleration.sigma)
        peak = max(
            self.effort.speed * speed / self._limits.speed,
            self.effort.acceleration * acceleration / self._limits.acceleration,
        )
        return min(1.0, self._parameters.limit_use / peak) if peak > 0.0 else 1.0

    def update(
        self,
        seen: Seen,
        authority: float,
        target: float = 1.0,
        *,
        inertia: float = 0.0,
        has_feedback: bool = True,
    ) -> None:
        """Take one tick in.

        Parameters
        ----------
        seen : motions of the tick
        authority : share of the sea that is compensated now
        target : share it goes to; compensation is judged when that is (nearly) reached
        inertia : a of the two-state cable [s^2]
        has_feedback : the law feeds the unit's motion back, and could be lost; others are judged over waves only
        """
        self._watch_sea(seen.tip_rate)
        self._watch(seen, inertia, authority)
        if self._doubt.is_above:
            self._distrust()
        if self.is_harming:
            self._wait(authority)
            return
        if authority <= 0.0:
            self._on_time = 0.0
            self._reset_sigmas()
            return
        self._judge_quickly(has_feedback=has_feedback)
        if self.is_harming or authority < FULL_SHARE * target:
            return
        self._residual.add(seen.residual[0])
        self._uncompensated.add(seen.uncompensated[0])
        self._on_time += self._dt
        self._judge()

    def excuse_drum(self) -> None:
        """Leave the drum alone for some seconds: the law has to catch up with what it could not see."""
        self._excused = EXCUSE_TIME

    def hold_off(self, reason: str) -> None:
        """Keep compensation off while there is a `reason` that is known for sure, and for the hold time after it."""
        self._off_time = 0.0
        if not self.is_harming:
            self._fade(reason)

    def _watch_sea(self, tip_rate: float) -> None:
        self._tip_rate.add(tip_rate)
        self._group_rate.add(tip_rate)
        if self._last_rate is not None:
            acceleration = (tip_rate - self._last_rate) / self._dt
            self._tip_acceleration.add(acceleration)
            self._group_acceleration.add(acceleration)
        self._last_rate = tip_rate

    def _watch(self, seen: Seen, inertia: float, authority: float) -> None:
        """Take the motions of a tick into the quick comparisons."""
        swing, uncompensated = (heave**2 + inertia * rate**2 for heave, rate in (seen.residual, seen.uncompensated))
        self._measured.add(seen.depth)
        self._difference.add(None if seen.depth is None else seen.depth - seen.residual[0])
        meant = (1.0 + self.effort.drum_error) * max(authority, LEAST_AUTHORITY) * seen.tip_rate
        # a law has to stop a unit that swings, and while authority moves to take it out of its uncompensated swing
        moves, self._authority_before = authority != self._authority_before, authority
        self._exchanged = uncompensated if moves else self._exchanged * (1.0 - self._dt / SWING_TIME)
        work = SWING_WORK**2 * (swing + self._exchanged) / inertia if inertia > 0.0 else 0.0
        self._drum.add(seen.drum_error**2, meant**2 + work)
        self._swing.add(swing, uncompensated)
        # the mean square of a swing is half its energy; a sensor of heave alone sees that
        self._depth.add(self._measured.value**2, 0.5 * uncompensated)
        self._doubt.add(self._difference.value**2, 0.5 * uncompensated)
        self._excused = max(self._excused - self._dt, 0.0)
        if self._excused > 0.0:
            self._drum.begin()
        if authority <= 0.0:
            self._drum.begin()
            self._swing.begin(self._swing.reference)
            self._depth.begin()

    def _judge_quickly(self, *, has_feedback: bool) -> None:
        if self._depth.is_above:
            amplitude = self._depth.amplitude
            self.trusts_estimate = False
            self._fade(
                f"compensation does harm: the depth sensor sees the unit move {amplitude:.3f} m, more than the "
                "sea would have it"
            )
        elif has_feedback and self._swing.is_above:
            amplitude = self._swing.amplitude
            self._fade(f"compensation does harm: the unit swings {amplitude:.3f} m, more than the sea would have it")
        elif has_feedback and self._drum.is_above:
            amplitude = self._drum.amplitude
            self._fade(
                f"compensation does harm: the drum runs {amplitude:.3f} m/s off the boom tip, more than that "
                "itself moves"
            )

    def _distrust(self) -> None:
        self.trusts_estimate = False
        amplitude = self._doubt.amplitude
        self.hold_off(
            f"the depth sensor contradicts the estimate by {amplitude:.3f} m: no compensation before they agree"
        )

    def _judge(self) -> None:
        parameters = self._parameters
        if self._on_time < 0.5 * parameters.window:
            return
        residual, uncompensated = self.residual_sigma, self.uncompensated_sigma
        if residual > parameters.floor and residual > parameters.harm_ratio * uncompensated:
            self._fade(f"compensation does harm: residual {residual:.3f} m against {uncompensated:.3f} m uncompensated")
        elif self._on_time > 4.0 * self._hold:
            self._hold = parameters.hold_time

    def _fade(self, reason: str) -> None:
        self.is_harming = True
        self._off_time = 0.0
        self.reason = reason

    def _wait(self, authority: float) -> None:
        """Count the time off, and let compensation be tried again."""
        if authority > 0.0:
            return
        self._off_time += self._dt
        if self._off_time >= self._hold and self.demand <= self._parameters.demand_ratio:
            self.is_harming = False
            self.trusts_estimate = True
            self.reason = ""
            self._hold = min(HOLD_GROWTH * self._hold, self._parameters.hold_time_limit)
            self._on_time = 0.0
            self._reset_sigmas()
