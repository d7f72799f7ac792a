"""The figures that a plan predicts: those of bags (`heave_bags.analyse.kpi_set`), from standard deviations.

A phase is a number of places, each with the time that the unit spends there. A Gaussian signal of standard deviation s
about a mean m crosses the level y upwards nu exp(-(y - m)^2/(2 s^2)) times a second (Rice 1944). The largest value that
is expected of a phase is the level that is crossed exp(-0.577) times in it: the mean of the extreme value distribution
(Cartwright and Longuet-Higgins 1956, in the limit of many crests), with the places taken together. Three things change
it:

- crests that come in groups, which count as fewer (Vanmarcke 1975, J. Applied Mechanics 42, with the width of the
  spectrum to the power of 1.2);
- a kurtosis below 3 and a skewness: the level y is reached as often as the level x + (3 - kurtosis)/24 (x^3 - 3 x) -
  skewness/6 (x^2 - 1) of a Gaussian signal, x = (y - m)/s (Winterstein 1988, J. Engineering Mechanics 114, hardening
  response to first order). Quadratic drag holds waves down, and those of a unit that is lowered more on one side.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from heave_node.loads.strength import ATTACHMENT, ROPE, WINCH_PULL, safety_factor
from heave_node.numerics.arrays import Array
from scipy.optimize import brentq


class Shape(NamedTuple):
    """What of a signal's distribution is not its standard deviation: kurtosis and skewness [-]."""

    kurtosis: float = 3.0
    skewness: float = 0.0


GAUSSIAN = Shape()
EXPECTED = math.exp(-np.euler_gamma)
"""Crossings of the level that is the mean of the largest value."""
SIGNIFICANT = 2.0
"""Significant amplitude of a Gaussian signal over its standard deviation, the mean of its highest third."""


class Swing(NamedTuple):
    """How a signal swings."""

    sigma: float  # standard deviation [m]
    rate: float  # upward crossings of its mean [1/s]
    width: float = 1.0  # of its spectrum, sqrt(1 - m1^2/(m0 m2)): small where crests come in groups [-]
    shape: Shape = GAUSSIAN  # of its distribution

    @property
    def mirrored(self) -> Swing:
        """The signal with its sign turned."""
        return self._replace(shape=Shape(self.shape.kurtosis, -self.shape.skewness))

    def times(self, factor: float) -> Swing:
        """Return the same signal a `factor` larger."""
        return self._replace(sigma=self.sigma * factor)


STILL = Swing(0.0, 0.1)


class Motion(NamedTuple):
    """How unit, cable and winch swing."""

    tension: Swing  # top tension [N]
    attachment: Swing  # tension at the unit [N]
    unit: Swing  # heave of the unit [m]
    winch_speed: Swing = STILL  # of compensation [m/s]
    winch_acceleration: Swing = STILL  # of compensation [m/s^2]

    def times(self, factor: float) -> Motion:
        """Return the same motion a `factor` larger."""
        return Motion(*(swing.times(factor) for swing in self))


@dataclass(frozen=True)
class Place:
    """A place on the way of a phase, and how unit and cable move there."""

    duration: float  # that the unit spends there [s]
    static: float  # top tension at rest [N]
    drag: float  # of the mean motion, added to it: negative while lowering [N]
    weight: float  # of the unit in water, which its attachment carries at rest [N]
    speed: float  # mean speed of the unit, positive downwards [m/s]
    motion: Motion  # about that


Capacity = Mapping[str, float]
"""What the parts of the lift can carry [N], by the key of their safety factor."""

Places = Sequence[Place]


def expected_largest(means: Array, swings: Sequence[Swing], durations: Array) -> float:
    """Return the largest value that is expected of a signal, see the module.

    Parameters
    ----------
    means : of the signal by place, shape (n,)
    swings : about them, n of them
    durations : at each place [s], shape (n,)
    """
    sigma = np.array([one.sigma for one in swings])
    count = np.array([one.rate for one in swings]) * durations
    count *= max(1.0, 1.0 / max(float(count.sum()), 1e-12))  # one cycle at least
    if not sigma.any():
        return float(means.max())
    spread = np.maximum(sigma, 1e-9 * sigma.max())
    width = np.array([one.width for one in swings])
    kurtosis, skewness = np.array([one.shape for one in swings]).T
    hardening = (GAUSSIAN.kurtosis - kurtosis) / 24.0

    def excess(level: float) -> float:
        above = np.maximum(level - means, 0.0) / spread
        gaussian = above + hardening * (above**3 - 3.0 * above) - skewness / 6.0 * (above**2 - 1.0)
        normal = np.maximum(np.where(above > 0.0, gaussian, 0.0), 1e-6)
        grouped = -np.expm1(-math.sqrt(2.0 * math.pi) * width**1.2 * normal) / -np.expm1(-0.5 * normal**2)
        return float((count * np.minimum(grouped, 1.0)) @ np.exp(-0.5 * normal**2)) - EXPECTED

    low, high = float(means.min()), float(means.max() + 12.0 * sigma.max())
    if excess(low) <= 0.0:
        return float(means.max())
    return float(brentq(excess, low, high, xtol=1e-9 * float(sigma.max())))


