"""Motion of the winch drum between events: the drive's law inside its limits, as one compiled loop."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from heave_node.interface.codes import WinchLimit
from heave_node.numerics.arrays import Array
from numba import njit

from cable_sim_node.winch.parameters import WinchDriftParameters, WinchParameters

FOLLOW_SPEED = 0
"""Speed servo: v' = (v_set - v)/T with v_set = rate_setpoint + k_p (payout_setpoint - u)."""
FOLLOW_POSITION = 1
"""First-order law of thesis Eq. 6.1: u' = K (u_0 - u)."""
STOP = 2
"""Constant deceleration to rest."""
HOLD = 3
"""Standstill with the brake engaged."""

LIMIT_SPEED, LIMIT_ACCELERATION = int(WinchLimit.SPEED), int(WinchLimit.ACCELERATION)
LIMIT_PAYOUT, LIMIT_POWER = int(WinchLimit.PAYOUT), int(WinchLimit.POWER)

LONGEST_SUBSTEP = 0.001
"""Inner step [s]. Both laws are solved exactly within it where no limit acts and k_p = 0."""


@njit(cache=True)
def _clip(value: float, largest: float) -> float:
    return min(max(value, -largest), largest)


@njit(cache=True)
def _limited(value: float, largest_up: float, largest_down: float) -> float:
    return min(max(value, -largest_down), largest_up)


@njit(cache=True)
def _beyond_deadband(value: float, deadband: float) -> float:
    """Return what a valve with a dead zone passes on: nothing within it, what is beyond it otherwise."""
    return math.copysign(max(abs(value) - deadband, 0.0), value)


@njit(cache=True)
def _stop_substep(u: float, v: float, deceleration: float, h: float) -> tuple[float, float]:
    """Return payout and rate after `h` seconds of constant deceleration that ends at rest."""
    time_to_rest = abs(v) / deceleration
    if time_to_rest <= h:
        return u + 0.5 * v * time_to_rest, 0.0
    next_v = v - math.copysign(deceleration * h, v)
    return u + 0.5 * (v + next_v) * h, next_v


@njit(cache=True)
def _servo_substep(
    u: float, v: float, v_set: float, time_constant: float, decay: float, acceleration_limit: float, h: float
) -> tuple[float, float, bool]:
    """Return payout and rate of the servo after `h` s, whose `decay` is e^(-h/T), and whether its limit acted."""
    change = (v_set - v) * (1.0 - decay)
    if abs(v_set - v) <= acceleration_limit * time_constant:
        return u + v_set * h - time_constant * change, v + change, False
    change = _clip(change, acceleration_limit * h)
    return u + (v + 0.5 * change) * h, v + change, True


@njit(cache=True)
def _position_substep(
    u: float, v: float, target: float, rate: float, speed_limit: float, acceleration_limit: float, h: float
) -> tuple[float, float, int]:
    """Return payout and rate of the first-order law after `h` seconds, and the limits that acted."""
    decay = math.exp(-rate * h)
    demand = rate * (target - u) * decay
    next_v = _clip(demand, speed_limit)
    limits = LIMIT_SPEED if next_v != demand else 0
    change = _clip(next_v - v, acceleration_limit * h)
    if change != next_v - v:
        limits |= LIMIT_ACCELERATION
    if limits == 0 and abs(rate * (target - u)) <= speed_limit:
        return target + (u - target) * decay, next_v, 0
    return u + (v + 0.5 * change) * h, v + change, limits


@njit(cache=True)
def _stay_in_range(
    u: float, v: float, next_u: float, next_v: float, u_min: float, u_max: float, deceleration: float, h: float
) -> tuple[float, float, bool]:
    """Return the step (next_u, next_v), or the fastest one from which the drum still stops inside the range.

    The invariant is u + v abs(v) / (2 d) in [u_min, u_max]: a stop with deceleration d ends inside. A step at
    constant acceleration to rate w keeps it when u + (v + w) h / 2 + w^2 / (2 d) <= u_max, a quadratic in w; it has
    a solution because w = v - d h always keeps it.
    """
    reach = next_u + next_v * abs(next_v) / (2.0 * deceleration)
    if u_min <= reach <= u_max and u_min <= next_u <= u_max:
        return next_u, next_v, False
    sign = 1.0 if reach > u_max or next_u > u_max else -1.0
    room = (u_max - u) if sign > 0.0 else (u - u_min)
    speed = sign * v
    root = 0.25 * h * h - 2.0 * (0.5 * speed * h - room) / deceleration
    if root < 0.25 * h * h:
        stopped_u, stopped_v = _stop_substep(u, v, deceleration, h)
        return stopped_u, stopped_v, True
    fastest = deceleration * (math.sqrt(root) - 0.5 * h)
    bounded_v = sign * min(max(fastest, speed - deceleration * h), max(sign * next_v, speed - deceleration * h))
    return u + 0.5 * (v + bounded_v) * h, bounded_v, True


class DriveSettings(NamedTuple):
    """What holds for a drive at all times."""

    speed_limit: float  # [m/s]
    acceleration_limit: float  # [m/s^2]
    stop_deceleration: float  # [m/s^2]
    time_constant: float  # T [s]
    position_gain: float  # k_p [1/s]
    position_rate: float  # K [1/s]
    u_min: float  # least payout [m]
    u_max: float  # largest payout [m]
    speed_gain: float  # of the servo: rate over set-point [-]
    deadband: float  # of the servo: it does nothing for a smaller set-point [m/s]
    hauling_speed_share: float  # speed limit of hauling in over that of paying out [-]
    hauling_acceleration_share: float  # acceleration limit of hauling in over that of paying out [-]
    creep: float  # speed at a set-point of 0 [m/s]


