"""Never worse than off: compares the residual with what the unit would do uncompensated, live, from estimates.

Over some waves exponentially weighted variances of both are compared: compensation must be better than none. A loop
that is lost pumps energy into a unit that then swings for minutes, so that the guard must not wait for waves: over
seconds it compares the swing of the unit, z^2 + a z'^2, with that of the uncompensated one now and in the last waves.
Compensation that does harm is faded out; after a hold time, which doubles with every harm, it is tried again once the
sea asks for no more than the winch can give.
"""

from __future__ import annotations

import math

from winch_controller_node.law_parameters import GuardParameters
from winch_controller_node.laws.governor import WinchLimits

SLOW_MEAN_FACTOR = 3.0
"""The mean about which motion is judged is followed this many times more slowly than the variance."""

FULL_SHARE = 0.95
"""Share of the wanted authority from which on compensation is judged."""

PEAK = 3.0
"""Peak amplitude over standard deviation of a sea, over some minutes."""

QUICK_TIME = 3.0
"""Memory of the quick comparison [s]."""

QUICK_FLOORS = 10.0
"""Quick comparison: swings below so many times the floor are left to the slow one."""

QUICK_RATIO = 1.5
"""Quick comparison: harm above this ratio to the largest of what the sea gives now and in the last waves."""

SIGNIFICANT = 2.0
"""Significant amplitude over standard deviation of a narrow-banded sea."""


Motion = tuple[float, float]
"""Heave [m] and heave rate [m/s]."""


class RunningSigma:
    """Exponentially weighted standard deviation about a slow mean.

    Parameters
    ----------
    time_constant : memory [s]
    tick_period : [s]
    """

    def __init__(self, time_constant: float, tick_period: float) -> None:
        self._weight = tick_period / time_constant
        self._count = 0
        self._mean = 0.0
        self._variance = 0.0

    def add(self, value: float) -> None:
        """Take a value in; the first ones weigh as in a plain average."""
        self._count += 1
        weight = max(self._weight, 1.0 / self._count)
        self._mean += max(self._weight / SLOW_MEAN_FACTOR, 1.0 / self._count) * (value - self._mean)
        self._variance += weight * ((value - self._mean) ** 2 - self._variance)

    @property
    def sigma(self) -> float:
        """Standard deviation, in the unit of the values."""
        return math.sqrt(self._variance)


class QuickComparison:
    """Compares two motions over seconds by their energy; the reference also by that of the last waves.

    Parameters
    ----------
    window : memory of the waves [s]
    tick_period : [s]
    """

    def __init__(self, window: float, tick_period: float) -> None:
        self._quick, self._slow = tick_period / QUICK_TIME, tick_period / window
        self._count = 0
        self._patience = round(0.5 * window / tick_period)
        self._energy = self._reference = self._waves = 0.0

    def add(self, energy: float, reference: float, *, is_on: bool) -> None:
        """Take in the energies of a tick [m^2]; while compensation is off they are the same."""
        self._count += 1
        least = 1.0 / self._count
        self._reference += max(self._quick, least) * (reference - self._reference)
        self._waves += max(self._slow, least) * (reference - self._waves)
        self._energy += max(self._quick, least) * (energy - self._energy)
        if not is_on:
            self._energy = self._reference

    @property
    def amplitude(self) -> float:
        """Root mean square of the motion [m]."""
        return math.sqrt(self._energy)

    def is_above(self, floor: float) -> bool:
        """Tell whether the motion is above `floor` [m] and surely above the reference, once some waves have come."""
        if self._count < self._patience:
            return False
        return self.amplitude > max(floor, QUICK_RATIO * math.sqrt(max(self._reference, self._waves)))


class HarmGuard:
    """Says when compensation shall be faded out, and when it may be tried again.

    Parameters
    ----------
    parameters : window, ratio, hold times
    limits : of the winch, for what the sea may ask for
    tick_period : [s]

    Attributes
    ----------
    is_harming : compensation is to be off
    reason : in words, empty when all is well
    """

    def __init__(self, parameters: GuardParameters, limits: WinchLimits, *, tick_period: float) -> None:
        self._parameters = parameters
        self._limits = limits
        self._dt = tick_period
        self.is_harming = False
        self.reason = ""
        self._hold = parameters.hold_time
        self._off_time = 0.0
        self._on_time = 0.0
        self._reset_sigmas()
        self._swing = QuickComparison(parameters.window, tick_period)
        self._tip_rate = RunningSigma(parameters.window, tick_period)
        self._tip_acceleration = RunningSigma(parameters.window, tick_period)
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
        peak = PEAK / SIGNIFICANT * self.demand
        return min(1.0, self._parameters.limit_use / peak) if peak > 0.0 else 1.0

    def update(
        self,
        residual: Motion,
        uncompensated: Motion,
        tip_rate: float,
        authority: float,
        target: float = 1.0,
        *,
        inertia: float = 0.0,
        has_feedback: bool = True,
    ) -> None:
        """Take one tick in.

        Parameters
        ----------
        residual, uncompensated : estimated heave [m] and rate [m/s] of the unit with and without compensation
        inertia : a of the two-state cable [s^2]
        has_feedback : the law feeds the unit's motion back, and could be lost; others are judged over waves only
        tip_rate : estimated heave rate of the boom tip [m/s]
        authority : share of the sea that is compensated now
        target : share it goes to; compensation is judged when that is (nearly) reached
        """
        self._tip_rate.add(tip_rate)
        if self._last_rate is not None:
            self._tip_acceleration.add((tip_rate - self._last_rate) / self._dt)
        self._last_rate = tip_rate
        swings = [heave**2 + inertia * rate**2 for heave, rate in (residual, uncompensated)]
        self._swing.add(*swings, is_on=authority > 0.0)
        if self.is_harming:
            self._wait(authority)
            return
        if authority <= 0.0:
            self._on_time = 0.0
            self._reset_sigmas()
            return
        if has_feedback:
            self._judge_quickly()
        if self.is_harming or authority < FULL_SHARE * target:
            return
        self._residual.add(residual[0])
        self._uncompensated.add(uncompensated[0])
        self._on_time += self._dt
        self._judge()

    def _judge_quickly(self) -> None:
        if self._swing.is_above(QUICK_FLOORS * self._parameters.floor):
            amplitude = self._swing.amplitude
            self._fade(f"compensation does harm: the unit swings {amplitude:.3f} m, more than the sea would have it")

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
            self.reason = ""
            self._hold = min(2.0 * self._hold, self._parameters.hold_time_limit)
            self._on_time = 0.0
            self._reset_sigmas()
