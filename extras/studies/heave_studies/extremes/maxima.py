"""What distributions of extremes are fitted to: maxima of blocks, and independent peaks over a threshold."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from heave_node.numerics.arrays import Array

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
