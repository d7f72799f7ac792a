"""Cycles of a load, counted by rainflow, and the one range that would do the same damage."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from heave_node.numerics.arrays import Array

DAMAGE_EXPONENT = 4.0
"""m in `N = a / S^m`, the cycles that a rope lives at a range S: of the design curve of stranded steel wire rope in
tension (DNV-OS-E301 Position mooring, Ch.2 Sec.2, fatigue limit state). ABS's guide for mooring systems has 4.09.
"""

LEAST_RANGE = 0.01
"""Cycles below this share of the mean load are not counted: at m = 4 one as large as the load outweighs 10^8."""


@dataclass(frozen=True)
class LoadCycles:
    """What the cycles of a load come to."""

    per_hour: float  # cycles whose range is at least LEAST_RANGE of the mean load [1/h]
    # range of the load that, once a second (1 Hz), does the damage of all cycles [same unit as the load]
    equivalent_range: float


def rainflow(values: ArrayLike) -> tuple[Array, Array]:
    """Return the cycles of a load, `values` of shape (n,), by rainflow counting, ASTM E1049-85, 5.4.4.

    Returns
    -------
    ranges : from trough to peak, in the order in which they close, shape (m,) [same unit as `values`]
    counts : 1 for a closed cycle, 0.5 for a half one, shape (m,)
    """
    pending: list[float] = []  # reversals whose ranges are not counted yet
    ranges: list[float] = []
    counts: list[float] = []
    for reversal in reversals(values).tolist():
        pending.append(reversal)
        while len(pending) > 2:
            newest, before = abs(pending[-1] - pending[-2]), abs(pending[-2] - pending[-3])
            if newest < before:
                break
            has_start = len(pending) == 3
            ranges.append(before)
            counts.append(0.5 if has_start else 1.0)
            del pending[-3 : -2 if has_start else -1]
    rest = np.abs(np.diff(pending)).tolist()
    return np.array(ranges + rest), np.array(counts + [0.5] * len(rest))


def reversals(values: ArrayLike) -> Array:
    """Return the peaks and troughs of `values`, shape (n,), in their order; first and last value are among them."""
    array = np.asarray(values, dtype=float)
    array = array[np.flatnonzero(np.diff(array, prepend=math.nan) != 0.0)]  # of equal neighbours the first
    turns = np.diff(np.sign(np.diff(array))) != 0.0
    return np.asarray(array[np.concatenate([[True], turns, [True]])] if array.size > 1 else array)


def load_cycles(time: ArrayLike, load: ArrayLike, exponent: float = DAMAGE_EXPONENT) -> LoadCycles:
    """Return what the cycles of a load come to; NaN where the record holds no time.

    Damages are summed as Miner does: n cycles of a range S do the damage `n S^m`, whatever their mean, and the
    equivalent range is `(sum n S^m / T)^(1/m)` over a record of T seconds.

    Parameters
    ----------
    time : of the samples, rising, shape (n,) [s]
    load : at them, shape (n,), never negative
    exponent : m of the S-N curve
    """
    times, values = np.asarray(time, dtype=float), np.asarray(load, dtype=float)
    if values.size < 2 or not times[-1] > times[0]:
        return LoadCycles(math.nan, math.nan)
    duration = float(times[-1] - times[0])
    ranges, counts = rainflow(values)
    counted = counts[ranges >= LEAST_RANGE * values.mean()]
    damage = float(counts @ ranges**exponent)
    return LoadCycles(3600.0 / duration * float(counted.sum()), (damage / duration) ** (1.0 / exponent))
