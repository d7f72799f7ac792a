"""What the sea that is seen now asks of the winch, and so what share of it a law may be given."""

from __future__ import annotations

import math

from winch_controller_node.core.supervision.checks import RunningSigma
from winch_controller_node.laws.parts.effort import Effort
from winch_controller_node.laws.parts.winch_limits import WinchLimits

PEAK = 3.0
"""Peak amplitude over standard deviation of a sea, over some minutes."""

SIGNIFICANT = 2.0
"""Significant amplitude over standard deviation of a narrow-banded sea."""

HIGHEST_TIME = 300.0
"""Memory of the highest crest [s]: some thirty waves, of which one is above the significant amplitude."""

GROUP_TIME, GROUP_PEAK = 8.0, 2.2
"""Memory that sees a group of high waves come [s], and peak amplitude over standard deviation within one."""

GROWING = 4.0
"""A sea grows if the later half of what was seen of it has so many times the energy of the earlier half."""

GROWING_PEAK = 2.35
"""Peak amplitude over standard deviation of its last waves then: the next ones are higher."""

FIRST_LOOK = 120.0
"""Time for which that is asked [s]: from then on the earlier record distinguishes the two."""


class WinchDemand:
    """Speed and acceleration of the boom tip over the last waves and within the present group of waves.

    Parameters
    ----------
    window : memory of the waves [s]
    tick_period : [s]
    """

    def __init__(self, window: float, *, tick_period: float) -> None:
        self._dt = tick_period
        self._growth = _Growth(round(FIRST_LOOK / tick_period))
        self._rate = RunningSigma(window, tick_period)
        self._acceleration = RunningSigma(window, tick_period)
        self._group_rate = RunningSigma(GROUP_TIME, tick_period)
        self._group_acceleration = RunningSigma(GROUP_TIME, tick_period)
        self._highest_rate = self._highest_acceleration = 0.0
        self._decay = math.exp(-tick_period / HIGHEST_TIME)
        self._last_rate: float | None = None

    def add(self, rate: float) -> None:
        """Take in the heave rate of the boom tip at a tick [m/s]."""
        self._growth.add(rate)
        self._rate.add(rate)
        self._group_rate.add(rate)
        self._highest_rate = max(abs(rate), self._decay * self._highest_rate)
        if self._last_rate is not None:
            acceleration = (rate - self._last_rate) / self._dt
            self._acceleration.add(acceleration)
            self._group_acceleration.add(acceleration)
            self._highest_acceleration = max(abs(acceleration), self._decay * self._highest_acceleration)
        self._last_rate = rate

    def significant(self, limits: WinchLimits) -> float:
        """Return the significant amplitude over its limit in `limits`, the larger of speed and acceleration [-].

        That of waves which are all of one height is no more than the highest of them.
        """
        return self._over(limits, self._rate.sigma, self._acceleration.sigma)

    def coming(self, limits: WinchLimits) -> float:
        """Return the same over `limits` of a sea that is seen first and grows: it is as high as its last waves [-]."""
        if not self._growth.is_seen:
            return self.significant(limits)
        return self._over(
            limits,
            max(self._rate.sigma, self._group_rate.sigma),
            max(self._acceleration.sigma, self._group_acceleration.sigma),
        )

    def _over(self, limits: WinchLimits, rate: float, acceleration: float) -> float:
        """Return the significant amplitude of standard deviations [m/s], [m/s^2] over the `limits` [-]."""
        speed = min(SIGNIFICANT * rate, self._highest_rate)
        acceleration = min(SIGNIFICANT * acceleration, self._highest_acceleration)
        return max(speed / limits.usual_speed, acceleration / limits.acceleration)

    def largest_share(self, limits: WinchLimits, effort: Effort, limit_use: float) -> float:
        """Return the largest authority, up to 1, whose peaks take up no more than `limit_use` of the limits.

        `effort` is that of the law, over what the boom tip's own motion asks for.
        """
        group_peak = GROWING_PEAK if self._growth.is_seen else GROUP_PEAK
        speed = max(PEAK * self._rate.sigma, group_peak * self._group_rate.sigma)
        acceleration = max(PEAK * self._acceleration.sigma, group_peak * self._group_acceleration.sigma)
        peak = max(effort.speed * speed / limits.usual_speed, effort.acceleration * acceleration / limits.acceleration)
        return min(1.0, limit_use / peak) if peak > 0.0 else 1.0


class _Growth:
    """Whether a sea grows that is seen for the first time: what is seen of it is no group of high waves then.

    Parameters
    ----------
    ticks : for which that is asked
    """

    def __init__(self, ticks: int) -> None:
        self._ticks = ticks
        self._energies = [0.0]

    def add(self, value: float) -> None:
        """Take in a tick."""
        if len(self._energies) <= self._ticks:
            self._energies.append(self._energies[-1] + value**2)

    @property
    def is_seen(self) -> bool:
        """Tell whether the sea grows."""
        count = len(self._energies)
        if count > self._ticks:
            return False
        early = self._energies[count // 2]
        return self._energies[-1] - early > GROWING * early
