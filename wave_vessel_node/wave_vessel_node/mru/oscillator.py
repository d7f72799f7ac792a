"""A second-order system driven by a motion that is known with its rate at ticks: exact for a cubic in between."""

from __future__ import annotations

import numpy as np
import scipy
from heave_node.numerics.arrays import Array


class DrivenOscillator:
    """y'' + 2 zeta omega y' + omega^2 y = value_gain u + rate_gain u' + f, with u a cubic and f constant within a step.

    Parameters
    ----------
    frequency : omega [rad/s]; damping : zeta
    value_gain, rate_gain : of the motion u and of its rate
    period : length of a step [s]
    """

    def __init__(self, frequency: float, damping: float, *, value_gain: float, rate_gain: float, period: float) -> None:
        self._stiffness, self._damping = frequency**2, 2.0 * damping * frequency
        self._gains = (value_gain, rate_gain)
        self._period = period
        self._state = np.zeros(2)
        self._last = (0.0, 0.0)
        # y, y', and the polynomial u, u', u'', u''' as a chain of integrators, and f
        generator = np.zeros((7, 7))
        generator[0, 1] = 1.0
        generator[1, :4] = -self._stiffness, -self._damping, value_gain, rate_gain
        generator[1, 6] = 1.0
        generator[2, 3] = generator[3, 4] = generator[4, 5] = 1.0
        self._transition = scipy.linalg.expm(generator * period)[:2]

    def start(self, value: float, rate: float, state: tuple[float, float] = (0.0, 0.0)) -> None:
        """Begin at u = `value`, u' = `rate`, with (y, y') = `state`."""
        self._state, self._last = np.array(state), (value, rate)

    def run(self, values: Array, rates: Array, forces: Array) -> Array:
        """Advance by n periods to u = `values`, u' = `rates`, with f = `forces` held; all of shape (n,).

        Returns y, y', y'', u and u' at their ends, shape (n, 5): a row is all that `start` needs to go on from there.
        """
        h = self._period
        u, u1 = np.append(self._last[0], values[:-1]), np.append(self._last[1], rates[:-1])
        slope = (values - u) / h
        u2 = (6.0 * slope - 4.0 * u1 - 2.0 * rates) / h
        u3 = (6.0 * u1 + 6.0 * rates - 12.0 * slope) / h**2
        inputs = np.column_stack((u, u, u, u1, u2, u3, forces))
        out = np.column_stack((u, u, u, values, rates))
        for before, after in zip(inputs, out, strict=True):
            before[:2] = self._state
            self._state = after[:2] = self._transition @ before
        self._last = (float(values[-1]), float(rates[-1]))
        drive = self._gains[0] * values + self._gains[1] * rates + forces
        out[:, 2] = drive - self._stiffness * out[:, 0] - self._damping * out[:, 1]
        return out
