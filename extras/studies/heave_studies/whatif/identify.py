"""Cable, unit and MRU by the whole record at once: the likeliest values, and their spread.

They are judged by depth and load cell, against the twin itself, where waves are. The twin is not linear: drag, slack,
and a memory as long as a record are in it. Its boom tip is Wiener's estimate, with an error that does not depend on the
estimate and biases nothing; depth and tension share that error. Least squares from several starts: a resonance is
narrow. Where readings and twin differ by more than their noise, the rest counts as noise, not as evidence.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import ClassVar

import numpy as np
from cable_sim_node.vertical.axial_line import AxialLine
from heave_node.numerics.arrays import Array, ComplexArray
from scipy.optimize import OptimizeResult, least_squares
from winch_controller_node.node_parameters import WinchControllerParameters

from heave_studies.whatif.record import SensorRecord
from heave_studies.whatif.spectra import BAND, Speeds, Tip, TipSource, Transform, gains_over_top, noise_power
from heave_studies.whatif.twin import Drive, PastWinch, PlantFactors, driven, scaled_line

INERTIA, DAMPING, CABLE_DRAG = "cable.inertia_factor", "cable.damping_factor", "cable.drag_factor"
STIFFNESS, SCALE, DELAY = "cable.stiffness_factor", "mru.scale", "mru.delay"

EARLY, LATE = "start.early", "start.late"

AS_THEY_ARE = (DELAY, EARLY, LATE)
"""Quantities that are 0 where all is as assumed [s], [m]; the others are factors."""

USUAL = {INERTIA: 0.15, DAMPING: 0.6, CABLE_DRAG: 0.3, STIFFNESS: 0.1, SCALE: 0.02, DELAY: 0.04}
"""Standard deviation of each about what is assumed: of the logarithm of a factor [-], of a delay [s]."""


def prior_of(nominal: WinchControllerParameters) -> dict[str, float]:
    """Return the standard deviation of each quantity before the record, for `nominal` parameters of the controller."""
    return {**USUAL, SCALE: max(USUAL[SCALE], nominal.sensors.mru.scale_sigma)}


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
    names: ClassVar[tuple[str, ...]] = tuple(USUAL)  # of the quantities that are searched for

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
        """Power of what is not known of the boom tip (k,) [m2 s]."""
        times, heave = self.record.mru.T
        noise = noise_power(times, heave, self.start, self.end, self.source.plain.sigma)
        return np.asarray(noise / np.abs(self.source.high_pass.response(self.omegas)) ** 2)

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

    def gap(self, values: Values) -> ComplexArray:
        """Return the transforms of the readings less those of what the twin would have read under `values` (m, k)."""
        motion, time = driven(self.drive(values, self.ticks)), self.record.time[self.ticks]
        moved = (motion.unit, values[STIFFNESS] * motion.tension)
        read = [np.interp(times, time, one) for (times, _), one in zip(self.readings, moved, strict=False)]
        return np.asarray(self.seen - [of(one) for of, one in zip(self._transforms, read, strict=True)])

    def chi2(self, values: Values) -> Array:
        """Return the mean square of the gap under `values` to each of the readings over its noise (m,)."""
        held = np.einsum("kii->ik", self.covariance(values, self.noise)).real
        return np.asarray(np.mean(np.abs(self.gap(values)) ** 2 / held, axis=1))

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


STEPS, STEP = {DAMPING: 0.05, CABLE_DRAG: 0.05}, 0.003
"""Steps for the slopes of the twin, and that of all others: of the logarithm of a factor, a delay [s], a length [m]."""

STARTS = (-0.3, -0.2, -0.12, -0.06, 0.0, 0.06, 0.12, 0.2, 0.3)
"""Logarithms of the inertia that are tried first."""

BEST = 3
"""Number of starts that are followed."""

FIRST, ROUNDS, SETTLED = 3, 12, 1e-5
"""Steps from each start, and from the best of them, at most; relative change of the loss that ends them: a step of 0.1
standard deviations."""

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


def point_of(values: Values) -> Array:
    """Return the point at which `values` are: logarithms of factors, the others as they are."""
    return np.array([value if name in AS_THEY_ARE else math.log(value) for name, value in values.items()])


def values_at(x: Array, names: Iterable[str]) -> dict[str, float]:
    """Return the values at a point `x`, by `names`."""
    return {name: float(v) if name in AS_THEY_ARE else math.exp(v) for name, v in zip(names, x, strict=True)}


class Search:
    """Search for the likeliest values under some evidence.

    Parameters
    ----------
    evidence : of the record
    prior : what is known before
    about : point about which the error of the boom tip goes into the readings
    noise : power of what else is in them
    """

    def __init__(self, evidence: Evidence, prior: Values, about: Array, noise: Array) -> None:
        self._evidence = evidence
        self._sigma = np.array([prior[name] for name in evidence.names])
        self._steps = np.diag([STEPS.get(name, STEP) for name in evidence.names])
        covariance = evidence.covariance(values_at(about, evidence.names), noise)
        self._whiten = np.linalg.inv(np.linalg.cholesky(covariance))

    def left(self, x: Array) -> Array:
        """Return what the twin at a point `x` leaves of readings and prior, whitened: half its square is in nats.

        Complex values of variance 1 count as twice as many real ones, by how many of them are independent.
        """
        white = np.einsum("kij,jk->ki", self._whiten, self._evidence.gap(values_at(x, self._evidence.names))).ravel()
        return np.concatenate([math.sqrt(2.0 * INDEPENDENT) * part for part in (white.real, white.imag)]
                              + [x / self._sigma])  # fmt: skip

    def loss(self, x: Array) -> float:
        """Return the loss at a point `x` [nats]."""
        return 0.5 * float(np.sum(self.left(x) ** 2))

    def slopes(self, x: Array) -> Array:
        """Return how `left` changes with each coordinate of a point `x`, by finite steps."""
        here = self.left(x)
        return np.column_stack([(self.left(x + step) - here) / step.sum() for step in self._steps])

    def followed(self, x: Array, rounds: int) -> OptimizeResult:
        """Return the least point near a point `x`, after so many `rounds` at most."""
        return least_squares(self.left, x, self.slopes, x_scale=self._sigma, ftol=SETTLED, max_nfev=rounds)


def fit_cable(evidence: Evidence) -> CableFit:
    """Return the likeliest values under some `evidence`."""
    prior, centre = prior_of(evidence.nominal), np.zeros(len(USUAL))
    search = Search(evidence, prior, centre, evidence.noise)
    # a compensated record shows scale and delay of its MRU first: the resonance is looked for under them too
    held = search.followed(centre, FIRST).x
    starts = [np.where(np.array(list(USUAL)) == INERTIA, one, x) for x in (centre, held) for one in STARTS]
    begun = sorted(starts, key=search.loss)[:BEST]
    return settled(
        evidence, prior, min((search.followed(one, FIRST) for one in begun), key=lambda one: float(one.cost))
    )


def settled(evidence: Evidence, prior: Values, best: OptimizeResult) -> CableFit:
    """Return the likeliest values, by what the twin leaves of the readings taken as their noise.

    Parameters
    ----------
    evidence : of the record
    prior : what is known before
    best : of a search under the noise of the evidence
    """
    noise, names = evidence.noise, evidence.names
    for is_settled in (False, True):
        excess = np.maximum(evidence.chi2(values_at(best.x, names)), 1.0)
        if np.any(excess * evidence.noise > ALIKE * noise) or not is_settled:
            noise = evidence.noise * excess
            best = Search(evidence, prior, best.x, noise).followed(best.x, ROUNDS)
    values = values_at(best.x, names)
    return CableFit(values, np.linalg.inv(best.jac.T @ best.jac), prior, float(evidence.chi2(values)[0]))
