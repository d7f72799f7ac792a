"""Cable, unit and MRU by the whole record at once: the likeliest values, and their spread.

Gauss-Newton on the twin from several starts: a resonance is narrow. Where readings and twin differ by more than their
noise, the rest counts as noise, not as evidence.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from heave_node.numerics.arrays import Array, ComplexArray
from winch_controller_node.adviser.hypothesis import HIGH_PASS, PRICES, TRIED

from heave_studies.whatif.identify.evidence import (
    AS_THEY_ARE,
    CABLE_DRAG,
    DAMPING,
    DELAY,
    INDEPENDENT,
    INERTIA,
    LEVER_ARM,
    SCALE,
    STIFFNESS,
    USUAL,
    Evidence,
    Values,
    prior_of,
)
from heave_studies.whatif.signals.tip import TipSource, tip_source
from heave_studies.whatif.twin.plant import Follow, followed

STEPS = {
    INERTIA: 0.003,
    DAMPING: 0.05,
    CABLE_DRAG: 0.05,
    STIFFNESS: 0.003,
    SCALE: 0.003,
    DELAY: 0.003,
    LEVER_ARM: 0.01,
}
"""Steps for the slopes of the twin: of the logarithm of a factor, of a delay [s], of an arm [m]."""

STARTS = (-0.3, -0.2, -0.12, -0.06, 0.0, 0.06, 0.12, 0.2, 0.3)
"""Logarithms of the inertia that are tried first."""

BEST = 3
"""Number of starts that are followed."""

FIRST, ROUNDS, HALVINGS, SETTLED = 2, 8, 4, 0.1
"""Gauss-Newton steps from each start, and from the best of them at most; how often one is halved; and a step in
standard deviations that ends it."""

WIDER = 1.5
"""Factor on the standard deviations in draws: a spread by slopes and white noise alone covered 10 of 17 in a trial."""

ALIKE = 1.2
"""Noise that has grown by less is the same."""

TELLS = 0.5
"""A quantity whose standard deviation is less than so much of its usual one is known."""


@dataclass(frozen=True)
class CableFit:
    """What the record says of cable, unit and MRU."""

    values: Mapping[str, float]  # about what is assumed, by name: factors [-], delay [s], lever arm [m]
    covariance: Array = field(repr=False)  # of the logarithms of the factors, and of the others, in that order
    prior: Values  # standard deviations of what was known before
    source: TipSource = field(repr=False)  # of the boom tip
    loss: float  # at the values [nats]
    chi2: float  # mean square of what is left of the depth readings over their noise [-]

    def sigma(self, name: str) -> float:
        """Standard deviation of the value `name`: relative for a factor, else in its unit."""
        place = list(self.values).index(name)
        return math.sqrt(float(self.covariance[place, place]))

    def tells(self, name: str) -> bool:
        """Return whether the record says more of the value `name` than was known before."""
        return self.sigma(name) < TELLS * self.prior[name]

    def off_prior(self, name: str) -> float:
        """Return how far the value `name` is from what was known before, in standard deviations of that."""
        value = self.values[name] if name in AS_THEY_ARE else math.log(self.values[name])
        return abs(value) / self.prior[name]

    def drawn(self, random: np.random.Generator) -> CableFit:
        """Return a fit with other values that the record allows, by `random` numbers."""
        moves = WIDER * random.multivariate_normal(np.zeros(len(self.values)), self.covariance)
        return replace(self, values=values_at(point_of(self.values) + moves, self.values))


class Point(NamedTuple):
    """A point of the search."""

    x: Array  # logarithms of the factors, the others as they are
    gap: ComplexArray  # what the twin leaves of the readings there (m, k)
    left: ComplexArray  # the same, whitened (k, m)
    loss: float  # there [nats]


def point_of(values: Values) -> Array:
    """Return the point at which `values` are: logarithms of factors, the others as they are."""
    return np.array([value if name in AS_THEY_ARE else math.log(value) for name, value in values.items()])


def values_at(x: Array, names: Values) -> dict[str, float]:
    """Return the values at a point `x`, with `names` in its order."""
    return {name: float(v) if name in AS_THEY_ARE else math.exp(v) for name, v in zip(names, x, strict=True)}


class Search:
    """Search for the likeliest values under some evidence.

    Parameters
    ----------
    evidence : of the record
    prior : what is known before
    about : values about which the error of the boom tip goes into the readings
    noise : power of what else is in them
    follow : returns the motions of twins
    """

    def __init__(self, evidence: Evidence, prior: Values, about: Values, noise: Array, follow: Follow) -> None:
        self._evidence, self._about, self._follow = evidence, about, follow
        self._sigma = np.array([prior[name] for name in about])
        self._steps = np.array([STEPS[name] for name in about])
        self._whiten = np.linalg.inv(np.linalg.cholesky(evidence.covariance(about, noise)))
        held = {LEVER_ARM} if not evidence.source.turns else set()
        held |= {STIFFNESS} if len(noise) < 2 else set()
        self._free = [place for place, name in enumerate(about) if name not in held]

    def at(self, *places: Array) -> list[Point]:
        """Return the points at some `places`: logarithms of the factors, the others as they are."""
        evidence, of_places = self._evidence, [values_at(x, self._about) for x in places]
        motions = self._follow([evidence.drive(values, evidence.ticks) for values in of_places])
        twins = map(evidence.twin, of_places, motions)
        return [self._point(x, evidence.seen - twin) for x, twin in zip(places, twins, strict=True)]

    def _point(self, x: Array, gap: ComplexArray) -> Point:
        """Return the point `x`, at which the twin leaves this `gap` to the readings."""
        left = np.einsum("kij,jk->ki", self._whiten, gap)
        off = x / self._sigma
        return Point(x, gap, left, float(INDEPENDENT * np.sum(np.abs(left) ** 2) + 0.5 * off @ off))

    def followed(self, point: Point, rounds: int) -> tuple[Point, Array]:
        """Return the least point near a `point`, after so many `rounds` at most, and the covariance there."""
        count = len(point.x)
        for _ in range(rounds):
            slopes = np.zeros((2 * point.left.size, count))
            beside = self.at(*(point.x + self._steps[place] * np.eye(count)[place] for place in self._free))
            for place, moved in zip(self._free, beside, strict=True):
                slopes[:, place] = _real(moved.left - point.left) / self._steps[place]
            curvature = slopes.T @ slopes + np.diag(self._sigma**-2.0)
            pull = slopes.T @ _real(point.left) + point.x / self._sigma**2
            move = -np.linalg.solve(curvature, pull)
            covariance = np.asarray(np.linalg.inv(curvature))
            before = point
            for _ in range(HALVINGS):
                (tried,) = self.at(before.x + move)
                if tried.loss < before.loss:
                    point = tried
                    break
                move = 0.5 * move
            if point is before or math.sqrt(float(move @ curvature @ move)) < SETTLED:
                break
        return point, covariance


def _real(values: ComplexArray) -> Array:
    """Return complex `values` of variance 1 as twice as many real ones, by how many of them are independent."""
    flat = math.sqrt(2.0 * INDEPENDENT) * values.ravel()
    return np.concatenate([flat.real, flat.imag])


def fit_cable(evidence: Evidence, follow: Follow = followed) -> CableFit:
    """Return the likeliest values, with another high-pass of the MRU where it is worth its price.

    Parameters
    ----------
    evidence : of the record
    follow : returns the motions of twins
    """
    prior, centre = prior_of(evidence.nominal), values_at(np.zeros(len(USUAL)), USUAL)
    starts: list[Values] = [centre, *({**centre, INERTIA: math.exp(one)} for one in STARTS)]
    fit = _fitted(evidence, prior, centre, starts, follow)
    assumed = evidence.source.high_pass
    x, noise = point_of(fit.values), evidence.noise
    held = Search(evidence, prior, fit.values, noise, follow).at(x)[0].loss
    for period in TRIED[HIGH_PASS]:
        if period == assumed.period:
            continue
        source = tip_source(evidence.record, evidence.source.assumed, assumed._replace(period=period))
        other = replace(evidence, source=source)
        # at the same values first: it is seldom worth a search of its own
        if held - Search(other, prior, fit.values, noise, follow).at(x)[0].loss > PRICES[HIGH_PASS]:
            tried = _fitted(other, prior, fit.values, [fit.values], follow)
            fit = tried if tried.loss < fit.loss - PRICES[HIGH_PASS] else fit
    return fit


def _fitted(evidence: Evidence, prior: Values, about: Values, starts: list[Values], follow: Follow) -> CableFit:
    """Return the likeliest values from several `starts`; `follow` returns the motions of twins."""
    noise = evidence.noise.copy()
    first = search = Search(evidence, prior, about, noise, follow)
    begun = search.at(*map(point_of, starts))
    if len(starts) > 1:
        # a compensated record shows scale and delay of its MRU first: the resonance is looked for under them
        held = values_at(search.followed(begun[0], FIRST)[0].x, about)
        begun += search.at(*(point_of({**held, INERTIA: one[INERTIA]}) for one in starts))
    begun = sorted(begun, key=lambda one: one.loss)[:BEST]
    best, covariance = min((search.followed(one, FIRST) for one in begun), key=lambda pair: pair[0].loss)
    is_settled = False
    for _ in range(2):
        values = values_at(best.x, about)
        excess = np.maximum(_chi2(evidence, values, best.gap), 1.0)
        if np.any(excess * evidence.noise > ALIKE * noise) or not is_settled:
            noise, is_settled = evidence.noise * excess, True
            search = Search(evidence, prior, values, noise, follow)
            best, covariance = search.followed(search.at(best.x)[0], ROUNDS)
    values = values_at(best.x, about)
    return CableFit(
        values,
        covariance,
        prior,
        evidence.source,
        first.at(best.x)[0].loss,
        float(_chi2(evidence, values, best.gap)[0]),
    )


def _chi2(evidence: Evidence, values: Values, gap: ComplexArray) -> Array:
    """Return the mean square of the `gap` of a twin under `values` to each of the readings over its noise (m,)."""
    held = np.einsum("kii->ik", evidence.covariance(values, evidence.noise)).real
    return np.asarray(np.mean(np.abs(gap) ** 2 / held, axis=1))
