"""Cable, unit and MRU by the whole record at once: a likelihood in the frequency domain, its maximum and its spread.

Heave and rate of the MRU and the depth of the unit are three readings of one unknown motion, the boom tip's:
y = h x + noise at each frequency, so that y is Gaussian with the covariance S h h* + N (Whittle, The analysis of
multiple stationary time series, 1953). Its log-determinant keeps what least squares on a compensated record get wrong,
where the boom tip that is read has more error than the unit has motion. What the winch paid out is known and taken off.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from heave_node.numerics.arrays import Array, ComplexArray
from scipy.optimize import minimize
from winch_controller_node.adviser.judge import HIGH_PASS, HIGH_PASSES, PRICES
from winch_controller_node.beliefs.corrections import Correction
from winch_controller_node.node_parameters import WinchControllerParameters

from heave_bringup.whatif.signals.record import SensorRecord
from heave_bringup.whatif.signals.spectra import Speeds, noise_power, tapered_transform, unit_over_top
from heave_bringup.whatif.signals.tip import HighPass, smooth_spectrum
from heave_bringup.whatif.twin.plant import PlantFactors, nominal_line, scaled_line
from heave_bringup.whatif.twin.winch import PastWinch

INERTIA, DAMPING, SCALE, DELAY = "cable.inertia_factor", "cable.damping_factor", "mru.scale", "mru.delay"

PRIOR = {INERTIA: 0.15, DAMPING: 0.8, SCALE: 0.02, DELAY: 0.04}
"""Standard deviation of each about what is assumed: of the logarithm of a factor or a scale [-], of a delay [s]."""

BAND = (0.25, 4.0)
"""Angular frequencies that are judged [rad/s]."""

BEGINS = 30.0
"""Time after the start of a record from which it is judged [s]: plant and sea may begin at rest."""

INDEPENDENT = 0.6
"""Independent values a frequency under a Hann taper."""

TELLS = 0.5
"""A quantity whose standard deviation is less than so much of its prior is identified by the record."""


@dataclass(frozen=True)
class CableFit:
    """What the record says of cable, unit and MRU.

    Attributes
    ----------
    values : by name in PRIOR, about what is assumed: factors and scale [-], delay [s]
    covariance : of the logarithms of factors and scale, and of the delay, in that order
    prior : its standard deviations
    mru : scale, mean and delay of the MRU, with what was assumed of it
    high_pass_period : of the MRU [s]; 0: none
    nats : by how much better the record is explained than by what is assumed
    chi2 : mean square of what is left of the depth readings over their noise [-]
    """

    values: Mapping[str, float]
    covariance: Array = field(repr=False)
    prior: Mapping[str, float]
    mru: Correction
    high_pass_period: float
    nats: float
    chi2: float

    def sigma(self, name: str) -> float:
        """Standard deviation of the value `name`: relative for a factor or a scale, in seconds for a delay."""
        place = list(self.values).index(name)
        return math.sqrt(float(self.covariance[place, place]))

    def tells(self, name: str) -> bool:
        """Return whether the record says more of the value `name` than was known before."""
        return self.sigma(name) < TELLS * self.prior[name]


class CableLikelihood:
    """Loss of a record under values of cable, unit and MRU.

    Parameters
    ----------
    record : with MRU and depth sensor
    nominal : parameters of the controller
    winch : what the drum did
    mru : assumed of the MRU
    depth_scale : reading over truth [-]
    prior : standard deviation of each value, by name
    centre : value that each is likely to have, in the terms of `values_at`
    """

    def __init__(
        self,
        record: SensorRecord,
        nominal: WinchControllerParameters,
        winch: PastWinch,
        mru: Correction,
        depth_scale: float,
        prior: Mapping[str, float] = PRIOR,
        centre: Mapping[str, float] | None = None,
    ) -> None:
        self.nominal, self.mru, self.prior = nominal, mru, prior
        self._centre = np.array([(centre or {}).get(name, 0.0) for name in prior])
        start, end = float(record.time[0]) + BEGINS, float(record.time[-1])
        step = 2.0 * math.pi / (end - start)
        self.omegas = np.arange(BAND[0], BAND[1], step)
        times, heave, rate = record.mru.T
        times = times - mru.delay
        self._line = line = nominal_line(nominal)
        longer = 1.0 + line.static_strain(nominal.length)
        outlet = record.time, longer * winch.payout
        depth_times, depth = record.scalar("depth").T
        hung = np.interp(depth_times, *outlet) - depth / depth_scale
        sensors = nominal.sensors
        stated = (sensors.mru.noise, sensors.mru.rate_noise, sensors.depth.noise)
        readings = [(times, (heave - mru.offset) / mru.scale), (times, rate / mru.scale), (depth_times, hung)]
        if not np.isfinite(rate).all():
            readings[1] = (times, np.zeros_like(times))
        self._has_rate = bool(np.isfinite(rate).all())
        self._seen = np.array([tapered_transform(*one, self.omegas, start, end) for one in readings])
        self._noise = np.array([noise_power(*one, start, end, own) for one, own in zip(readings, stated, strict=True)])
        self._payout = tapered_transform(*outlet, self.omegas, start, end)
        self.inflation = 1.0
        self._speeds = self._linearised_at()

    def _linearised_at(self) -> Speeds:
        """Return the speeds by which drag is linearised: of the unit as read less its noise, and of the outlet."""
        step = self.omegas[1] - self.omegas[0]
        unit = self._seen[2] - self._payout
        power = np.maximum(smooth_spectrum(np.abs(unit) ** 2, self.omegas) - self._noise[2], 0.0)
        top = np.maximum(smooth_spectrum(np.abs(self._seen[0] - self._payout) ** 2, self.omegas) - self._noise[0], 0.0)
        # one-sided density over omega: twice the power over 2 pi
        return Speeds(*(math.sqrt(float(np.sum(self.omegas**2 * one)) * step / math.pi) for one in (power, top)))

    def values_at(self, x: Array) -> dict[str, float]:
        """Return the values at a point `x`: logarithms of the factors and the scale, and the delay."""
        return {name: (float(v) if name == DELAY else math.exp(v)) for name, v in zip(self.prior, x, strict=True)}

    def _channels(self, x: Array, high_pass: HighPass) -> tuple[ComplexArray, ComplexArray]:
        """Return what was read without the share of the payout (3, k), and h (3, k)."""
        values = self.values_at(x)
        line = scaled_line(self._line, PlantFactors(values[INERTIA], values[DAMPING]))
        H = unit_over_top(line, self.nominal.length, self.omegas, self._speeds)
        mru = values[SCALE] * high_pass.response(self.omegas) * np.exp(-1j * self.omegas * values[DELAY])
        seen = self._seen.copy()
        seen[2] += (H - 1.0) * self._payout
        rate = 1j * self.omegas * mru if self._has_rate else np.zeros_like(mru)
        return seen, np.array([mru, rate, H])

    def loss(self, x: Array, high_pass: HighPass) -> float:
        """Return the loss at a point x, with a `high_pass` of the MRU [nats]."""
        seen, h = self._channels(x, high_pass)
        noise = self._noise * np.array([1.0, 1.0, self.inflation])
        weight = np.sum(np.abs(h) ** 2 / noise[:, None], axis=0)
        guess = np.sum(np.conj(h) * seen / noise[:, None], axis=0)
        spectrum = np.maximum(smooth_spectrum(np.abs(guess / weight) ** 2, self.omegas) - 1.0 / weight, 1e-12)
        square = np.sum(np.abs(seen) ** 2 / noise[:, None], axis=0) - np.abs(guess) ** 2 / (weight + 1.0 / spectrum)
        determinant = np.log1p(spectrum * weight)
        off = (x - self._centre) / np.array([*self.prior.values()])
        return float(INDEPENDENT * np.sum(determinant + square) + 0.5 * off @ off)

    def chi2(self, x: Array, high_pass: HighPass) -> float:
        """Return the mean square of what the MRU leaves of the depth over its noise, at `x` with a `high_pass`."""
        seen, h = self._channels(x, high_pass)
        by_mru = self._noise[:2]
        weight = np.sum(np.abs(h[:2]) ** 2 / by_mru[:, None], axis=0)
        guess = np.sum(np.conj(h[:2]) * seen[:2] / by_mru[:, None], axis=0) / weight
        left = np.abs(seen[2] - h[2] * guess) ** 2
        return float(np.mean(left / (self._noise[2] + np.abs(h[2]) ** 2 / weight)))


def fit_cable(likelihood: CableLikelihood, high_pass: HighPass) -> CableFit:
    """Return the values at which the `likelihood` of the record and the prior together are largest.

    `high_pass` is assumed of the MRU; another is taken where it is worth its price.
    """
    start = likelihood._centre.copy()
    least = {high_pass.period: _least(likelihood, start, high_pass)}
    for period in HIGH_PASSES:
        if period != high_pass.period:
            least[period] = _least(likelihood, start, high_pass._replace(period=period))
    price = {period: PRICES[HIGH_PASS] * (period != high_pass.period) for period in least}
    period = min(least, key=lambda one: least[one][1] + price[one])
    kept = high_pass._replace(period=period)
    x = least[period][0]
    chi2 = likelihood.chi2(x, kept)
    # what the model leaves counts as noise, not as evidence
    likelihood.inflation = max(chi2, 1.0)
    nominal = likelihood.loss(start, high_pass)
    x, found = _least(likelihood, x, kept)
    values = likelihood.values_at(x)
    mru = likelihood.mru
    held = Correction(mru.scale * values[SCALE], mru.offset, mru.delay + values[DELAY])
    return CableFit(
        values, _covariance(likelihood, x, kept), likelihood.prior, held, kept.period, nominal - found, chi2
    )


def _least(likelihood: CableLikelihood, start: Array, high_pass: HighPass) -> tuple[Array, float]:
    """Return the point of the least loss from several starts, and that loss [nats]."""
    steps = np.array([*likelihood.prior.values()])
    begun = [start, *(start + steps * np.array([x, y, 0.0, 0.0]) for x in (-1.0, 1.0) for y in (0.0, 1.0))]
    first = min(begun, key=lambda one: likelihood.loss(one, high_pass))
    simplex = np.vstack([first, first + 0.3 * np.diag(steps)])
    found = minimize(
        likelihood.loss,
        first,
        args=(high_pass,),
        method="Nelder-Mead",
        options={"initial_simplex": simplex, "xatol": 1e-4, "fatol": 1e-3, "maxfev": 600},
    )
    return np.asarray(found.x), float(found.fun)


def _covariance(likelihood: CableLikelihood, x: Array, high_pass: HighPass) -> Array:
    """Return the inverse of the curvature of the loss about its least point, no wider than the prior."""
    prior = np.array([*likelihood.prior.values()])
    steps = 0.05 * prior
    count = len(x)

    def at(moves: Sequence[float]) -> float:
        return likelihood.loss(x + np.asarray(moves) * steps, high_pass)

    unit, here = np.eye(count), likelihood.loss(x, high_pass)
    curvature = np.empty((count, count))
    for i in range(count):
        curvature[i, i] = at(unit[i]) + at(-unit[i]) - 2.0 * here
        for j in range(i):
            both = at(unit[i] + unit[j]) + at(-unit[i] - unit[j]) - at(unit[i] - unit[j]) - at(unit[j] - unit[i])
            curvature[i, j] = curvature[j, i] = 0.25 * both
    known = np.diag(prior**-2)
    told = curvature / np.outer(steps, steps) - known
    values, vectors = np.linalg.eigh(told)
    told = vectors @ np.diag(np.maximum(values, 0.0)) @ vectors.T
    return np.asarray(np.linalg.inv(told + known))
