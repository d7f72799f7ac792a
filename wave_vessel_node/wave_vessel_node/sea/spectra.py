"""One-sided wave spectra S(omega) [m^2 s/rad] over omega > 0 [rad/s].

Every spectrum obeys `integral of S over omega = significant_wave_height^2 / 16`. Sources: Bretschneider, thesis Eq.
6.20 with omega_m^4 (the print has omega_m^2); Pierson and Moskowitz (1964); Hasselmann et al. (1973) for JONSWAP; Ochi
and Hubble (1976) for two systems.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.constants import STANDARD_GRAVITY
from numpy.typing import ArrayLike

from wave_vessel_node.parameters import SeaParameters

_GAUSS_NODES, _GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(5)
_PIERSON_MOSKOWITZ_ALPHA = 0.0081


class SpectrumError(ValueError):
    """A spectrum that cannot be: the message says what is wrong with it."""


def cell_integrals(function: Callable[[Array], Array], edges: Array) -> Array:
    """Integrate a function over each cell by 5-point Gauss-Legendre quadrature.

    Parameters
    ----------
    function : takes an array of any shape, gives one of that shape
    edges : of the cells, rising, shape (n,)

    Returns
    -------
    integrals : shape (n - 1,)
    """
    half = 0.5 * np.diff(edges)
    points = (edges[:-1] + half)[:, None] + half[:, None] * _GAUSS_NODES
    values: Array = (np.asarray(function(points)) * _GAUSS_WEIGHTS).sum(axis=1) * half
    return values


class WaveSpectrum(ABC):
    """A one-sided spectrum of wave elevation.

    Subclasses give `density` and `peak_frequency`; moments follow by quadrature on `edges`. One that `registries`
    names has a class method `from_parameters(SeaParameters)` too.
    """

    peak_enhancement: float = 1.0
    """gamma of JONSWAP; 1 is Bretschneider's form."""

    @abstractmethod
    def density(self, omega: ArrayLike) -> Array:
        """Return S [m^2 s/rad] at `omega` [rad/s], any shape; 0 where omega <= 0."""

    @property
    @abstractmethod
    def peak_frequency(self) -> float:
        """Frequency of the highest density [rad/s]."""

    @cached_property
    def edges(self) -> Array:
        """Cell edges for quadrature [rad/s]: fine where the density is, out to where its tail no longer counts."""
        peak = self.peak_frequency
        return np.concatenate((np.linspace(0.05, 4.0, 1600) * peak, np.geomspace(4.0, 400.0, 600)[1:] * peak))

    def moment(self, order: int) -> float:
        """Return m_n = integral of omega^n S [m^2 (rad/s)^n] of the `order` n, -1 to 3; raise SpectrumError for others.

        m_4 of an omega^-5 tail is infinite.
        """
        if not -1 <= order <= 3:
            raise SpectrumError(f"moment of order {order} is not available: orders -1 to 3 converge")
        return float(cell_integrals(lambda omega: omega**order * self.density(omega), self.edges).sum())

    @property
    def significant_wave_height(self) -> float:
        """H_m0 = 4 sqrt(m_0) [m]."""
        return 4.0 * math.sqrt(self.moment(0))

    @property
    def peak_period(self) -> float:
        """T_p [s]."""
        return 2.0 * math.pi / self.peak_frequency

    @property
    def zero_crossing_period(self) -> float:
        """T_z = 2 pi sqrt(m_0 / m_2) [s]."""
        return 2.0 * math.pi * math.sqrt(self.moment(0) / self.moment(2))


def _power_law(omega: ArrayLike, peak: float, height: float, shape: float) -> Array:
    """Return the Ochi-Hubble density of one system; shape 1 is Bretschneider's."""
    omega = np.asarray(omega, dtype=float)
    density = np.zeros_like(omega)
    positive = omega > 0.02 * peak  # below, exp(-1.25 (peak / omega)^4) is zero in double precision
    ratio4 = (peak / omega[positive]) ** 4
    steepness = shape + 0.25
    # by logarithms: large shapes overflow otherwise
    log_density = shape * np.log(steepness * ratio4) - math.lgamma(shape) - steepness * ratio4
    density[positive] = 0.25 * height**2 / omega[positive] * np.exp(log_density)
    return density


