"""A sensor's record compared with what is expected of it: low-passed alike, and fitted by least squares."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.newest import Newest

from winch_controller_node.model.nominal_load import UNREAD

LOW_PASS = 0.25
"""Time constant of the low-pass of both sides of a comparison [s]."""

CERTAIN, ALIKE = 5.0, 0.6
"""Slope over its standard error, and correlation, that a proof needs: a sound MRU was called reversed in no window."""

SCALE = (0.6, 1.4)
"""Slopes that prove an MRU: neither reversed nor twice. A load cell on a short cable says no more than that."""

REFUTED = 3.0
"""Standard errors by which a slope lies outside of that where it says something against the MRU."""


class Fit(NamedTuple):
    """One signal on another.

    Attributes
    ----------
    scale : slope of the least squares
    correlation : of what is left of both without offset, trend and free swing
    certainty : slope over its standard error, which allows for the correlation in time of the residual
    """

    scale: float
    correlation: float
    certainty: float

    @property
    def is_sure(self) -> bool:
        """Tell whether its sign is certain."""
        return abs(self.certainty) > CERTAIN and abs(self.correlation) > ALIKE

    @property
    def proves(self) -> bool:
        """Tell whether both signals are the same motion."""
        return self.is_sure and SCALE[0] < self.scale < SCALE[1]

    @property
    def refutes(self) -> bool:
        """Tell whether they are not, and not by chance: the slope is outside, and so is all that it may be."""
        error = REFUTED * abs(self.scale / self.certainty) if self.certainty else math.inf
        return self.is_sure and (self.scale + error < SCALE[0] or self.scale - error > SCALE[1])


NO_FIT = Fit(0.0, 0.0, 0.0)
"""Of signals that do not move."""


def fitted(y: Array, x: Array, step: float, frequency: float) -> Fit:
    """Return the fit of `y` on `x`, both of shape (n,), beside an offset, a trend and a swing of a `frequency` [rad/s].

    The standard error is that of n (1 - r)/(1 + r) independent samples, r the residual's correlation from one sample
    to the next (Bayley and Hammersley 1946, for a first-order process).

    Parameters
    ----------
    y, x : samples every `step` [s]
    step : [s]
    frequency : of the free swing; 0: none is taken out
    """
    t = step * np.arange(len(x))
    beside = [np.ones_like(t), t - t.mean()]
    if frequency > 0.0:
        beside += [np.cos(frequency * t), np.sin(frequency * t)]
    q, _ = np.linalg.qr(np.stack(beside, axis=1))
    smallest_x, smallest_y = (1e-12 * float(np.linalg.norm(one)) for one in (x, y))  # rounding is no motion
    x, y = x - q @ (q.T @ x), y - q @ (q.T @ y)
    x_size, y_size = float(np.linalg.norm(x)), float(np.linalg.norm(y))
    if x_size <= smallest_x or y_size <= smallest_y:
        return NO_FIT
    x, y = x / x_size, y / y_size
    correlation = float(x @ y)
    rest = y - correlation * x
    squares = float(rest @ rest)
    scale = correlation * y_size / x_size
    if squares <= 1e-18:
        return Fit(scale, math.copysign(1.0, correlation), math.copysign(math.inf, correlation))
    memory = max(float(rest[1:] @ rest[:-1]) / squares, 0.0)
    independent = len(x) * (1.0 - memory) / (1.0 + memory)
    return Fit(scale, correlation, correlation / math.sqrt(squares / max(independent, 1.0)))


class Series:
    """The newest samples of a signal at any times, low-passed.

    Parameters
    ----------
    length : samples that are kept
    """

    def __init__(self, length: int) -> None:
        self._times, self._values = Newest(length), Newest(length)

    @property
    def times(self) -> Array:
        """Their times [s], ascending, shape (n,)."""
        return self._times.last()

    @property
    def values(self) -> Array:
        """The low-passed samples, shape (n,)."""
        return self._values.last()

    def clear(self) -> None:
        """Restart."""
        self._times.clear()
        self._values.clear()

    def add(self, time: float, value: float) -> bool:
        """Take in a sample of a `time` [s] and `value`; return whether it counts: a number, later than the last one."""
        since = time - self.times[-1] if len(self._times) else math.inf
        if not (math.isfinite(time + value) and since > 0.0):
            return False
        before = self.values[-1] if len(self._times) else value
        self._times.append(time)
        self._values.append(value + math.exp(-since / LOW_PASS) * (before - value))
        return True

    def at(self, times: Array) -> Array | None:
        """Return the samples at `times` (n,) [s], interpolated; None: they do not reach over them."""
        known = self.times
        if len(known) < 2 or known[0] > times[0] + UNREAD or known[-1] < times[-1] - UNREAD:
            return None
        return np.interp(times, known, self.values)
