"""Cable, unit and MRU by the whole record at once: the likeliest values, and their spread.

They are judged by depth and load cell, against the twin itself, where waves are. The twin is not linear: drag, slack,
and a memory as long as a record are in it. Its boom tip is Wiener's estimate, with an error that does not depend on the
estimate and biases nothing; depth and tension share that error. Gauss-Newton from several starts: a resonance is
narrow. Where readings and twin differ by more than their noise, the rest counts as noise, not as evidence.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from cable_sim_node.vertical.axial_line import AxialLine
from heave_node.numerics.arrays import Array, ComplexArray
from winch_controller_node.node_parameters import WinchControllerParameters

from heave_studies.whatif.record import SensorRecord
from heave_studies.whatif.spectra import BAND, Speeds, Tip, TipSource, Transform, gains_over_top, noise_power
from heave_studies.whatif.twin import Drive, Follow, PastWinch, PlantFactors, PlantMotion, followed, scaled_line

INERTIA, DAMPING, CABLE_DRAG = "cable.inertia_factor", "cable.damping_factor", "cable.drag_factor"
STIFFNESS, SCALE, DELAY = "cable.stiffness_factor", "mru.scale", "mru.delay"

AS_THEY_ARE = {DELAY: "s"}
"""Quantities that are 0 where all is as assumed, with their units; the others are factors."""

USUAL = {INERTIA: 0.15, DAMPING: 0.6, CABLE_DRAG: 0.3, STIFFNESS: 0.1, SCALE: 0.02, DELAY: 0.04}
"""Standard deviation of each about what is assumed: of the logarithm of a factor [-], of a delay [s] or an arm [m]."""


def prior_of(nominal: WinchControllerParameters) -> dict[str, float]:
    """Return the standard deviation of each quantity before the record, for `nominal` parameters of the controller."""
    mru = nominal.sensors.mru
    known = {SCALE: mru.scale_sigma}
    return {name: max(usual, known.get(name, 0.0)) for name, usual in USUAL.items()}


BEGINS = 30.0
"""Time after the start of a record from which it is judged [s]: plant and sea may begin at rest."""

LONGEST, MEMORY = 900.0, 180.0
"""Longest part of a record that is judged, its last, and what the twin runs before it [s]: a resonance remembers."""

INDEPENDENT = 0.6
"""Independent values a frequency under a Hann taper."""

LEAKS, FINER = 2, 16
"""Bins on either side into which a Hann taper leaks, and parts of a bin that are looked at. A part is also the least
half width of a resonance: what rings longer than 2.5 records has not yet risen in one."""

LEAST_CELL = 100
"""Readings of a load cell below which it is not asked."""

Values = Mapping[str, float]


@dataclass(frozen=True)
class Evidence:
    """A record, and what cable, unit and MRU are judged by in it."""

    record: SensorRecord  # of the sensors
    nominal: WinchControllerParameters  # parameters of the controller
    assumed: AxialLine  # cable and unit as those have them
    source: TipSource  # of the boom tip
    winch: PastWinch  # what the drum did
    depth_scale: float  # reading over truth [-]

    @property
    def end(self) -> float:
        """Time up to which it is judged [s]."""
        return float(self.record.time[-1])

    @property
    def start(self) -> float:
        """Time from which it is judged [s]."""
        return max(float(self.record.time[0]) + BEGINS, self.end - LONGEST)

    @property
    def ticks(self) -> slice:
        """Ticks over which the twin runs."""
        first, last = np.searchsorted(self.record.time, (self.start - MEMORY, self.end + self.record.tick_period))
        return slice(int(first), int(last))

    @cached_property
    def omegas(self) -> Array:
        """Angular frequencies that are judged (k,) [rad/s]."""
        return np.arange(BAND[0], BAND[1], 2.0 * math.pi / (self.end - self.start))

    @cached_property
    def readings(self) -> tuple[tuple[Array, Array], ...]:
        """Times and values of what is read: heave of the unit [m], and the top tension [N] where it is."""
        times, depth = self.record.scalar("depth").T
        cell = self.record.scalar("load_cell")
        cells = ((cell[:, 0], cell[:, 1]),) if len(cell) >= LEAST_CELL else ()
        return ((times, -depth / self.depth_scale), *cells)

    @cached_property
    def noise(self) -> Array:
        """Power of the noise of each of the readings (m,)."""
        stated = (self.nominal.sensors.depth.noise, math.inf)
        pairs = zip(self.readings, stated, strict=False)
        return np.array([noise_power(*one, self.start, self.end, own) for one, own in pairs])

    @cached_property
    def _transforms(self) -> tuple[Transform, ...]:
        return tuple(Transform(times, self.omegas, self.start, self.end) for times, _ in self.readings)

    @cached_property
    def seen(self) -> ComplexArray:
        """Transforms of the readings (m, k)."""
        return np.array([of(one) for of, (_, one) in zip(self._transforms, self.readings, strict=True)])

    @cached_property
    def tip_noise(self) -> Array:
        """Power of what is not known of the boom tip (k,) [m2 s]: heave and its rate are two readings of it."""
        time, heave, rate = self.record.mru.T
        power = np.full(len(self.omegas), 1.0 / noise_power(time, heave, self.start, self.end, self.source.plain.sigma))
        if np.isfinite(rate).all():
            power += self.omegas**2 / noise_power(time, rate, self.start, self.end, self.source.plain.sigma)
        return np.asarray(1.0 / (power * np.abs(self.source.high_pass.response(self.omegas)) ** 2))

    def line(self, values: Values) -> AxialLine:
        """Return cable and unit under `values`, their stiffness as nominal."""
        factors = PlantFactors(values[INERTIA], values[DAMPING], values[CABLE_DRAG])
        return scaled_line(self.assumed, factors)

    def tip(self, values: Values) -> Tip:
        """Return the boom tip under `values`."""
        return self.source.under(values[SCALE], values[DELAY])

    def drive(self, values: Values, ticks: slice) -> Drive:
        """Return what moves the twin under `values` over some `ticks`, its stiffness as nominal."""
        tip, winch = self.tip(values), self.winch
        return Drive(
            self.line(values),
            self.nominal.length,
            Tip(tip.heave[ticks], tip.rate[ticks], tip.sigma),
            winch.payout[ticks],
            winch.rate[ticks],
            self.record.tick_period,
        )

    def twin(self, values: Values, motion: PlantMotion) -> ComplexArray:
        """Return the transforms of what the twin would have read under `values`, of its `motion` (m, k)."""
        time = self.record.time[self.ticks]
        moved = (motion.unit, values[STIFFNESS] * motion.tension)
        return np.array(
            [
                of(np.interp(times, time, one))
                for of, (times, _), one in zip(self._transforms, self.readings, moved, strict=False)
            ]
        )

    def covariance(self, values: Values, noise: Array) -> ComplexArray:
        """Return the covariance of readings about the twin at each frequency (k, m, m).

        Parameters
        ----------
        values : of cable, unit and MRU, about which it is linear
        noise : power of what else is in each of the readings (m,)
        """
        # power spectrum of the Hann taper, x bins from its middle: (sinc(x)/(1 - x^2))^2
        x = (np.arange(2 * LEAKS * FINER) + 0.5) / FINER - LEAKS
        leak = (np.sinc(x) / (1.0 - x**2)) ** 2
        omegas = self.omegas[:, None] + (x - 1j / FINER) * (self.omegas[1] - self.omegas[0])
        H = gains_over_top(self.line(values), self.nominal.length, omegas.ravel(), self._speeds)
        g = (H * np.array([[1.0], [values[STIFFNESS]]]))[: len(noise)].reshape(len(noise), *omegas.shape)
        shared = np.einsum("x,ikx,jkx->kij", leak / np.sum(leak), g, np.conj(g))
        return np.asarray(self.tip_noise[:, None, None] * shared + np.diag(noise))

    def by_tip(self, values: Values) -> float:
        """Return the standard deviation of the unit's motion under `values` by what is not known of the boom tip [m].

        The depth sensor has seen the unit: what the tip leaves open at a resonance is no more than the sensor's noise.
        """
        open_ = self.covariance(values, np.zeros(len(self.readings)))[:, 0, 0].real
        power = open_ * self.noise[0] / (open_ + self.noise[0])
        # one-sided density over omega: twice the power over 2 pi
        step = float(self.omegas[1] - self.omegas[0])
        return math.sqrt(float(np.sum(power)) * step / math.pi)

    @cached_property
    def _speeds(self) -> Speeds:
        """Speeds by which drag is linearised: of the unit as read, and of the outlet."""
        inside = (self.record.time >= self.start) & (self.record.time <= self.end)
        outlet = self.source.plain.rate - self.winch.rate
        step = self.omegas[1] - self.omegas[0]
        power = np.maximum(np.abs(self.seen[0]) ** 2 - self.noise[0], 0.0)
        # one-sided density over omega: twice the power over 2 pi
        unit = math.sqrt(float(np.sum(self.omegas**2 * power)) * step / math.pi)
        return Speeds(unit, float(np.std(outlet[inside])))


STEPS = {
    INERTIA: 0.003,
    DAMPING: 0.05,
    CABLE_DRAG: 0.05,
    STIFFNESS: 0.003,
    SCALE: 0.003,
    DELAY: 0.003,
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
        held = {STIFFNESS} if len(noise) < 2 else set()
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
    """Return the likeliest values.

    Parameters
    ----------
    evidence : of the record
    follow : returns the motions of twins
    """
    prior, centre = prior_of(evidence.nominal), values_at(np.zeros(len(USUAL)), USUAL)
    starts: list[Values] = [centre, *({**centre, INERTIA: math.exp(one)} for one in STARTS)]
    return _fitted(evidence, prior, centre, starts, follow)


def _fitted(evidence: Evidence, prior: Values, about: Values, starts: list[Values], follow: Follow) -> CableFit:
    """Return the likeliest values from several `starts`; `follow` returns the motions of twins."""
    noise = evidence.noise.copy()
    search = Search(evidence, prior, about, noise, follow)
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
        float(_chi2(evidence, values, best.gap)[0]),
    )


def _chi2(evidence: Evidence, values: Values, gap: ComplexArray) -> Array:
    """Return the mean square of the `gap` of a twin under `values` to each of the readings over its noise (m,)."""
    held = np.einsum("kii->ik", evidence.covariance(values, evidence.noise)).real
    return np.asarray(np.mean(np.abs(gap) ** 2 / held, axis=1))
