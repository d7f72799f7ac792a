"""Statistics of a record of elevation against its target: moments, Hs, Tz and Tp with 95 % intervals.

Of a Gaussian record of length T the variance of the n-th spectral moment is (2 pi / T) integral of omega^{2n} S^2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.spectral_estimate import estimate_spectrum
from wave_vessel_node.sea.spectra import WaveSpectrum, cell_integrals

_NORMAL_95 = 1.959964


@dataclass(frozen=True)
class Estimate:
    """A value from a record, what it should be, and the half width of the 95 % interval about the target."""

    value: float
    target: float
    half_width: float

    @property
    def is_inside(self) -> bool:
        """Return whether the value lies within the interval."""
        return abs(self.value - self.target) <= self.half_width


@dataclass(frozen=True)
class RecordStatistics:
    """A record against its spectrum."""

    m0: Estimate  # spectral moments [m^2]
    m2: Estimate  # spectral moments [m^2 (rad/s)^2]
    significant_wave_height: Estimate  # 4 sqrt(m0) [m]
    zero_crossing_period: Estimate  # 2 pi sqrt(m0 / m2) [s]
    peak_period: Estimate  # from the Welch spectrum [s]


def record_statistics(
    record: Array, period: float, spectrum: WaveSpectrum, *, segment: float = 200.0
) -> RecordStatistics:
    """Compare a record of elevation with the spectrum it should have.

    Parameters
    ----------
    record : elevation [m], shape (n,)
    period : between samples [s]
    spectrum : target
    segment : length of a segment of Welch's spectrum, for the peak period [s]

    Frequencies above pi / (4 period) count for the second moment with less than they have: rates are central
    differences, and the target is taken through the same difference.
    """
    length = record.size * period
    elevation = record - record.mean()
    rate = (elevation[2:] - elevation[:-2]) / (2.0 * period)
    edges = spectrum.edges

    def seen(omega: Array) -> Array:
        """Return the gain of the central difference."""
        return np.asarray(np.sin(omega * period) / period)

    def scatter(weight: int) -> float:
        squared = cell_integrals(lambda omega: seen(omega) ** (2 * weight) * spectrum.density(omega) ** 2, edges)
        return math.sqrt(2.0 * math.pi / length * float(squared.sum()))

    moments = (
        Estimate(float(elevation.var()), spectrum.moment(0), _NORMAL_95 * scatter(0)),
        Estimate(
            float(rate.var()),
            float(cell_integrals(lambda omega: seen(omega) ** 2 * spectrum.density(omega), edges).sum()),
            _NORMAL_95 * scatter(2),
        ),
    )
    m0, m2 = moments
    cross = cell_integrals(lambda omega: seen(omega) ** 2 * spectrum.density(omega) ** 2, edges)
    covariance = 2.0 * math.pi / length * float(cross.sum())
    height = 4.0 * math.sqrt(m0.target)
    # to first order: d(Hs) = Hs dm0 / (2 m0); d(Tz) = Tz (dm0 / m0 - dm2 / m2) / 2
    relative = (scatter(0) / m0.target) ** 2 + (scatter(2) / m2.target) ** 2
    relative -= 2.0 * covariance / (m0.target * m2.target)
    crossing = 2.0 * math.pi * math.sqrt(m0.target / m2.target)
    estimate = estimate_spectrum(elevation, period, segment=segment)
    peak = 2.0 * math.pi / float(estimate.omega[np.argmax(estimate.density)])
    freedom = degrees_of_freedom(len(estimate.segments))
    return RecordStatistics(
        m0,
        m2,
        Estimate(4.0 * math.sqrt(m0.value), height, height * m0.half_width / (2.0 * m0.target)),
        Estimate(
            2.0 * math.pi * math.sqrt(m0.value / m2.value),
            crossing,
            0.5 * _NORMAL_95 * crossing * math.sqrt(max(relative, 0.0)),
        ),
        Estimate(peak, spectrum.peak_period, _peak_half_width(spectrum, freedom, segment)),
    )


def degrees_of_freedom(segments: int) -> float:
    """Return those of a density by half-overlapping Hann `segments`, k: 36 k^2 / (19 k - 1) (Welch 1967)."""
    return 36.0 * segments**2 / (19.0 * segments - 1.0)


def _peak_half_width(spectrum: WaveSpectrum, freedom: float, segment: float) -> float:
    """Return how far the highest line may lie from the peak: where S is within two chi-square deviations of its top."""
    peak = spectrum.peak_frequency
    grid = np.linspace(0.3, 3.0, 4001) * peak
    near = grid[spectrum.density(grid) > (1.0 - 2.0 * math.sqrt(2.0 * 2.0 / freedom)) * spectrum.density(peak)]
    resolution = 2.0 * math.pi / segment
    periods = 2.0 * math.pi / np.array([near[0] - resolution, near[-1] + resolution])
    return float(np.abs(periods - spectrum.peak_period).max())