def settings_of(parameters: WinchParameters) -> DriveSettings:
    """Return the settings that the `parameters` of a winch describe."""
    p = parameters
    return DriveSettings(
        speed_limit=p.speed_limit,
        acceleration_limit=p.acceleration_limit,
        stop_deceleration=p.deceleration,
        time_constant=p.time_constant,
        position_gain=p.position_gain,
        position_rate=p.position_rate,
        u_min=p.payout_minimum,
        u_max=p.payout_maximum,
        speed_gain=p.speed_gain,
        deadband=p.speed_deadband,
        hauling_speed_share=p.hauling_speed_share,
        hauling_acceleration_share=p.hauling_acceleration_share,
        creep=p.creep,
    )


def as_array(settings: DriveSettings) -> Array:
    """Return `settings` as a record in an array, which kernels take in a fifth of the time of a tuple."""
    return np.array([settings], dtype=[(name, float) for name in settings._fields])


def drifted(settings: DriveSettings, drift: WinchDriftParameters, time: float) -> DriveSettings:
    """Return what `settings` have become by `time` [s] through a `drift`."""
    share = drift.share(time)
    return settings._replace(
        speed_gain=settings.speed_gain * (1.0 + share * (drift.gain - 1.0)),
        speed_limit=settings.speed_limit * (1.0 + share * (drift.speed - 1.0)),
        acceleration_limit=settings.acceleration_limit * (1.0 + share * (drift.acceleration - 1.0)),
    )


@njit(cache=True)
def speed_step(
    u: float, v: float, demand: float, power_speed: float, settings: DriveSettings, decay: float, h: float
) -> tuple[float, float, int]:
    """Return payout and rate after `h` seconds that follow a `demand` of speed [m/s], and the limits that acted.

    `u`, `v`, `power_speed`: as in `advance_drum`; `decay`: e^(-h/T) of the `settings`. Exact where no limit acts.
    """
    limits = 0
    demand = settings.speed_gain * _beyond_deadband(demand, settings.deadband) + settings.creep
    hauling = settings.hauling_speed_share * settings.speed_limit
    v_set = _limited(demand, min(settings.speed_limit, power_speed), min(hauling, power_speed))
    if v_set != demand:
        reached = settings.speed_limit if demand > 0.0 else hauling
        limits |= LIMIT_POWER if power_speed < reached else LIMIT_SPEED
    largest = (1.0 if v_set > v else settings.hauling_acceleration_share) * settings.acceleration_limit
    next_u, next_v, is_limited = _servo_substep(u, v, v_set, settings.time_constant, decay, largest, h)
    return next_u, next_v, limits | LIMIT_ACCELERATION if is_limited else limits


@njit(cache=True)
def advance_drum(
    u: float,
    v: float,
    duration: float,
    mode: int,
    payout_set: float,
    rate_set: float,
    power_speed: float,
    settings_array: Array,
) -> tuple[float, float, float, int]:
    """Advance the drum by `duration` with constant set-points.

    Parameters
    ----------
    u, v : payout [m] and its rate [m/s]
    duration : [s], above 0
    mode : FOLLOW_SPEED, FOLLOW_POSITION, STOP or HOLD
    payout_set, rate_set : set-points [m], [m/s]
    power_speed : largest speed that the power limit allows at the present tension [m/s]
    settings_array : `as_array` of the drive's settings

    Returns
    -------
    u, v, acceleration at the end, and the sum of the LIMIT_ flags that acted
    """
    if mode == HOLD:
        return u, 0.0, 0.0, 0
    settings = settings_array[0]
    substeps = max(1, math.ceil(duration / LONGEST_SUBSTEP - 1e-6))
    h = duration / substeps
    decay = math.exp(-h / settings.time_constant)
    largest_speed = min(settings.speed_limit, power_speed)
    limits = 0
    acceleration = 0.0
    for _ in range(substeps):
        if mode == STOP:
            next_u, next_v = _stop_substep(u, v, settings.stop_deceleration, h)
        elif mode == FOLLOW_SPEED:
            demand = rate_set + settings.position_gain * (payout_set - u - 0.5 * v * h)
            next_u, next_v, acted = speed_step(u, v, demand, power_speed, settings, decay, h)
            limits |= acted
        else:
            next_u, next_v, acted = _position_substep(
                u, v, payout_set, settings.position_rate, largest_speed, settings.acceleration_limit, h
            )
            if acted & LIMIT_SPEED and power_speed < settings.speed_limit:
                acted = acted - LIMIT_SPEED + LIMIT_POWER
            limits |= acted
        if mode != STOP:
            next_u, next_v, is_limited = _stay_in_range(
                u, v, next_u, next_v, settings.u_min, settings.u_max, settings.stop_deceleration, h
            )
            if is_limited:
                limits |= LIMIT_PAYOUT
        acceleration = (next_v - v) / h
        u = min(max(next_u, settings.u_min), settings.u_max)
        v = next_v
    return u, v, acceleration, limits
