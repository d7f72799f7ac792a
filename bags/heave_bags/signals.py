"""Sampled signals of a run, and the set of them that its figures are computed from."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from heave_node.loads.strength import LoadCheck, Strength, load_checks
from heave_node.numerics.arrays import Array

TIME_ROUNDING = 1e-9
"""Stamps are whole nanoseconds: windows include their ends to this [s]."""


def _empty() -> Array:
    return np.empty(0)


@dataclass
class Signal:
    """One sampled scalar: `time` [s], non-decreasing, and `value`, both of shape (n,)."""

    time: Array = field(default_factory=_empty)
    value: Array = field(default_factory=_empty)

    def window(self, start: float, end: float) -> Signal:
        """Return the part with start <= time <= end (views, no copy)."""
        first, last = np.searchsorted(self.time, (start - TIME_ROUNDING, end + TIME_ROUNDING))
        return Signal(self.time[first:last], self.value[first:last])

    def at(self, other: Signal) -> Array:
        """Return this signal at the times of `other`, linear in between; exact where the stamps agree."""
        return np.interp(other.time, self.time, self.value)

    @property
    def size(self) -> int:
        """Number of samples."""
        return int(self.time.size)


@dataclass
class RunSignals:
    """What the KPIs of a run are computed from; a signal that was not recorded stays empty, and its KPIs are NaN."""

    unit_heave: Signal = field(default_factory=Signal)  # vertical position, positive up [m]
    uncompensated_heave: Signal = field(default_factory=Signal)  # vertical position, positive up [m]
    boom_tip_heave: Signal = field(default_factory=Signal)  # vertical position, positive up [m]
    payout: Signal = field(default_factory=Signal)  # of the drum, positive pays out [m]
    payout_rate: Signal = field(default_factory=Signal)  # of the drum, positive pays out [m/s]
    payout_acceleration: Signal = field(default_factory=Signal)  # of the drum, positive pays out [m/s^2]
    tension: Signal = field(default_factory=Signal)  # top tension [N]
    # largest of it since the sample before, at the same times [N]; empty when unknown
    largest_tension: Signal = field(default_factory=Signal)
    # the same with the winch locked, or following the programme of depth only [N]
    uncompensated_tension: Signal = field(default_factory=Signal)
    # the same with the winch locked, or following the programme of depth only [N]
    uncompensated_largest_tension: Signal = field(default_factory=Signal)
    # top tension at rest [N], one sample where the deployed length stays; empty takes the mean tension
    static_tension: Signal = field(default_factory=Signal)
    unit_tension: Signal = field(default_factory=Signal)  # of the cable at the unit [N]
    slack: Signal = field(default_factory=Signal)  # 1 where any part of the cable carries no tension
    # sum of the WinchLimit flags of the limits that act, as the winch itself reports it
    limits_hit: Signal = field(default_factory=Signal)
    compensating: Signal = field(default_factory=Signal)  # 1 where the controller compensates or holds a tension
    # vertical position of the unit as it was recorded, programme of depth and all, positive up [m]
    unit_height: Signal = field(default_factory=Signal)
    touchdown: Signal = field(default_factory=Signal)  # 1 where the bottom carries the unit
    holds_tension: Signal = field(default_factory=Signal)  # 1 where the controller holds a tension
    mode_changes: Signal = field(default_factory=Signal)  # 1 where the controller has just changed its mode
    losses: Signal = field(default_factory=Signal)  # 1 where compensation has just ended that nobody had asked to end
    # 1 where the normalised innovation squared lies inside its 95 % band
    nis_in_band: Signal = field(default_factory=Signal)
    # wall time that the controller computed for a tick [s]; empty in lockstep, where it is not reported
    execution_time: Signal = field(default_factory=Signal)
    speed_limit: float = math.inf  # of the winch [m/s]; infinite: unknown or none
    acceleration_limit: float = math.inf  # of the winch [m/s^2]; infinite: unknown or none
    power_limit: float = math.inf  # of the winch [W]; infinite: unknown or none
    strengths: tuple[Strength, ...] = ()  # what the parts of the lift can carry, as far as it is stated
    # angular frequency of a driven scenario [rad/s]; NaN if the scenario is not driven by one regular motion
    driving_omega: float = math.nan
    sensor_bound: float = math.nan  # the sensors' bound in kappa [m]; NaN: unknown
    actuator_bound: float = math.nan  # the winch's bound in kappa [m]; NaN: unknown
    lost: str = ""  # when and why compensation was first lost, in words; "": it was not, or not known
    baseline: RunSignals | None = None  # the same sea and seed under the baseline law; None when unknown
    real_time_factor: float = math.nan  # of the run as a whole [-]; NaN when unknown
    missed_deadlines: float = math.nan  # of the run as a whole [-]; NaN when unknown
    # commands that took effect later than the controller's model says [-]; NaN when unknown
    late_commands: float = math.nan
    # start of a tick to its last answer, wall time: p50, p99 and largest [s]; NaN when unknown
    loop_age: tuple[float, float, float] = (math.nan, math.nan, math.nan)

    def peak_tension(self) -> Signal:
        """Return the largest tension since the sample before, at each sample; the sample itself where it is unknown."""
        return _peaks(self.tension, self.largest_tension)

    def uncompensated_peak_tension(self) -> Signal:
        """Return the same of the uncompensated tension."""
        return _peaks(self.uncompensated_tension, self.uncompensated_largest_tension)

    def load_checks(self, start: float = -math.inf, end: float = math.inf) -> tuple[LoadCheck, ...]:
        """Return how the parts whose strength is stated stand under their largest load from `start` to `end` [s].

        The load of rope and winch is the top tension, that of the attachment the tension at the unit as sampled.
        """
        top, unit = (signal.window(start, end).value for signal in (self.peak_tension(), self.unit_tension))
        return load_checks(self.strengths, top=_largest(top), unit=_largest(unit))

    def static_at(self, tension: Signal) -> Array:
        """Return the static tension at the samples of a tension [N]: their mean where it is not known."""
        if self.static_tension.size:
            return self.static_tension.at(tension)
        return np.full(tension.size, tension.value.mean() if tension.size else math.nan)


def _largest(tensions: Array) -> float:
    """Return the largest tension; NaN where there is none at all, which nobody measured."""
    largest = float(tensions.max()) if tensions.size else 0.0
    return largest if largest > 0.0 else math.nan


def _peaks(tension: Signal, largest: Signal) -> Signal:
    if largest.size != tension.size:
        return tension
    return Signal(tension.time, np.maximum(tension.value, largest.value))


def integrated(values: Array, period: float, cut_off: float, *, times: int = 2) -> Array:
    """Return the motion about its mean of which samples, `period` [s] apart, are a derivative.

    Parameters
    ----------
    values : acceleration [m/s^2] or velocity [m/s]
    period : of the samples [s]
    cut_off : what is slower is taken out [rad/s]
    times : 2 for an acceleration, 1 for a velocity

    In the frequency domain: X = A/(i omega)^times, faded in over the half octave below and above the cut-off. The ends
    of the record ring; whole records of minutes are meant.
    """
    transform = np.fft.rfft(values - values.mean())
    omega = 2.0 * math.pi * np.fft.rfftfreq(values.size, period)
    octaves = np.log2(np.maximum(omega, 1e-12) / cut_off)
    gain = np.clip(octaves + 0.5, 0.0, 1.0)
    gain = gain * gain * (3.0 - 2.0 * gain)
    with np.errstate(divide="ignore", invalid="ignore"):
        motion = np.where(gain > 0.0, transform * gain / (1j * omega) ** times, 0.0)
    return np.asarray(np.fft.irfft(motion, values.size))