@dataclass(frozen=True)
class Bretschneider(WaveSpectrum):
    """Bretschneider's two-parameter spectrum, thesis Eq. 6.20 with the exponent of omega_m corrected to 4.

    S = (1.25/4) Hs^2 omega_m^4 / omega^5 exp(-1.25 (omega_m / omega)^4).
    """

    height: float  # significant wave height [m]
    period: float  # peak period [s]

    @classmethod
    def from_parameters(cls, sea: SeaParameters) -> Bretschneider:
        """Return the spectrum of the height and period of `sea`."""
        return cls(sea.significant_wave_height, sea.peak_period)

    def density(self, omega: ArrayLike) -> Array:
        """See WaveSpectrum."""
        return _power_law(omega, self.peak_frequency, self.height, 1.0)

    @property
    def peak_frequency(self) -> float:
        """omega_m [rad/s]."""
        return 2.0 * math.pi / self.period


class PiersonMoskowitz(Bretschneider):
    """The fully developed sea of Pierson and Moskowitz: Bretschneider's form, its height fixes its peak."""

    @classmethod
    def of_height(cls, height: float) -> PiersonMoskowitz:
        """Return the spectrum of a significant wave `height` [m], above 0: omega_p = (16 alpha g^2 / (5 Hs^2))^(1/4).

        Raises SpectrumError for a height of 0 or less.
        """
        if height <= 0.0:
            raise SpectrumError(f"a Pierson-Moskowitz sea needs a significant wave height above 0, got {height:g} m")
        peak = (16.0 * _PIERSON_MOSKOWITZ_ALPHA * STANDARD_GRAVITY**2 / (5.0 * height**2)) ** 0.25
        return cls(height, 2.0 * math.pi / peak)

    @classmethod
    def from_parameters(cls, sea: SeaParameters) -> PiersonMoskowitz:
        """Return the spectrum of the height of `sea`; its period is not used."""
        return cls.of_height(sea.significant_wave_height)


@dataclass(frozen=True)
class Jonswap(WaveSpectrum):
    """JONSWAP: Bretschneider's form times gamma^exp(-(omega/omega_p - 1)^2 / (2 sigma^2)), scaled to the height by
    quadrature.

    sigma is 0.07 below and 0.09 above the peak.
    """

    height: float  # significant wave height [m]
    period: float  # peak period [s]
    peak_enhancement: float = 3.3  # gamma [-]

    @classmethod
    def from_parameters(cls, sea: SeaParameters) -> Jonswap:
        """Return the spectrum of the height, period and peak enhancement of `sea`."""
        return cls(sea.significant_wave_height, sea.peak_period, sea.peak_enhancement)

    def density(self, omega: ArrayLike) -> Array:
        """See WaveSpectrum."""
        return self._scale * self._unscaled(np.asarray(omega, dtype=float))

    @property
    def peak_frequency(self) -> float:
        """omega_p [rad/s]."""
        return 2.0 * math.pi / self.period

    def _unscaled(self, omega: Array) -> Array:
        peak = self.peak_frequency
        width = np.where(omega <= peak, 0.07, 0.09)
        enhancement: Array = self.peak_enhancement ** np.exp(-0.5 * ((omega / peak - 1.0) / width) ** 2)
        return enhancement * _power_law(omega, peak, self.height, 1.0)

    @cached_property
    def _scale(self) -> float:
        if self.height == 0.0:
            return 1.0
        return self.height**2 / 16.0 / float(cell_integrals(self._unscaled, self.edges).sum())


@dataclass(frozen=True)
class OchiHubbleSystem:
    """One of the two systems of an Ochi-Hubble sea."""

    height: float  # significant wave height of this system alone [m]
    period: float  # peak period [s]
    shape: float = 1.0  # lambda [-]; 1 is Bretschneider's


