"""Fit of a shaping filter to any spectrum, measured ones included: four zeros at the origin, a bounded leak.

Least squares on the density over poles and free zeros, from several starts that the spectrum itself suggests; the gain
follows linearly. Deterministic: one spectrum gives one filter.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
import scipy
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel, output_sigma, output_spectrum

from wave_vessel_node.sea.shaping_filter import FilterForm, sections_of
from wave_vessel_node.sea.spectra import SpectrumError, WaveSpectrum, cell_integrals

LEAK_QUANTILE = 1e-4
"""The leak of a filter is its energy below the frequency under which the spectrum has this fraction of its own
(Bretschneider: 0.61 omega_m).
"""


@dataclass(frozen=True)
class FilterQuality:
    """How well a filter models a spectrum."""

    relative_error: float  # sqrt(integral (S_filter - S)^2 / integral S^2) [-]
    variance_ratio: float  # m_0 of the filter over that of the spectrum [-]
    # energy of the filter below the spectrum's own band (see `low_band_edge`) over m_0; the spectrum itself has 1e-4
    leak: float


def filter_quality(system: LinearModel, spectrum: WaveSpectrum) -> FilterQuality:
    """Compare the spectrum of a filter with the one that it models.

    Parameters
    ----------
    system : shaping filter with the output wave_elevation
    spectrum : of the sea

    By quadrature; the variance by the Lyapunov equation.
    """
    edges = spectrum.edges

    def density(omega: Array) -> Array:
        return output_spectrum(system, "wave_elevation", omega)

    def squared_error(omega: Array) -> Array:
        return np.asarray((density(omega) - spectrum.density(omega)) ** 2)

    error = cell_integrals(squared_error, edges).sum()
    norm = cell_integrals(lambda omega: spectrum.density(omega) ** 2, edges).sum()
    low = np.linspace(1e-4, 1.0, 600) * low_band_edge(spectrum)
    m0 = spectrum.moment(0)
    return FilterQuality(
        relative_error=math.sqrt(error / norm),
        variance_ratio=output_sigma(system)["wave_elevation"] ** 2 / m0,
        leak=float(cell_integrals(density, low).sum()) / m0,
    )


def low_band_edge(spectrum: WaveSpectrum) -> float:
    """Return the frequency [rad/s] below which the spectrum has 1e-4 of its energy."""
    cumulative = np.cumsum(cell_integrals(spectrum.density, spectrum.edges))
    return float(spectrum.edges[1:][np.searchsorted(cumulative, LEAK_QUANTILE * cumulative[-1])])


_OMEGA = np.concatenate((np.linspace(0.02, 0.35, 20), np.linspace(0.36, 3.0, 400), np.linspace(3.05, 8.0, 60)))
_DECIMALS = 9
_LEAK_WEIGHT = 0.05  # of a leak that is twice its bound, against the relative error
_LOG_BOUND = (math.log(0.15), math.log(8.0))  # of a section's frequency over the peak's
_DAMPING_BOUND = (math.log(0.01), math.log(3.0))
_DAMPING_START = 0.12  # from here as good a fit was found as from 0.3 too, in 200 of 200 random seas of two peaks


@dataclass(frozen=True)
class FilterFit:
    """A fitted filter."""

    form: FilterForm  # normalised to the peak and the energy of the sea
    system: LinearModel  # the filter at the scale of the sea
    spectrum: WaveSpectrum  # that it models

    @cached_property
    def quality(self) -> FilterQuality:
        """How well the filter models the spectrum: by quadrature, which takes as long as some fits."""
        return filter_quality(self.system, self.spectrum)


class _Problem:
    """The residual of a normalised filter against a normalised spectrum, at `_OMEGA`.

    Parameters
    ----------
    target : density over m_0 times the peak frequency
    low : band edge below which no energy should leak, over the peak frequency
    poles, zeros, zeros_at_origin : pairs of poles, pairs of zeros and zeros at the origin of the filter
    leak_bound : see `fit_filter`
    """

    def __init__(
        self, target: Array, low: float, *, poles: int, zeros: int, zeros_at_origin: int, leak_bound: float
    ) -> None:
        self._poles, self._zeros, self._origin = poles, zeros, zeros_at_origin
        self._omega, self._target = _OMEGA, target
        self._weight = np.sqrt(np.gradient(self._omega))
        self._norm = math.sqrt(float((self._weight**2 * self._target**2).sum()))
        self._low = self._omega < low
        self._leak_bound = leak_bound
        self._known: tuple[bytes, tuple[Array, Array]] | None = None

    def form(self, parameters: Array) -> FilterForm:
        """Return the filter of the logarithms of (frequency, damping) of poles, then zeros, with its best gain."""
        values = np.exp(parameters)
        squared_gain = self._best_gain(*self._shape(parameters))[0]
        sections, numerator = values[: 2 * self._poles], values[2 * self._poles :]
        return FilterForm(math.sqrt(squared_gain), self._origin, sections_of(sections), sections_of(numerator))

    def _shape(self, parameters: Array) -> tuple[Array, Array]:
        """Return what `_shape_of` does, once: residual and Jacobian are asked for at the same parameters in turn."""
        key = parameters.tobytes()
        if self._known is None or self._known[0] != key:
            self._known = key, self._shape_of(parameters)
        return self._known[1]

    def _shape_of(self, parameters: Array) -> tuple[Array, Array]:
        """Return the density at gain 1 and its derivatives to the parameters, shapes (n,) and (n, parameters).

        A section has |.|^2 = q = (w^2 - omega^2)^2 + (2 zeta w omega)^2; derivatives to log w and log zeta.
        """
        w, zeta = np.exp(parameters[::2])[:, None], np.exp(parameters[1::2])[:, None]
        omega2 = self._omega[None, :] ** 2
        detuning = w**2 - omega2
        viscous = 4.0 * zeta**2 * w**2 * omega2
        q = detuning**2 + viscous
        sign = np.where(np.arange(w.size) < self._poles, -1.0, 1.0)[:, None]
        shape = self._omega ** (2 * self._origin) * np.prod(q**sign, axis=0)
        relative = np.empty((parameters.size, self._omega.size))
        relative[::2] = sign * (4.0 * w**2 * detuning + 2.0 * viscous) / q
        relative[1::2] = sign * 2.0 * viscous / q
        return shape, (relative * shape).T

    def _best_gain(self, shape: Array, slopes: Array) -> tuple[float, Array]:
        """Return the squared gain of the least squared error, and its derivatives."""
        weighted = self._weight**2
        over, under = weighted * self._target, weighted * shape
        top, bottom = max(float(over @ shape), 1e-300), float(under @ shape)
        return top / bottom, (over @ slopes - 2.0 * top / bottom * (under @ slopes)) / bottom

    def residual(self, parameters: Array) -> Array:
        """Return the weighted misfit of the density, and what leaks beyond the bound."""
        shape, slopes = self._shape(parameters)
        density = self._best_gain(shape, slopes)[0] * shape
        misfit = self._weight * (density - self._target) / self._norm
        return np.append(misfit, _LEAK_WEIGHT * max(0.0, self._leak(density) / self._leak_bound - 1.0))

    def jacobian(self, parameters: Array) -> Array:
        """Return the derivatives of the residual, shape (n + 1, parameters)."""
        shape, slopes = self._shape(parameters)
        gain, gain_slopes = self._best_gain(shape, slopes)
        slopes = gain * slopes + np.outer(shape, gain_slopes)
        leaks = self._leak(gain * shape) > self._leak_bound
        last = _LEAK_WEIGHT / self._leak_bound * self._leak(slopes) if leaks else np.zeros(parameters.size)
        return np.vstack((self._weight[:, None] * slopes / self._norm, last))

    def _leak(self, density: Array) -> Any:
        return self._weight[self._low] ** 2 @ density[self._low]

    def starts(self) -> list[Array]:
        """Return starts: poles spread around the peak, and poles on the local maxima of the spectrum."""
        centre = np.linspace(-1.0, 1.0, self._poles)
        peaks = self._local_maxima()
        poles = [
            np.exp(0.35 * centre),
            np.exp(0.2 + 0.5 * centre),
            1.0 + 0.1 * centre,
            np.resize(peaks, self._poles) * np.exp(0.1 * centre),
        ]
        starts = []
        for frequencies in poles:
            sections = np.column_stack((frequencies, np.full(self._poles, _DAMPING_START))).ravel()
            zeros = np.column_stack((np.linspace(2.0, 4.0, self._zeros), np.full(self._zeros, 0.7))).ravel()
            starts.append(np.log(np.concatenate((sections, zeros))))
        return starts

    def _local_maxima(self) -> Array:
        inner = self._target[1:-1]
        is_peak = (inner >= self._target[:-2]) & (inner > self._target[2:]) & (inner > 0.1 * self._target.max())
        order = np.argsort(-inner[is_peak])
        found: Array = self._omega[1:-1][is_peak][order]
        return found if found.size else np.ones(1)

    def bounds(self) -> tuple[Array, Array]:
        pairs = self._poles + self._zeros
        low, high = zip(_LOG_BOUND, _DAMPING_BOUND, strict=True)
        return np.tile(low, pairs), np.tile(high, pairs)


def fit_filter(
    spectrum: WaveSpectrum, states: int = 6, *, zeros_at_origin: int | None = None, leak_bound: float = 2e-3
) -> FilterFit:
    """Fit a shaping filter to a spectrum.

    Parameters
    ----------
    spectrum : of the sea, with energy
    states : of the filter; even, 4 or more
    zeros_at_origin : default 4 (2 with four states, which have no room for more)
    leak_bound : fraction of m_0 under which the filter's energy below the spectrum's own band is pressed (see
        FilterQuality.leak)

    Raises SpectrumError for a number of states that cannot be, or a spectrum without energy.
    """
    if states < 4 or states % 2:
        raise SpectrumError(f"a fitted filter has an even number of states, 4 or more; got {states}")
    if spectrum.moment(0) <= 0.0:
        raise SpectrumError("a shaping filter needs a spectrum with energy: its significant wave height is 0")
    if zeros_at_origin is None:
        zeros_at_origin = 4 if states >= 6 else 2
    poles = states // 2
    zeros = max(0, (states - 2 - zeros_at_origin) // 2)
    peak = spectrum.peak_frequency
    # rounded: seas of one shape, whatever their height and period, are one to the cache
    target = np.round(spectrum.density(_OMEGA * peak) * peak / spectrum.moment(0), _DECIMALS)
    low = round(low_band_edge(spectrum) / peak, _DECIMALS)
    form = _best_form(target.tobytes(), low, poles, zeros, zeros_at_origin, leak_bound)
    system = form.model(peak, spectrum.significant_wave_height)
    return FilterFit(form, system, spectrum)


@lru_cache(maxsize=256)
def _best_form(
    target: bytes, low: float, poles: int, zeros: int, zeros_at_origin: int, leak_bound: float
) -> FilterForm:
    """Return the filter that fits best of all that the starts lead to; `target` as bytes, the rest as of `_Problem`."""
    problem = _Problem(
        np.frombuffer(target), low, poles=poles, zeros=zeros, zeros_at_origin=zeros_at_origin, leak_bound=leak_bound
    )
    lowest, highest = problem.bounds()
    best, best_cost = None, math.inf
    for guess in problem.starts():
        start = np.clip(guess, lowest + 1e-6, highest - 1e-6)
        result = scipy.optimize.least_squares(
            problem.residual, start, jac=problem.jacobian, bounds=(lowest, highest), max_nfev=300
        )
        if result.cost < best_cost:
            best, best_cost = result.x, result.cost
    assert best is not None
    return problem.form(best)


def fitted_filter(spectrum: WaveSpectrum, states: int) -> LinearModel:
    """Return the filter that `fit_filter` finds for `spectrum` with this number of `states`."""
    return fit_filter(spectrum, states).system
