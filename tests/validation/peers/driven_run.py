"""A plant with its winch locked and its boom tip moved as a sine: its response, to compare with others."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.parameters import CableSimParameters
from heave_node.numerics.arrays import Array
from heave_node.numerics.kinematics import PointMotion


@dataclass(frozen=True)
class DrivenResponse:
    """First harmonics and extremes over the last part of a driven run, and the records behind them."""

    unit_heave_amplitude: float  # first harmonic of the unit's z [m]
    unit_heave_phase: float  # lead of the unit over the boom tip [rad]
    unit_heave_mean: float  # mean of the unit's z [m]
    tension_mean: float  # mean of the top tension [N]
    tension_amplitude: float  # first harmonic of the top tension [N]
    tension_min: float  # its least [N]
    tension_max: float  # its largest, between the records too [N]
    times: Array  # of the records [s], shape (k,)
    unit: Array  # positions of the unit [m], shape (k, 3)
    tension: Array  # top tension [N], shape (k,)


def smooth_rise(s: float) -> tuple[float, float]:
    """Return a rise from 0 at `s` = 0 to 1 at 1 and its slope; that, and its bend, vanish at both ends."""
    s = min(max(s, 0.0), 1.0)
    return s**3 * (10.0 - 15.0 * s + 6.0 * s * s), 30.0 * s**2 * (1.0 - s) ** 2


def smooth_start(t: float, rise: float) -> tuple[float, float]:
    """Return way [m] and speed [m/s] at `t` [s] of what comes from rest to 1 m/s within `rise` [s]: `smooth_rise`."""
    s = min(t / rise, 1.0)
    return rise * (2.5 * s**4 - 3.0 * s**5 + s**6) + max(t - rise, 0.0), smooth_rise(s)[0]


def ramped_sine(amplitude: Sequence[float], frequency: float, ramp: float) -> Callable[[float], PointMotion]:
    """Return the motion x_i = a_i r(t) sin(w t) [m], with r a ramp whose first two derivatives vanish at its ends.

    Parameters
    ----------
    amplitude : a along x, y, z [m]
    frequency : w [rad/s]
    ramp : how long r rises from 0 to 1 [s]
    """
    direction = np.array(amplitude, dtype=float)

    def motion(t: float) -> PointMotion:
        s = min(t / ramp, 1.0)
        rise, slope = smooth_rise(s)
        slope /= ramp
        bend = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / ramp**2
        sine, cosine = math.sin(frequency * t), math.cos(frequency * t)
        return PointMotion(
            time=t,
            position=direction * (rise * sine),
            velocity=direction * (slope * sine + rise * frequency * cosine),
            acceleration=direction * ((bend - rise * frequency**2) * sine + 2.0 * slope * frequency * cosine),
        )

    return motion


def run_driven(
    parameters: CableSimParameters,
    amplitude: Sequence[float],
    frequency: float,
    *,
    duration: float,
    window: float,
    ramp: float,
    tick: float = 0.05,
) -> DrivenResponse:
    """Start at equilibrium under the origin, drive the boom tip and analyse the end of the run.

    Parameters
    ----------
    parameters : of the plant
    amplitude : of the boom tip along x, y, z [m]
    frequency : [rad/s]; phases refer to sin(frequency t)
    duration : of the run [s]
    window : at its end, that is analysed [s]
    ramp : at its start [s]
    tick : interval of integration and of the records [s]
    """
    motion = ramped_sine(amplitude, frequency, ramp)
    plant = CableDynamics(parameters)
    plant.start_at_equilibrium(np.zeros(3))
    count = round(duration / tick)
    first = count - round(window / tick)
    times, unit, tension, peaks = [], [], [], []
    start = motion(0.0)
    for k in range(1, count + 1):
        end = motion(k * tick)
        plant.advance(tick, start, end, 0.0, 0.0, 0.0, 0.0)
        start = end
        if k > first:
            times.append(end.time)
            unit.append(plant.unit_position)
            tension.append(plant.top_tension)
            peaks.append(plant.largest_top_tension)
    record, heave = np.array(times), np.array(unit)[:, 2]
    mean, size, phase = first_harmonic(record, heave, frequency)
    tension_mean, tension_size, _ = first_harmonic(record, np.array(tension), frequency)
    return DrivenResponse(
        unit_heave_amplitude=size,
        unit_heave_phase=phase,
        unit_heave_mean=mean,
        tension_mean=tension_mean,
        tension_amplitude=tension_size,
        tension_min=min(tension),
        tension_max=max(peaks),
        times=record,
        unit=np.array(unit),
        tension=np.array(tension),
    )


def first_harmonic(times: Array, values: Array, frequency: float) -> tuple[float, float, float]:
    """Return mean, amplitude and phase [rad] of a record's sine, fitted with two higher harmonics beside it.

    Parameters
    ----------
    times : [s], shape (k,)
    values : shape (k,)
    frequency : of the sine [rad/s]
    """
    columns = [np.ones_like(times)]
    for k in (1, 2, 3):
        columns += [np.sin(k * frequency * times), np.cos(k * frequency * times)]
    fit = np.linalg.lstsq(np.array(columns).T, values, rcond=None)[0]
    return float(fit[0]), float(math.hypot(fit[1], fit[2])), math.atan2(fit[2], fit[1])


def lower(
    plant: CableDynamics, motion: Callable[[float], PointMotion], speed: float, stop: float, tick: float
) -> tuple[Array, Array]:
    """Lower a plant at rest at `speed` [m/s], reached in 5 s, to a length `stop` [m]; `motion` is its top's, by time.

    Return, at the end of each tick, lengths [m] and positions of the unit [m].
    """
    lengths: list[float] = []
    units: list[Array] = []
    payout = rate = 0.0
    for k in range(int((stop - plant.unstretched_length) / speed / tick)):
        new = speed * min((k + 1) * tick / 5.0, 1.0)
        after = payout + 0.5 * tick * (rate + new)
        plant.advance(tick, motion(k * tick), motion((k + 1) * tick), payout, rate, after, new)
        payout, rate = after, new
        lengths.append(plant.unstretched_length)
        units.append(plant.unit_position)
    return np.array(lengths), np.array(units)