@dataclass(frozen=True)
class OchiHubble(WaveSpectrum):
    """Wind sea and swell together, Ochi and Hubble (1976): the sum of two three-parameter spectra.

    S_j = (1/4) (l omega_p^4)^lambda / Gamma(lambda) Hs^2 / omega^(4 lambda + 1) exp(-l (omega_p/omega)^4) with
    l = (4 lambda + 1)/4.
    """

    wind_sea: OchiHubbleSystem  # the two systems; which is which does not matter
    swell: OchiHubbleSystem  # the two systems; which is which does not matter

    @classmethod
    def from_parameters(cls, sea: SeaParameters) -> OchiHubble:
        """Return the spectrum whose wind sea has height, period and shape of `sea`, and whose swell is its swell."""
        swell = sea.swell
        return cls(
            OchiHubbleSystem(sea.significant_wave_height, sea.peak_period, sea.shape),
            OchiHubbleSystem(swell.significant_wave_height, swell.peak_period, swell.shape),
        )

    def density(self, omega: ArrayLike) -> Array:
        """See WaveSpectrum."""
        parts = [_power_law(omega, 2.0 * math.pi / s.period, s.height, s.shape) for s in (self.wind_sea, self.swell)]
        return parts[0] + parts[1]

    @cached_property
    def peak_frequency(self) -> float:
        """Frequency of the higher of the two peaks [rad/s]."""
        peaks = [2.0 * math.pi / s.period for s in (self.wind_sea, self.swell)]
        grid = np.linspace(0.8 * min(peaks), 1.2 * max(peaks), 4001)
        return float(grid[np.argmax(self.density(grid))])

    @cached_property
    def edges(self) -> Array:
        """See WaveSpectrum: fine from below the lower peak to above the higher."""
        peaks = [2.0 * math.pi / s.period for s in (self.wind_sea, self.swell)]
        low, high = min(peaks), max(peaks)
        return np.concatenate((np.linspace(0.05 * low, 4.0 * high, 3000), np.geomspace(4.0, 400.0, 600)[1:] * high))


@dataclass(frozen=True)
class TabulatedSpectrum(WaveSpectrum):
    """A spectrum given at points, linear between them and zero outside; exact in its moments.

    Raises SpectrumError for anything else.
    """

    frequency: Sequence[float] | Array  # [rad/s], above 0, rising strictly, shape (n,), 3 or more
    values: Sequence[float] | Array  # [m^2 s/rad], not negative, shape (n,)
    name: str = field(default="table")  # opens the message of an error

    def __post_init__(self) -> None:
        frequency = np.array(self.frequency, dtype=float)
        values = np.array(self.values, dtype=float)
        if frequency.ndim != 1 or frequency.shape != values.shape or frequency.size < 3:
            raise SpectrumError(
                f"{self.name}: expected two lists of equal length, 3 or more; "
                f"got shapes {frequency.shape} and {values.shape}"
            )
        if not (np.isfinite(frequency).all() and np.isfinite(values).all()):
            raise SpectrumError(f"{self.name}: frequencies and densities must be finite")
        if frequency[0] <= 0.0 or (np.diff(frequency) <= 0.0).any():
            raise SpectrumError(f"{self.name}: frequencies must be above 0 and strictly increasing")
        if (values < 0.0).any():
            raise SpectrumError(f"{self.name}: density {values.min():g} is negative")
        if not (values > 0.0).any():
            raise SpectrumError(f"{self.name}: no density is above 0")
        object.__setattr__(self, "frequency", frequency)
        object.__setattr__(self, "values", values)

    def density(self, omega: ArrayLike) -> Array:
        """See WaveSpectrum."""
        return np.asarray(
            np.interp(np.asarray(omega, dtype=float), np.asarray(self.frequency), np.asarray(self.values), 0.0, 0.0)
        )

    @property
    def peak_frequency(self) -> float:
        """Frequency of the highest value [rad/s]."""
        return float(np.asarray(self.frequency)[np.argmax(self.values)])

    @cached_property
    def edges(self) -> Array:
        """The table's own frequencies, each cell cut in 16: quadrature is then exact."""
        frequency = np.asarray(self.frequency)
        fractions = np.arange(16) / 16.0
        inner = frequency[:-1, None] + np.diff(frequency)[:, None] * fractions
        return np.append(inner.ravel(), frequency[-1])
