"""The drum of the model under the set-points it was sent, limits included: what its encoder should have read."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inner_kernel, kernel

POSITION_STEP = 0.005
"""Step of the position loop [s]; without one each piece of a tick is exact."""

START_STEPS = 3
"""Gauss-Newton steps to payout and rate at the start of a record."""

RATE_STEP = 1e-3
"""Step of the sensitivity to the rate at the start [m/s]."""

EDGE = 1e-9
"""Part of a tick that counts as none."""

NO_POWER_LIMIT = 1e9
"""Power that no winch has [W]."""

WEAK_SLOPE = 1e-6
"""Effect of the rate at the start on the payout that counts as none, as at the limit of the speed [s]."""


class Drum(NamedTuple):
    """A speed servo behind a transport delay.

    Attributes
    ----------
    lag : time constant of the servo [s]
    delay : from the start of a tick to the effect of its set-points [s]
    gain : speed that it settles at over its set-point, paying out [-]
    deadband : of the set-point only what is beyond it counts [m/s]
    speed_out, speed_in : limits of paying out and hauling in [m/s]
    acceleration_out, acceleration_in : limits towards paying out and hauling in [m/s^2]
    backlash : play of the encoder's gear [m]
    reach : largest set-point that has an effect, over the limit of the speed [-]
    hauling : gain of hauling in, over that of paying out [-]
    creep : speed at a set-point of 0 [m/s]
    power : it turns no faster than this over the tension [W]
    """

    lag: float
    delay: float
    gain: float = 1.0
    deadband: float = 0.0
    speed_out: float = math.inf
    speed_in: float = math.inf
    acceleration_out: float = 1e9
    acceleration_in: float = 1e9
    backlash: float = 0.0
    reach: float = 1.0
    hauling: float = 1.0
    creep: float = 0.0
    power: float = NO_POWER_LIMIT


@inner_kernel
def _left_of_error(drum: Drum, position_gain: float, h: float) -> float:
    """Return what the servo makes of an error in a step of a piece of `h` [s], less 1 [-]."""
    return math.expm1(-h / drum.lag if position_gain == 0.0 else -h / _steps(h) / drum.lag)


@inner_kernel
def _steps(h: float) -> int:
    """Return the steps of the position loop within a piece of `h` [s]."""
    return max(math.ceil(h / POSITION_STEP), 1)


@inner_kernel
def _servo(u: float, v: float, v_set: float, drum: Drum, h: float, left: float) -> tuple[float, float]:
    """Return payout and rate after `h` [s]: constant acceleration while the limit acts, then the linear servo.

    `left` is what that makes of an error over all of `h`, see `_left_of_error`.
    """
    if drum.reach > 1.0:
        v = min(max(v, -drum.speed_in), drum.speed_out)
    error = v_set - v
    acceleration = drum.acceleration_out if error > 0.0 else drum.acceleration_in
    limited = (abs(error) - acceleration * drum.lag) / acceleration
    if limited > 0.0:
        time = min(limited, h)
        gain = math.copysign(acceleration * time, error)
        u += (v + 0.5 * gain) * time
        v += gain
        h -= time
        error = v_set - v
        left = math.expm1(-h / drum.lag)
    change = -error * left
    return u + v_set * h - drum.lag * change, v + change


@inner_kernel
def _set_point(demand: float, drum: Drum) -> float:
    """Return the speed that the servo goes for."""
    gain = drum.gain if demand >= 0.0 else drum.gain * drum.hauling
    wanted = gain * math.copysign(max(abs(demand) - drum.deadband, 0.0), demand) + drum.creep
    return min(max(wanted, -drum.reach * drum.speed_in), drum.reach * drum.speed_out)


@inner_kernel
def _under(drum: Drum, tension: float) -> Drum:
    """Return the drum under a `tension` [N], the limit of its power being one of its speed there."""
    if drum.power >= NO_POWER_LIMIT or not tension > 0.0:
        return drum
    fastest = drum.power / tension
    return Drum(
        drum.lag,
        drum.delay,
        drum.gain,
        drum.deadband,
        min(drum.speed_out, fastest),
        min(drum.speed_in, fastest),
        drum.acceleration_out,
        drum.acceleration_in,
        drum.backlash,
        drum.reach,
        drum.hauling,
        drum.creep,
        drum.power,
    )


@inner_kernel
def _piece(
    u: float, v: float, payout: float, rate: float, drum: Drum, position_gain: float, h: float, left: float
) -> tuple[float, float]:
    """Return payout and rate after `h` [s] of constant set-points `payout` and `rate`; `left` as in `_servo`."""
    if h <= 0.0:
        return u, v
    if position_gain == 0.0:
        return _servo(u, v, _set_point(rate, drum), drum, h, left)
    steps = _steps(h)
    h /= steps
    for _ in range(steps):
        u, v = _servo(u, v, _set_point(rate + position_gain * (payout - u - 0.5 * v * h), drum), drum, h, left)
    return u, v


@kernel
def drum_records(
    payouts: Array,
    rates: Array,
    late: Array,
    tensions: Array,
    drums: Array,
    starts: Array,
    position_gain: float,
    count: int,
    dt: float,
) -> Array:
    """Return the encoder's reading of each drum at the end of each of the last `count` ticks, shape (m, count) [m].

    Parameters
    ----------
    payouts, rates : set-points of the ticks, oldest first, at least count + delay/dt + 1 of them [m], [m/s]
    late : by how much later than the delay each of them took effect (ticks), same shape
    tensions : at the top at the end of each tick, same shape [N]; NaN where unknown: there the power limits nothing
    drums : fields of `Drum`, shape (m, 13)
    starts : payout and rate at the start of the `count` ticks, shape (m, 2) [m], [m/s]
    position_gain : of the servo's position loop [1/s]; 0: none
    count : ticks
    dt : tick period [s]
    """
    out = np.empty((len(drums), count))
    first = len(rates) - count
    for m in range(len(drums)):
        p = drums[m]
        drum = Drum(p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7], p[8], p[9], p[10], p[11], p[12])
        delay = drum.delay / dt
        u, v = starts[m, 0], starts[m, 1]
        play = 0.5 * drum.backlash
        reading = u - math.copysign(play, v)
        # the newest set-point in effect: that of tick k acts from k + delay on
        k = min(max(first - math.floor(delay) - 2, 0), len(rates) - 1)
        length, left = -1.0, 0.0
        for j in range(count):
            now, end = float(first + j), float(first + j + 1)
            under = _under(drum, tensions[max(first + j - 1, 0)])
            while now < end:
                until = end
                if k + 1 < len(rates):
                    takes = k + 1 + delay + late[k + 1]
                    if takes <= now + EDGE:
                        k += 1
                        continue
                    until = min(takes, end)
                h = (until - now) * dt
                if h != length:
                    length, left = h, _left_of_error(drum, position_gain, h)
                u, v = _piece(u, v, payouts[k], rates[k], under, position_gain, h, left)
                now = until
            reading = min(max(reading, u - play), u + play)
            out[m, j] = reading
    return out


@kernel
def predicted_reading(
    payouts: Array,
    rates: Array,
    tensions: Array,
    readings: Array,
    drum: Array,
    position_gain: float,
    fitted: int,
    dt: float,
) -> float:
    """Return what the encoder should read at the end of the last tick [m].

    Payout and rate at the start are those that explain the first `fitted` of the `readings` best.

    Parameters
    ----------
    payouts, rates : set-points of the ticks, oldest first, more of them than readings by the delay [m], [m/s]
    tensions : at the top at the end of each of these ticks [N]; NaN: unknown
    readings : at the start of the record and at the end of each of its ticks [m], shape (count + 1,)
    drum : fields of `Drum`, shape (13,)
    position_gain : of the servo's position loop [1/s]; 0: none
    fitted : readings
    dt : tick period [s]
    """
    count = len(readings) - 1
    end = len(rates) - count + fitted
    drums, starts, late = np.empty((2, len(drum))), np.empty((2, 2)), np.zeros(len(rates))
    drums[0], drums[1] = drum, drum
    starts[0, 0], starts[0, 1] = readings[0], (readings[1] - readings[0]) / dt
    for _ in range(START_STEPS):
        starts[1, 0], starts[1, 1] = starts[0, 0], starts[0, 1] + RATE_STEP
        simulated = drum_records(
            payouts[:end], rates[:end], late[:end], tensions[:end], drums, starts, position_gain, fitted, dt
        )
        left = readings[1 : fitted + 1] - simulated[0]
        slopes = (simulated[1] - simulated[0]) / RATE_STEP
        about = slopes - slopes.mean()
        spread = about @ about
        rate = about @ left / spread if spread > fitted * WEAK_SLOPE**2 else 0.0
        starts[0, 0] += left.mean() - rate * slopes.mean()
        starts[0, 1] += rate
    path = drum_records(payouts, rates, late, tensions, drums[:1], starts[:1], position_gain, count, dt)
    return float(path[0, -1])
