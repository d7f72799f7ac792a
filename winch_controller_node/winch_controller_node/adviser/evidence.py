"""How well a record is explained: the likelihood with the noise profiled out, and its best under corrections."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from heave_node.numerics.arrays import Array
from numpy.typing import NDArray

from winch_controller_node.adviser.columns import TINY

FACTORS = np.concatenate([-np.geomspace(4.0, 0.2, 30), np.geomspace(0.2, 4.0, 90)])
"""Readings over the truth that are tried first: also a sign error [-]."""

ITERATIONS = 8
"""Iterations of the reweighted least squares that refine a correction."""

TIE = 0.5
"""Losses that differ by less are as good: the later of two steps is the more exact [nats]."""

NEAR = (np.linspace(0.9, 1.1, 21), np.linspace(0.992, 1.008, 9))
"""Factors about that of least squares that are tried, and then about the best of them."""


class Fitted(NamedTuple):
    """The best correction."""

    weight: float  # weight of the column [-]
    sigma: float  # standard deviation of the weight [-]
    loss: float  # of the record with it [nats]
    misfits: Array  # mean squared normalised innovation of each judged measurement


@dataclass(frozen=True, eq=False)
class Evidence:
    """The innovations of a pass as quadratic forms in the weights of its columns.

    loss = sum over the judged measurements of N/2 (log(max(q, 1)) + mean log S), q = w' G w: the noise is what is left,
    one independent value a second, so that what a model leaves counts as noise and not as thousands of nats.
    """

    grams: Array  # G of each judged measurement, (k, c, c)
    spreads: Array  # mean log S of each (k,)
    counts: Array  # N of each (k,)

    def loss(self, misfits: Array) -> float:
        """Return the loss [nats] of `misfits`."""
        return float(0.5 * np.sum(self.counts * (np.log(np.maximum(misfits, 1.0)) + self.spreads)))

    def plain(self) -> Fitted:
        """Return the record as it is: the first column alone."""
        misfits = self.grams[:, 0, 0].copy()
        return Fitted(0.0, 0.0, self.loss(misfits), misfits)

    def at(self, column: int, weight: float) -> Fitted:
        """Return the record with a `weight` of a column that is no factor on what is judged."""
        w = np.array([1.0, weight])
        misfits = np.einsum("i,kij,j->k", w, self.grams[:, [0, column]][:, :, [0, column]], w)
        share = self.counts / np.maximum(misfits, 1.0)
        sigma = 1.0 / math.sqrt(max(float(share @ self.grams[:, column, column]), TINY))
        return Fitted(weight, sigma, self.loss(misfits), misfits)

    def fit(self, columns: NDArray[np.int64], starts: Array, factors: Array | None = None) -> list[Fitted]:
        """Return the weight of each of `columns`, alone beside the record as it is, that explains it best.

        Parameters
        ----------
        columns : to be weighed
        starts : weights at which to begin; the best of them is refined by reweighted least squares
        factors : share of each measurement on which a weight w of the column is a factor 1 + w, (k, columns); None: of
            none. What counts is the noise of what was read, that of its product with a factor over the factor: else
            what is divided by ever more would be explained ever better.
        """
        # q = a + 2 b w + c w^2 of each measurement and column
        a, b = self.grams[:, 0, 0, None], self.grams[:, 0, columns]
        c = self.grams[:, columns, columns]
        counts, spreads = self.counts[:, None], self.spreads[:, None]

        def misfits(weights: Array) -> Array:
            weights = weights[..., None, :]
            return np.asarray(a + weights * (2.0 * b + weights * c))

        def loss(weights: Array, least: float = 1.0) -> Array:
            read = misfits(weights)
            if factors is not None:
                read = read * np.maximum(np.abs(1.0 + weights), TINY)[..., None, :] ** (-2.0 * factors)
            return np.asarray(0.5 * np.sum(counts * (np.log(np.maximum(read, least)) + spreads), axis=-2))

        at_starts = loss(np.repeat(starts[:, None], len(columns), axis=1))
        best = starts[np.argmin(at_starts, axis=0)]
        least, weights = np.min(at_starts, axis=0), best
        for _ in range(ITERATIONS):
            share = counts / np.maximum(misfits(weights), 1.0)
            weights = -np.sum(share * b, axis=0) / np.maximum(np.sum(share * c, axis=0), TINY)
            now = loss(weights)
            best, least = np.where(now <= least + TIE, weights, best), np.minimum(now, least)
        if factors is not None:
            # least squares shrink a factor, and what is as good as noise is best where it is least
            for near in NEAR:
                trials = (1.0 + best) * near[:, None] - 1.0
                best = trials[np.argmin(loss(trials, TINY), axis=0), np.arange(len(columns))]
            least = loss(best)
        found = misfits(best)
        sigmas = 1.0 / np.sqrt(np.maximum(np.sum(counts / np.maximum(found, 1.0) * c, axis=0), TINY))
        return [
            Fitted(float(weight), float(sigma), float(value), found[:, i])
            for i, (weight, sigma, value) in enumerate(zip(best, sigmas, least, strict=True))
        ]


def evidence(innovations: Array, variances: Array, which: NDArray[np.int64], count: int, seconds: Array) -> Evidence:
    """Return the evidence of a pass.

    Parameters
    ----------
    innovations : normalised, of the judged readings (m, c); variances : predicted (m,)
    which : judged measurement of each (m,)
    count : judged measurements
    seconds : in which each was taken, a whole number (m,)
    """
    columns = innovations.shape[1]
    grams, spreads, counts = np.zeros((count, columns, columns)), np.zeros(count), np.zeros(count)
    for k in range(count):
        mine = innovations[which == k]
        if len(mine):
            grams[k] = mine.T @ mine / len(mine)
            # a pass that has diverged explains nothing
            known = np.where(variances[which == k] > 0.0, variances[which == k], np.nan)
            spreads[k] = float(np.mean(np.log(known)))
            counts[k] = len(np.unique(seconds[which == k]))
    return Evidence(grams, spreads, counts)
