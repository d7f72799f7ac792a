"""Spectra estimated from records of motion, and the height and period that they give, with 95 % intervals.

Welch's method: periodograms of half-overlapping Hann segments, each about its mean. Spectra are
one-sided over angular frequency [rad/s], so that their integral is the variance.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy

from heave_node.numerics.arrays import Array

SEGMENT_TIME = 200.0
"""Usual length of a segment [s]: a resolution of 0.03 rad/s, a tenth of a swell's frequency."""

_BOOTSTRAP_DRAWS = 200
_PEAK_BAND = 0.4  # of log frequency about the peak, in which its top is fitted
_NORMAL_95 = 1.959964


class RecordTooShortError(ValueError):
    """A record without enough samples for an estimate; the message says how long it is and what is needed."""


@dataclass(frozen=True)
class SpectralEstimate:
    """The spectrum of a record."""

    omega: Array  # [rad/s], shape (f,), evenly spaced from 0
    segments: Array  # periodograms [unit^2 s/rad] of the segments, shape (k, f)
    record_length: float  # time that the segments cover [s]

    @property
    def density(self) -> Array:
        """Mean of the periodograms [unit^2 s/rad], shape (f,)."""
        return np.asarray(self.segments.mean(axis=0))


def segment_size(segment: float, period: float) -> int:
    """Return the samples of a segment of about `segment` [s], an even number of at least 2, `period` [s] apart."""
    return 2 * max(1, round(0.5 * segment / period))


def segment_frequencies(size: int, period: float) -> Array:
    """Return the frequencies of the periodogram of `size` samples, `period` [s] apart [rad/s], (size // 2 + 1,)."""
    return np.asarray(2.0 * math.pi * np.fft.rfftfreq(size, period), dtype=np.float64)


def segment_periodogram(samples: Array, period: float) -> Array:
    """Return the one-sided densities [unit^2 s/rad] of segments, shape (..., size) -> (..., size // 2 + 1).

    Parameters
    ----------
    samples : of one or more segments of an even size, the last axis is time
    period : between samples [s]
    """
    window = np.hanning(samples.shape[-1] + 1)[:-1]
    lines = np.fft.rfft(window * (samples - samples.mean(axis=-1, keepdims=True)))
    density = np.square(np.abs(lines)) * (period / (2.0 * math.pi * np.square(window).sum()))
    # all but the first and the last line stand for a negative frequency too
    density[..., 1:-1] *= 2.0
    return np.asarray(density)


def estimate_spectrum(
    record: Array, period: float, *, segment: float = SEGMENT_TIME, least_segments: int = 2
) -> SpectralEstimate:
    """Return the spectrum of an evenly sampled record.

    Parameters
    ----------
    record : samples, shape (n,)
    period : between samples [s]
    segment : length of a segment [s]
    least_segments : segments, half overlapping, that the record must hold

    Raises RecordTooShortError for a shorter record.
    """
    size = segment_size(segment, period)
    half = size // 2
    needed = half * (least_segments + 1)
    if size < 4 or record.size < needed:
        raise RecordTooShortError(
            f"a record of {record.size * period:g} s is too short for {least_segments} half-overlapping segments of "
            f"{segment:g} s: {needed * period:g} s are needed"
        )
    segments = np.lib.stride_tricks.sliding_window_view(record, size)[::half]
    length = half * (len(segments) + 1) * period
    return SpectralEstimate(segment_frequencies(size, period), segment_periodogram(segments, period), length)


def height_interval(omega: Array, density: Array, m0: float, record_length: float) -> tuple[float, float]:
    """Return the 95 % interval of the significant wave height 4 sqrt(m0) of a Gaussian record [m].

    The variance of m0 is (2 pi / T) integral S^2, so that m0 has 2 m0^2 over it degrees of freedom of a chi-square.

    Parameters
    ----------
    omega : evenly spaced [rad/s]
    density : S at them [m^2 s/rad]
    m0 : variance [m^2]; may hold more than the integral of S, a tail beyond the last frequency
    record_length : T [s]
    """
    squared = float((density**2).sum() * (omega[1] - omega[0]))
    freedom = max(1.0, m0**2 * record_length / (math.pi * squared)) if squared > 0.0 else 1.0
    height = 4.0 * math.sqrt(m0)
    low, high = (height * math.sqrt(freedom / scipy.special.chdtri(freedom, q)) for q in (0.025, 0.975))  # upper tails
    return low, high


