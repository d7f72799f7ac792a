"""A second-order system driven by a motion that is known with its rate at ticks: exact for a cubic in between."""

from __future__ import annotations

import numpy as np
import scipy


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
        self._state[:] = state
        self._last = (value, rate)

    def step(self, value: float, rate: float, force: float = 0.0) -> tuple[float, float, float]:
        """Advance one period to u = `value`, u' = `rate`, with f = `force` held; return y, y', y''."""
        h = self._period
        u, u1 = self._last
        slope = (value - u) / h
        u2 = (6.0 * slope - 4.0 * u1 - 2.0 * rate) / h
        u3 = (6.0 * u1 + 6.0 * rate - 12.0 * slope) / h**2
        y, y1 = self._transition @ np.array([self._state[0], self._state[1], u, u1, u2, u3, force])
        self._state[:] = y, y1
        self._last = (value, rate)
        drive = self._gains[0] * value + self._gains[1] * rate + force
        return float(y), float(y1), float(drive - self._stiffness * y - self._damping * y1)
