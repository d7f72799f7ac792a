"""The distribution of the largest value in some time, from maxima of shorter times, with its confidence.

Maxima of blocks follow a generalised extreme-value distribution, peaks over a high threshold a generalised Pareto one,
and either gives the largest value of any time (Coles, An Introduction to Statistical Modeling of Extreme Values, 2001,
chapters 3 and 4). They are fitted by L-moments, which serve small samples better than likelihood does (Hosking, Journal
of the Royal Statistical Society B 52, 1990, table 2; peaks: Hosking and Wallis, Technometrics 29, 1987). A small sample
says nothing of the shape: it is then taken as 0, which is the limit of Rayleigh and all other waves without an upper
end (Gumbel and exponential).

Fitted are the squares of deviations from the mean: crests of a narrow-banded Gaussian motion are Rayleigh, so their
squares are exponential and the fit is exact, where that of the crests themselves converges slowly (Cook, Journal of
Wind Engineering and Industrial Aerodynamics 9, 1982, for wind speeds).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.randomness import random_stream

CYCLES_PER_BLOCK = 6.0
"""Mean cycles that a block holds at least: its maximum is one of several waves."""
LARGEST_NUMBER_OF_BLOCKS = 60
"""A record is cut into so many blocks at most: longer blocks are closer to the limit distribution."""
PEAK_SHARE = 0.15
"""Share of the cycles whose peaks are over the threshold."""


@dataclass(frozen=True)
class Peaks:
    """Peaks over a threshold, one for each group of cycles above it."""

    excess: Array  # over the threshold, shape (n,)
    threshold: float  # in the unit of the record
    duration: float  # of the record [s]


def cycle_maxima(values: Array) -> Array:
    """Return the largest value of each cycle of a record about its mean, a cycle from one up-crossing to the next.

    Parameters
    ----------
    values : evenly sampled, shape (n,); the maxima come less its mean
    """
    about_mean = values - values.mean() if values.size else values
    ups = np.flatnonzero((about_mean[:-1] <= 0.0) & (about_mean[1:] > 0.0)) + 1
    if ups.size < 2:
        return np.empty(0)
    return np.asarray(np.maximum.reduceat(about_mean[: ups[-1]], ups[:-1]))


def block_maxima(values: Array, cycles: int) -> Array:
    """Return the largest deviation from the mean in blocks of equal length.

    Parameters
    ----------
    values : evenly sampled, shape (n,)
    cycles : that the record holds
    """
    count = min(int(cycles / CYCLES_PER_BLOCK), LARGEST_NUMBER_OF_BLOCKS)
    if count < 1:
        return np.empty(0)
    length = values.size // count
    about_mean = values - values.mean()
    return np.asarray(about_mean[: count * length].reshape(count, length).max(axis=1))


def peaks_over_threshold(maxima: Array, duration: float) -> Peaks:
    """Return the peaks among the `maxima` of cycles that lie over the threshold of PEAK_SHARE.

    Of cycles in a row above the threshold only the highest counts: waves come in groups, and a fit takes its sample as
    independent (runs declustering; Coles, An Introduction to Statistical Modeling of Extreme Values, section 5.3.2).

    Parameters
    ----------
    maxima : of cycles in their order, shape (n,)
    duration : of the record [s]
    """
    if not maxima.size:
        return Peaks(np.empty(0), np.nan, duration)
    threshold = float(np.quantile(maxima, 1.0 - PEAK_SHARE))
    is_above = np.concatenate(([False], maxima > threshold, [False]))
    starts = np.flatnonzero(~is_above[:-1] & is_above[1:])
    ends = np.flatnonzero(is_above[:-1] & ~is_above[1:])
    excess = [float(maxima[start:end].max()) - threshold for start, end in zip(starts, ends, strict=True)]
    return Peaks(np.asarray(excess), threshold, duration)


SHAPE_SAMPLE = 500
"""Values from which on the shape is fitted too."""
LARGEST_SHAPE = 0.4
"""Shapes beyond this, of either sign, are a freak of the sample."""
FEWEST = 3
"""Fewest values from which a largest one is estimated."""
SMALL_SAMPLE = 20
"""A fit to fewer values is to be taken with caution."""
LARGEST_EXTENSION = 20.0
"""Time that is extrapolated to, over that of all records, beyond which caution is due."""
CONFIDENCE = 0.9
"""Two-sided, of the intervals."""
RESAMPLES = 200
SEED, STREAM = 1, "extremes/bootstrap"
"""Of the random numbers of the confidence intervals."""
FLAT = 1e-9
"""Shapes below this are 0."""


@dataclass(frozen=True)
class Largest:
    """Generalised extreme-value distribution of the largest value in a time."""

    location: float  # in the unit of the value
    scale: float  # in the unit of the value
    shape: float  # xi [-]; above 0 a heavy tail, below 0 an upper end
    duration: float  # the time [s]

    def within(self, duration: float) -> Largest:
        """Return the distribution of the largest value within another `duration` [s]; it is of the same kind."""
        times = duration / self.duration
        if abs(self.shape) < FLAT:
            return Largest(self.location + self.scale * math.log(times), self.scale, 0.0, duration)
        grown = times**self.shape
        location = self.location + self.scale * (grown - 1.0) / self.shape
        return Largest(location, self.scale * grown, self.shape, duration)

    @property
    def most_probable(self) -> float:
        """The mode."""
        if abs(self.shape) < FLAT:
            return self.location
        return self.location + self.scale * (math.pow(1.0 + self.shape, -self.shape) - 1.0) / self.shape

    def percentile(self, share: float) -> float:
        """Return the value that the largest one stays below with a probability of `share`."""
        reduced = -math.log(share)
        if abs(self.shape) < FLAT:
            return self.location - self.scale * math.log(reduced)
        return self.location + self.scale * (math.pow(reduced, -self.shape) - 1.0) / self.shape


@dataclass(frozen=True)
class Estimate:
    """What is to be expected of the largest deviation from the mean."""

    method: str  # how it was found
    sample: int  # number of values that it was fitted to
    most_probable: float  # root of the most probable square, sigma sqrt(2 ln n) of n Rayleigh crests, SI
    most_probable_range: tuple[float, float]  # confidence interval of `most_probable`
    p90: float  # 90th percentile [SI]
    p90_range: tuple[float, float]  # confidence interval of `p90`
    warnings: tuple[str, ...] = ()  # why to take it with caution


def l_moments(values: Array) -> tuple[float, float, float]:
    """Return mean, L-scale and L-skewness (0 where all values are equal) of a sample, unbiased.

    Parameters
    ----------
    values : shape (n,), two at least; of two the skewness is 0
    """
    rising, count = np.sort(values), values.size
    rank = np.arange(count)
    first = float(rising.mean())
    second = float(np.mean(rising * rank)) / (count - 1)
    scale = 2.0 * second - first
    if scale <= 0.0 or count < 3:
        return first, max(scale, 0.0), 0.0
    third = float(np.mean(rising * rank * (rank - 1))) / ((count - 1) * (count - 2))
    return first, scale, (6.0 * third - 6.0 * second + first) / scale


def fit_blocks(maxima: Array, block: float) -> Largest:
    """Return the distribution of the largest value in a block.

    Parameters
    ----------
    maxima : of blocks, shape (n,), two at least
    block : length of a block [s]
    """
    mean, l_scale, skewness = l_moments(maxima)
    if maxima.size < SHAPE_SAMPLE or l_scale == 0.0:
        scale = l_scale / math.log(2.0)
        return Largest(mean - float(np.euler_gamma) * scale, scale, 0.0, block)
    c = 2.0 / (3.0 + skewness) - math.log(2.0) / math.log(3.0)
    k = min(max(7.8590 * c + 2.9554 * c**2, -LARGEST_SHAPE), LARGEST_SHAPE)
    if abs(k) < FLAT:
        k = FLAT
    gamma = math.gamma(1.0 + k)
    scale = l_scale * k / ((1.0 - 2.0**-k) * gamma)
    return Largest(mean - scale * (1.0 - gamma) / k, scale, -k, block)


def fit_peaks(peaks: Peaks) -> Largest:
    """Return the distribution of the largest value within the time of the record.

    Peaks come as a Poisson process: the largest of a time stays below x with exp(-(number of peaks above x)).

    Parameters
    ----------
    peaks : over a threshold, two at least
    """
    mean, l_scale, _ = l_moments(peaks.excess)
    k = mean / l_scale - 2.0 if peaks.excess.size >= SHAPE_SAMPLE and l_scale > 0.0 else 0.0
    k = min(max(k, -LARGEST_SHAPE), LARGEST_SHAPE)
    per_peak = Largest(peaks.threshold, (1.0 + k) * mean, -k, peaks.duration / peaks.excess.size)
    return per_peak.within(peaks.duration)


def from_blocks(maxima: Array, block: float, duration: float) -> Estimate | None:
    """Return what is to be expected of the largest value within a time, by maxima of blocks; None for too few.

    Parameters
    ----------
    maxima : of blocks, or of records of one length: deviations from the mean, not negative, shape (n,)
    block : length of each [s]
    duration : the time [s]
    """
    if maxima.size < FEWEST:
        return None

    squares = np.square(maxima)

    def again(generator: np.random.Generator) -> Largest:
        return fit_blocks(generator.choice(squares, squares.size), block)

    best = fit_blocks(squares, block)
    return _estimate("block maxima", best, maxima.size, maxima.size * block, duration, again)


def most_probable_by_blocks(maxima: Array, block: float, duration: float) -> float:
    """Return the most probable largest value alone; arguments as for `from_blocks`, three maxima at least.

    Parameters
    ----------
    maxima, block, duration : see there
    """
    return _figures(fit_blocks(np.square(maxima), block).within(duration))[0]


def from_peaks(peaks: Peaks, duration: float) -> Estimate | None:
    """Return what is to be expected of the largest value within a time, by peaks; None for too few.

    Parameters
    ----------
    peaks : over a threshold: deviations from the mean
    duration : the time [s]
    """
    count = peaks.excess.size
    if count < FEWEST:
        return None
    threshold = peaks.threshold**2
    excess = np.square(peaks.threshold + peaks.excess) - threshold

    def again(generator: np.random.Generator) -> Largest:
        drawn = generator.choice(excess, max(int(generator.poisson(count)), 2))
        return fit_peaks(Peaks(drawn, threshold, peaks.duration))

    best = fit_peaks(Peaks(excess, threshold, peaks.duration))
    return _estimate("peaks over threshold", best, count, peaks.duration, duration, again)


def _estimate(
    method: str,
    best: Largest,
    sample: int,
    recorded: float,
    duration: float,
    again: Callable[[np.random.Generator], Largest],
) -> Estimate:
    generator = random_stream(SEED, STREAM)
    drawn = np.array([_figures(again(generator).within(duration)) for _ in range(RESAMPLES)])
    low, high = np.quantile(drawn, (0.5 - 0.5 * CONFIDENCE, 0.5 + 0.5 * CONFIDENCE), axis=0)
    most_probable, p90 = _figures(best.within(duration))
    return Estimate(
        method,
        sample,
        most_probable,
        (float(low[0]), float(high[0])),
        p90,
        (float(low[1]), float(high[1])),
        tuple(_warnings(sample, recorded, duration)),
    )


def _figures(squares: Largest) -> tuple[float, float]:
    """Return the most probable largest value and its 90th percentile, by the distribution of its square."""
    return math.sqrt(max(squares.most_probable, 0.0)), math.sqrt(max(squares.percentile(0.9), 0.0))


def _warnings(sample: int, recorded: float, duration: float) -> list[str]:
    words = []
    if sample < SMALL_SAMPLE:
        words.append(f"only {sample} values: the interval is too narrow; {SMALL_SAMPLE} and more make a fit")
    if duration > LARGEST_EXTENSION * recorded:
        words.append(f"{duration / 3600.0:g} h from {recorded / 60.0:.3g} min of records: run longer, or more seeds")
    return words