def peak_frequency(omega: Array, density: Array) -> Array:
    """Return the frequency of the peak of noisy spectra [rad/s], shape (k, f) -> (k,); NaN without energy.

    The mean frequency weighted with S^4 finds the peak. About it log S = a - b x - c e^{-4x}, x = log omega, is fitted
    by least squares weighted with S^2, and the maximum of the fit is the peak: the form is exact for Bretschneider's
    spectrum and Ochi and Hubble's, within half a percent for JONSWAP's.

    Parameters
    ----------
    omega : [rad/s], above 0, shape (f,)
    density : spectra, shape (k, f)
    """
    weight = density**4
    total = weight.sum(axis=1)
    with np.errstate(invalid="ignore"):
        centre = (weight * omega).sum(axis=1) / np.where(total > 0.0, total, np.nan)
    x = np.nan_to_num(np.log(omega / centre[:, None]))
    highest = density.max(axis=1, keepdims=True)
    used = (np.abs(x) < _PEAK_BAND) & (density > 1e-3 * highest)
    weight = np.where(used, (density / np.where(highest > 0.0, highest, 1.0)) ** 2, 0.0)
    log_density = np.log(np.where(used, density, 1.0))
    near = np.clip(x, -_PEAK_BAND, _PEAK_BAND)
    columns = np.stack((np.ones_like(near), -near, -np.exp(-4.0 * near)), axis=2)
    normal = np.einsum("sf,sfi,sfj->sij", weight, columns, columns) + 1e-9 * np.eye(3)
    right = np.einsum("sf,sfi,sf->si", weight, columns, log_density)
    _, b, c = np.linalg.solve(normal, right[:, :, None])[:, :, 0].T
    has_maximum = (b > 0.0) & (c > 0.0)
    top = 0.25 * np.log(np.where(has_maximum, 4.0 * c, 1.0) / np.where(has_maximum, b, 1.0))
    return np.asarray(centre * np.exp(np.clip(top, -_PEAK_BAND, _PEAK_BAND)))


def resampled_spectra(segments: Array) -> Array:
    """Return spectra of records drawn from the segments with replacement, shape (k, f) -> (draws, f): the
    bootstrap's picture of how the estimate scatters.
    """
    generator = np.random.default_rng(0)  # fixed: an interval depends on the record alone
    count = len(segments)
    shares = generator.multinomial(count, np.full(count, 1.0 / count), size=_BOOTSTRAP_DRAWS)
    return np.asarray(shares @ segments / count)


def peak_period_interval(omega: Array, density: Array, drawn: Array, count: int) -> tuple[float, float]:
    """Return the 95 % interval of the peak period [s].

    Percentiles of the bootstrap, widened from the normal distribution to Student's, since the segments are few. Of
    Gaussian seas of half an hour in segments of 200 s, 87 to 98 % of the intervals hold the period.

    Parameters
    ----------
    omega : [rad/s], above 0, shape (f,)
    density : the estimate, shape (f,)
    drawn : spectra of the bootstrap, shape (draws, f)
    count : segments on which the estimate is based, 2 or more
    """
    period = 2.0 * math.pi / float(peak_frequency(omega, density[None])[0])
    low, high = np.percentile(2.0 * math.pi / peak_frequency(omega, drawn), [2.5, 97.5])
    wider = float(scipy.special.stdtrit(count - 1, 0.975)) / _NORMAL_95 * math.sqrt(count / (count - 1))
    return period + wider * (float(low) - period), period + wider * (float(high) - period)


@dataclass(frozen=True)
class HeightAndPeriod:
    """Height and period of a record of motion, with 95 % intervals."""

    # 4 standard deviations [m]: significant wave height of an elevation, double amplitude of a heave
    significant_height: float
    significant_height_interval: tuple[float, float]  # lower and upper end [m]
    peak_period: float  # of the highest density [s]
    peak_period_interval: tuple[float, float]  # lower and upper end [s]


def height_and_period(record: Array, period: float) -> HeightAndPeriod:
    """Return height and period of an evenly sampled record of elevation or heave [m].

    Parameters
    ----------
    record : samples [m], shape (n,)
    period : between samples [s]

    Raises RecordTooShortError where the record holds fewer than three half-overlapping segments.
    """
    estimate = estimate_spectrum(record, period, least_segments=3)
    omega, segments = estimate.omega[1:], estimate.segments[:, 1:]
    density = segments.mean(axis=0)
    m0 = float(record.var())
    return HeightAndPeriod(
        significant_height=4.0 * math.sqrt(m0),
        significant_height_interval=height_interval(omega, density, m0, record.size * period),
        peak_period=float(2.0 * math.pi / peak_frequency(omega, density[None])[0]),
        peak_period_interval=peak_period_interval(omega, density, resampled_spectra(segments), len(segments)),
    )
