"""The boom tip as the whole record of the MRU shows it: smoothed over all of it, its high-pass taken back.

Heave and heave rate are two readings of one motion, weighed by their noise, and what is left in the noise is left out.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from heave_node.numerics.arrays import Array, ComplexArray
from winch_controller_node.beliefs.corrections import Correction

from heave_studies.whatif.signals.record import SensorRecord, at_ticks
from heave_studies.whatif.signals.smoother import smooth_spectrum, smoothed_count, wiener_gain
from heave_studies.whatif.signals.spectra import QUIET, noise_level

SLOWEST = 0.12
"""Angular frequency below which no heave is taken from an MRU with a high-pass: a swell of 52 s [rad/s]."""


class Tip(NamedTuple):
    """The boom tip's heave about its mean at each tick, positive up."""

    heave: Array  # [m]
    rate: Array  # [m/s]
    sigma: float  # standard deviation of what is not known of the heave [m]


class HighPass(NamedTuple):
    """Second-order high-pass of an MRU."""

    period: float = 0.0  # cut-off [s]; 0: none
    damping: float = 0.7071  # ratio [-]

    def response(self, omega: Array) -> ComplexArray:
        """Return reading over truth at angular frequencies `omega` [rad/s]."""
        if self.period == 0.0:
            return np.ones(len(omega), dtype=complex)
        cut_off, s = 2.0 * math.pi / self.period, 1j * omega
        return np.asarray(s**2 / (s**2 + 2.0 * self.damping * cut_off * s + cut_off**2))


def smoothed_tip(record: SensorRecord, correction: Correction, high_pass: HighPass) -> Tip:
    """Return the boom tip's heave at each tick of a `record`.

    Parameters
    ----------
    record : with an MRU
    correction : of the MRU's scale, mean and delay
    high_pass : that the MRU has, as far as it is known
    """
    time, heave, rate = record.mru.T
    time = time - correction.delay
    has_rate = bool(np.isfinite(rate).all())
    heaves = (at_ticks(record, time, heave) - correction.offset) / correction.scale
    rates = at_ticks(record, time, rate) / correction.scale if has_rate else np.zeros_like(heaves)
    count, dt = len(heaves), record.tick_period
    padding = min(count // 2, round(60.0 / dt))
    X, V = (np.fft.rfft(one) for one in _padded(heaves - heaves.mean(), rates, padding, dt))
    omega = np.asarray(2.0 * math.pi * np.fft.rfftfreq(count + 2 * padding, dt), dtype=np.float64)
    response = high_pass.response(omega)
    weight_x = np.abs(response) ** 2 / _noise(X, omega)
    weight_v = np.abs(response * omega) ** 2 / _noise(V, omega) if has_rate else np.zeros_like(omega)
    gain = np.divide(1.0, response, out=np.zeros_like(response), where=np.abs(response) > 1e-3)
    by_rate = np.divide(V, 1j * omega, out=np.zeros_like(V), where=omega > 0.0)
    total = np.maximum(weight_x + weight_v, 1e-300)
    both = gain * (weight_x * X + weight_v * by_rate) / total
    spread = math.sqrt(1.0 / smoothed_count(omega))
    kept = wiener_gain(smooth_spectrum(np.abs(both) ** 2, omega), 1.0 / total, spread)
    kept = kept * (_fade(omega) if high_pass.period > 0.0 else 1.0)
    motion = kept * both
    parts = slice(padding, padding + count)
    size = count + 2 * padding
    left = 2.0 * float(np.sum(kept / total)) / size**2
    return Tip(
        np.asarray(np.fft.irfft(motion, size)[parts]),
        np.asarray(np.fft.irfft(1j * omega * motion, size)[parts]),
        math.sqrt(max(left, 0.0)),
    )


def _noise(transform: ComplexArray, omega: Array) -> float:
    """Return the power of the white noise in a `transform`, by what is quiet."""
    quiet = np.abs(transform[omega > QUIET]) ** 2
    return max(noise_level(quiet), 1e-18) if quiet.size else 1e-18


def _fade(omega: Array) -> Array:
    """Return the share of each frequency that is taken as heave: none below SLOWEST, all from half as much above."""
    share = np.clip((omega / SLOWEST - 1.0) / 0.5, 0.0, 1.0)
    return np.asarray(share * share * (3.0 - 2.0 * share))


def _padded(heave: Array, rate: Array, padding: int, tick_period: float) -> tuple[Array, Array]:
    """Return a motion and its rate with their mirror image at both ends, faded out: the ends of a record do not ring.

    A rate turns round in the mirror, and has what the fading itself moves.
    """
    turn = math.pi * np.arange(padding) / max(padding, 1)
    fade, slope = 0.5 * (1.0 - np.cos(turn)), 0.5 * math.pi / max(padding, 1) / tick_period * np.sin(turn)
    first, last = slice(padding, 0, -1), slice(-2, -padding - 2, -1)
    before = heave[first] * fade, -rate[first] * fade + heave[first] * slope
    after = heave[last] * fade[::-1], -rate[last] * fade[::-1] - heave[last] * slope[::-1]
    parts = zip(before, (heave, rate), after, strict=True)
    padded, of_rate = (np.concatenate(part) for part in parts)
    return padded, of_rate


STEADY = 0.5
"""Time over which an attitude is averaged: no vessel rolls so fast [s]."""

TURNS = 1e-3
"""Standard deviation of a pitch from which on a lever arm matters [rad]."""


@dataclass(frozen=True)
class TipSource:
    """What the MRU has read of the boom tip, smoothed."""

    time: Array  # of each tick (n,) [s]
    plain: Tip  # boom tip under what is assumed of the MRU
    assumed: Correction  # of the MRU
    high_pass: HighPass  # that the MRU has
    pitch: Array  # of the vessel at each tick, about its mean (n,) [rad]
    pitch_rate: Array  # of the vessel at each tick (n,) [rad/s]

    @property
    def turns(self) -> bool:
        """Whether the vessel pitches so much that a wrong lever arm shows."""
        return float(np.std(self.pitch)) > TURNS

    def under(self, scale: float = 1.0, delay: float = 0.0, lever_arm: float = 0.0) -> Tip:
        """Return the boom tip under what is other than assumed.

        Parameters
        ----------
        scale : reading over truth [-]
        delay : of the readings [s]
        lever_arm : error of it, forward [m]
        """
        heave = self.plain.heave / scale + lever_arm * self.pitch
        rate = self.plain.rate / scale + lever_arm * self.pitch_rate
        if delay != 0.0:
            heave, rate = (np.interp(self.time + delay, self.time, one) for one in (heave, rate))
        return Tip(heave, rate, self.plain.sigma)


def tip_source(record: SensorRecord, assumed: Correction, high_pass: HighPass) -> TipSource:
    """Return what the MRU of a `record` says of the boom tip, with what is `assumed` of it and its `high_pass`."""
    time, _, pitch = record.attitude.T
    read = at_ticks(record, time - assumed.delay, pitch) if len(time) else np.zeros(record.ticks)
    half = max(1, round(0.5 * STEADY / record.tick_period))
    about = np.ones(2 * half + 1)
    mean = np.convolve(read - read.mean(), about, "same") / np.convolve(np.ones_like(read), about, "same")
    return TipSource(
        record.time,
        smoothed_tip(record, assumed, high_pass),
        assumed,
        high_pass,
        mean,
        np.gradient(mean, record.tick_period),
    )