def _largest(places: Places, swing: Callable[[Place], Swing], mean: Callable[[Place], float]) -> float:
    return expected_largest(
        np.array([mean(one) for one in places]),
        [swing(one) for one in places],
        np.array([one.duration for one in places]),
    )


def _factor(capacity: Capacity, part: str, load: float) -> float:
    return safety_factor(capacity.get(part, math.nan), load)


def _two_sided(swing: Swing) -> Swing:
    return swing._replace(rate=2.0 * swing.rate)


def _no_mean(_: Place) -> float:
    return 0.0


def _sigma(places: Places) -> float:
    total = sum(one.duration for one in places)
    return math.sqrt(sum(one.duration * one.motion.unit.sigma**2 for one in places) / total)


def _amplification(places: Places) -> float:
    return _largest(
        places, lambda one: one.motion.tension.times(1.0 / one.static), lambda one: 1.0 + one.drag / one.static
    )


def _smallest_ratio(places: Places) -> float:
    return -_largest(
        places,
        lambda one: one.motion.tension.mirrored.times(1.0 / one.static),
        lambda one: -1.0 - one.drag / one.static,
    )


def _load(places: Places) -> float:
    return _largest(places, lambda one: one.motion.tension, lambda one: one.static + one.drag)


def _slack(places: Places) -> float:
    """Return the share of time without tension at the top or the unit [%]; 0 where none is expected in the phase."""
    total = sum(one.duration for one in places)
    ends: tuple[tuple[Callable[[Place], Swing], Callable[[Place], float]], ...] = (
        (lambda one: one.motion.tension.mirrored, lambda one: one.static + one.drag),
        (lambda one: one.motion.attachment.mirrored, lambda one: one.weight + one.drag),
    )
    largest = 0.0
    for swing, mean in ends:
        if _largest(places, swing, lambda one, mean=mean: -mean(one)) >= 0.0:  # type: ignore[misc]
            shares = (one.duration / total * _below_zero(mean(one), swing(one).sigma) for one in places)
            largest = max(largest, sum(shares))
    return 100.0 * largest


def _below_zero(mean: float, sigma: float) -> float:
    return 0.5 * math.erfc(mean / sigma / math.sqrt(2.0)) if sigma > 0.0 else 0.0


Formula = Callable[[Places, Capacity], float]

PLANNED: Mapping[str, Formula] = {
    "dynamic_amplification": lambda places, _: _amplification(places),
    "tension_ratio_min": lambda places, _: _smallest_ratio(places),
    ROPE: lambda places, capacity: _factor(capacity, ROPE, _load(places)),
    WINCH_PULL: lambda places, capacity: _factor(capacity, WINCH_PULL, _load(places)),
    ATTACHMENT: lambda places, capacity: _factor(
        capacity, ATTACHMENT, _largest(places, lambda one: one.motion.attachment, lambda one: one.weight + one.drag)
    ),
    "tension_max_n": lambda places, _: _load(places),
    "slack_percent": lambda places, _: _slack(places),
    "unit_sigma_m": lambda places, _: _sigma(places),
    "significant_residual_m": lambda places, _: 4.0 * _sigma(places),
    "max_abs_heave_m": lambda places, _: _largest(places, lambda one: _two_sided(one.motion.unit), _no_mean),
    "touchdown_speed_mps": lambda places, _: max(
        one.speed + SIGNIFICANT * 2.0 * math.pi * one.motion.unit.rate * one.motion.unit.sigma for one in places
    ),
    "winch_speed_max_mps": lambda places, _: _largest(
        places,
        lambda one: one.motion.winch_speed if one.speed else _two_sided(one.motion.winch_speed),
        lambda one: abs(one.speed),
    ),
    "winch_acceleration_max_mps2": lambda places, _: _largest(
        places, lambda one: _two_sided(one.motion.winch_acceleration), _no_mean
    ),
}
"""What a plan predicts, by the key of the figure of a bag.

The speed at touchdown is that of a significant amplitude of the unit's speed on top of the mean speed.
"""
