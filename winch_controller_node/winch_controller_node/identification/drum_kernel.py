"""The believed drum under the set-points it was sent, limits included: what its encoder should have read. Compiled."""

from __future__ import annotations

import math

import numpy as np
from heave_node.arrays import Array
from numba import njit

POSITION_STEP = 0.005
"""Step of the position loop [s]; without one each piece of a tick is exact."""


@njit(cache=True)
def _clip(value: float, largest: float) -> float:
    return min(max(value, -largest), largest)


@njit(cache=True)
def _servo(u: float, v: float, v_set: float, lag: float, acceleration: float, h: float) -> tuple[float, float]:
    """Return payout and rate after `h` [s]: constant acceleration while the limit acts, then the linear servo."""
    error = v_set - v
    limited = (abs(error) - acceleration * lag) / acceleration
    if limited > 0.0:
        time = min(limited, h)
        gain = math.copysign(acceleration * time, error)
        u += (v + 0.5 * gain) * time
        v += gain
        h -= time
        error = v_set - v
    change = -error * math.expm1(-h / lag)
    return u + v_set * h - lag * change, v + change


@njit(cache=True)
def _piece(
    u: float, v: float, payout: float, rate: float, lag: float, gain: float, speed: float, acceleration: float, h: float
) -> tuple[float, float]:
    """Advance by `h` [s] under constant set-points; `gain` is that of the position loop [1/s]."""
    if h <= 0.0:
        return u, v
    if gain == 0.0:
        return _servo(u, v, _clip(rate, speed), lag, acceleration, h)
    steps = math.ceil(h / POSITION_STEP)
    h /= steps
    for _ in range(steps):
        u, v = _servo(u, v, _clip(rate + gain * (payout - u - 0.5 * v * h), speed), lag, acceleration, h)
    return u, v


@njit(cache=True)
def drum_record(
    payouts: Array,
    rates: Array,
    count: int,
    lag: float,
    delay: float,
    u: float,
    v: float,
    gain: float,
    speed: float,
    acceleration: float,
    dt: float,
) -> Array:
    """Return the payout at the end of each of the last `count` ticks, shape (count,) [m].

    Parameters
    ----------
    payouts, rates : set-points of the ticks, oldest first, at least count + delay/dt + 1 of them [m], [m/s]
    lag, delay : time constant of the servo and time from the start of a tick to the effect of its set-points [s]
    u, v : payout and rate at the start of the `count` ticks [m], [m/s]
    gain : of the position loop [1/s]; speed, acceleration : limits [m/s], [m/s^2]; dt : tick period [s]
    """
    ticks = delay / dt
    whole = math.floor(ticks)
    part = (ticks - whole) * dt
    out = np.empty(count)
    first = len(rates) - count
    for j in range(count):
        i = first + j - whole
        u, v = _piece(u, v, payouts[i - 1], rates[i - 1], lag, gain, speed, acceleration, part)
        u, v = _piece(u, v, payouts[i], rates[i], lag, gain, speed, acceleration, dt - part)
        out[j] = u
    return out
