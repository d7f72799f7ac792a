"""The drum of the model under the set-points it was sent, limits included: what its encoder should have read."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from heave_node.arrays import Array
from heave_node.compiled import inner_kernel, kernel

POSITION_STEP = 0.005
"""Step of the position loop [s]; without one each piece of a tick is exact."""


class Drum(NamedTuple):
    """A speed servo behind a transport delay.

    Attributes
    ----------
    lag : time constant of the servo [s]
    delay : from the start of a tick to the effect of its set-points [s]
    gain : of the position loop [1/s]; 0: none
    speed, acceleration : limits [m/s], [m/s^2]
    """

    lag: float
    delay: float
    gain: float
    speed: float
    acceleration: float


@inner_kernel
def _clip(value: float, largest: float) -> float:
    return min(max(value, -largest), largest)


@inner_kernel
def _servo(u: float, v: float, v_set: float, drum: Drum, h: float) -> tuple[float, float]:
    """Return payout and rate after `h` [s]: constant acceleration while the limit acts, then the linear servo."""
    error = v_set - v
    limited = (abs(error) - drum.acceleration * drum.lag) / drum.acceleration
    if limited > 0.0:
        time = min(limited, h)
        gain = math.copysign(drum.acceleration * time, error)
        u += (v + 0.5 * gain) * time
        v += gain
        h -= time
        error = v_set - v
    change = -error * math.expm1(-h / drum.lag)
    return u + v_set * h - drum.lag * change, v + change


@inner_kernel
def _piece(u: float, v: float, payout: float, rate: float, drum: Drum, h: float) -> tuple[float, float]:
    """Return payout and rate after `h` [s] of constant set-points `payout` and `rate`."""
    if h <= 0.0:
        return u, v
    if drum.gain == 0.0:
        return _servo(u, v, _clip(rate, drum.speed), drum, h)
    steps = math.ceil(h / POSITION_STEP)
    h /= steps
    for _ in range(steps):
        u, v = _servo(u, v, _clip(rate + drum.gain * (payout - u - 0.5 * v * h), drum.speed), drum, h)
    return u, v


@kernel
def drum_record(payouts: Array, rates: Array, count: int, drum: Drum, u: float, v: float, dt: float) -> Array:
    """Return the payout at the end of each of the last `count` ticks, shape (count,) [m].

    Parameters
    ----------
    payouts, rates : set-points of the ticks, oldest first, at least count + delay/dt + 1 of them [m], [m/s]
    count : ticks
    drum : the servo
    u, v : payout and rate at the start of the `count` ticks [m], [m/s]
    dt : tick period [s]
    """
    ticks = drum.delay / dt
    whole = math.floor(ticks)
    part = (ticks - whole) * dt
    out = np.empty(count)
    first = len(rates) - count
    for j in range(count):
        i = first + j - whole
        u, v = _piece(u, v, payouts[i - 1], rates[i - 1], drum, part)
        u, v = _piece(u, v, payouts[i], rates[i], drum, dt - part)
        out[j] = u
    return out
