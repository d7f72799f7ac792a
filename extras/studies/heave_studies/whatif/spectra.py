"""Transforms of readings at their own times, Wiener's smoother, the boom tip, and the cable's transfer function.

Wiener, Extrapolation, Interpolation and Smoothing of Stationary Time Series (1949), in the frequency domain: each
frequency is weighed by the share of its power that is no noise. One rule for boom tip, unit and drum.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from cable_sim_node.physics.drag import HARMONIC_DRAG
from cable_sim_node.vertical.axial_line import AxialLine
from cable_sim_node.vertical.linear import march
from heave_node.numerics.arrays import Array, ComplexArray
from scipy.fft import dct, idct
from scipy.signal.windows import tukey
from winch_controller_node.beliefs.beliefs import Correction

from heave_studies.whatif.record import SensorRecord

BAND = (0.25, 4.0)
"""Angular frequencies of waves, which are judged [rad/s]."""

QUIET, HIGHEST = 5.0, 0.9
"""Angular frequency above which what is read is noise, but for narrow resonances [rad/s]; and share of the highest that
the readings can show, up to which it is looked at."""

QUIET_COUNT, LEAST_BAND = 400, 1.2
"""Number of quiet frequencies that are looked at; and least ratio of the highest to the lowest of them."""

RANDOM_DRAG = math.sqrt(8.0 / math.pi)
"""Linear damping over quadratic drag and the standard deviation of a Gaussian speed (Borgman, The spectral density for
ocean wave forces, 1965)."""


class Transform:
    """Fourier transform of readings at their own times under a Hann taper.

    Parameters
    ----------
    times : of the readings (n,) [s]
    omegas : angular frequencies (k,), evenly spaced [rad/s]
    start, end : of the taper [s]

    The readings' own spacing is their weight, so that no interpolation bends what is fast. Each frequency is one of
    sqrt(k) coarse ones and one of sqrt(k) fine steps, so that exponentials are of these alone.
    """

    def __init__(self, times: Array, omegas: Array, start: float, end: float) -> None:
        self._inside = (times >= start) & (times <= end)
        t = times[self._inside]
        self._weight = np.sin(math.pi * (t - start) / (end - start)) ** 2
        spacing = float(np.median(np.diff(t)))
        # the taper's own power is one, whatever the length of the record
        scale = spacing / math.sqrt(spacing * float(self._weight @ self._weight))
        self._count, fine = len(omegas), math.ceil(math.sqrt(len(omegas)))
        self._coarse = scale * np.exp(-1j * np.outer(omegas[::fine], t))
        self._fine = np.exp(-1j * np.outer(t, omegas[:fine] - omegas[0]))

    def __call__(self, values: Array) -> ComplexArray:
        """Return the transform (k,) of `values` read at the times (n,), about their mean."""
        v, weight = values[self._inside], self._weight
        v = v - float(weight @ v) / float(np.sum(weight))
        return np.asarray(((self._coarse * (weight * v)) @ self._fine).ravel()[: self._count])


def noise_power(times: Array, values: Array, start: float, end: float, stated: float) -> float:
    """Return the power of the white noise in readings in the units of a `Transform`.

    Parameters
    ----------
    times, values : of the readings (n,) [s], any unit
    start, end : of the taper [s]
    stated : standard deviation of the noise, taken where the readings are too seldom to show it
    """
    spacing = float(np.median(np.diff(times)))
    highest = HIGHEST * math.pi / spacing
    if highest < LEAST_BAND * QUIET:
        return stated**2 * spacing
    omegas = np.linspace(QUIET, highest, QUIET_COUNT)
    return noise_level(np.abs(Transform(times, omegas, start, end)(values)) ** 2)


def noise_level(power: Array) -> float:
    """Return the power of white noise in a periodogram, `power` at quiet frequencies: no narrow resonance moves it.

    The median of an exponential distribution is log 2 of its mean.
    """
    return float(np.median(power)) / math.log(2.0)


class Speeds(NamedTuple):
    """Standard deviation of the vertical speed of the cable's ends, by which drag is linearised."""

    unit: float  # of the lower end [m/s]
    top: float  # of the end at the outlet [m/s]


def gains_over_top(line: AxialLine, length: float, omegas: Array, speeds: Speeds) -> ComplexArray:
    """Return heave of the unit, and the top tension [N/m], over the heave of the cable's top end, (2, k).

    Parameters
    ----------
    line : cable and unit
    length : unstretched cable [m]
    omegas : angular frequencies (k,) [rad/s]
    speeds : by which the drag of unit and cable is linearised

    The ends move independently of one another, and each piece with its share of both.
    """
    pieces = line.pieces(length)
    lengths = np.array([piece.length for piece in pieces])
    share = (np.cumsum(lengths) - 0.5 * lengths) / length
    along = np.hypot((1.0 - share) * speeds.unit, share * speeds.top)
    of_places = RANDOM_DRAG / HARMONIC_DRAG * np.array([speeds.unit, *along])
    motion = march(line, pieces, omegas, np.outer(of_places, np.ones(len(omegas))))
    return np.asarray([1.0 / motion.heave[-1], motion.top_tension / motion.heave[-1]])


SMOOTHED = 0.01
"""Half the width over which a spectrum is smoothed [Hz]."""

CHANCE = 1.6
"""Standard deviations of a smoothed spectrum of noise up to which it is noise."""

LEAST_QUIET = 20
"""Fewer quiet frequencies than this do not tell the noise; it is then taken as stated."""


class Smoothed(NamedTuple):
    """What stands above the noise in a series of n values."""

    values: Array  # of the series without its noise (n,)
    omega: Array  # angular frequencies (n,) [rad/s]
    power: Array  # of the series at each, of which the sum is that of the squares of its values (n,)
    smooth: Array  # the same, smoothed (n,)
    kept: Array  # share of each frequency that was kept (n,) [-]
    noise: float  # variance of a value by white noise [m^2]


def smoothed(values: Array, period: float, stated: float = 0.0, highest: float = math.inf) -> Smoothed:
    """Return what stands above the noise in a series, mirrored at both ends: it need not begin as it ends.

    Parameters
    ----------
    values : of the series (n,)
    period : from one to the next [s]
    stated : standard deviation of their noise, where they are too seldom to show it
    highest : angular frequency above which nothing is kept [rad/s]
    """
    omega = np.asarray(math.pi / (len(values) * period) * np.arange(len(values)), dtype=np.float64)
    series = np.asarray(dct(values, norm="ortho"))
    smooth, count = smooth_spectrum(series**2, omega), smoothed_count(omega)
    quiet = smooth[omega > QUIET]
    # the median of a mean of so many squares is below their mean (Wilson and Hilferty, 1931)
    noise = float(np.median(quiet)) / (1.0 - 2.0 / (9.0 * count)) ** 3 if quiet.size >= LEAST_QUIET else stated**2
    kept = np.where(omega <= highest, wiener_gain(smooth, noise, math.sqrt(2.0 / count)), 0.0)
    return Smoothed(np.asarray(idct(kept * series, norm="ortho")), omega, series**2, smooth, kept, noise)


def wiener_gain(smooth: Array, noise: Array | float, spread: float) -> Array:
    """Return the share of each frequency that is no noise [-].

    Parameters
    ----------
    smooth : smoothed power of the readings (k,)
    noise : of it, by noise alone (k,)
    spread : standard deviation of a smoothed spectrum of noise, over its mean [-]: what it may raise by chance is none
    """
    return np.clip(1.0 - (1.0 + CHANCE * spread) * noise / np.maximum(smooth, 1e-300), 0.0, 1.0)


def smooth_spectrum(power: Array, omega: Array) -> Array:
    """Return a spectrum, `power` at evenly spaced angular frequencies `omega` [rad/s], as its moving mean."""
    about = np.ones(smoothed_count(omega))
    return np.asarray(np.convolve(power, about, "same") / np.convolve(np.ones_like(power), about, "same"))


def smoothed_count(omega: Array) -> int:
    """Return how many of the angular frequencies `omega` [rad/s] are averaged in a smoothed spectrum."""
    return 2 * max(1, round(2.0 * math.pi * SMOOTHED / float(omega[1] - omega[0]))) + 1


WAVES = (0.2, 4.0)
"""Angular frequencies of the motion that waves, and the unit on its cable, bring about [rad/s]."""


class Disturbance(NamedTuple):
    """Motion of the unit that its twin does not explain."""

    heave: Array  # at each tick, about its mean, positive up (n,) [m]
    waves: float  # standard deviation of it where waves are [m]
    left: float  # standard deviation of the sensor's noise that is in it [m]


def disturbance(readings: Array, time: Array, twin: Array, stated_noise: float) -> Disturbance:
    """Return what of the readings of a sensor its twin does not explain.

    Parameters
    ----------
    readings : times and values, of the unit's heave for example, shape (m, 2)
    time : of each tick (n,) [s]
    twin : what the twin has at each tick (n,)
    stated_noise : of a reading, where the readings do not tell it
    """
    times, values = readings.T
    order = np.argsort(times, kind="stable")
    times, values = times[order], values[order]
    period = float(np.median(np.diff(times)))
    count = round((times[-1] - times[0]) / period) + 1
    grid = times[0] + period * np.arange(count)
    gap = np.interp(grid, times, values) - np.interp(grid, time, twin)
    found = smoothed(gap - gap.mean(), period, stated_noise, WAVES[1])
    inside = (found.omega >= WAVES[0]) & (found.omega <= WAVES[1])
    return Disturbance(
        heave=np.interp(time, grid, found.values),
        waves=math.sqrt(float(np.sum((found.kept * found.smooth)[inside])) / count),
        left=math.sqrt(float(found.kept @ found.kept) * found.noise / count),
    )


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
    time, heave = record.mru.T
    order = np.argsort(time, kind="stable")
    heaves = np.interp(record.time + correction.delay, time[order], heave[order])
    heaves = (heaves - correction.offset) / correction.scale
    count, dt = len(heaves), record.tick_period
    padding = min(count // 2, round(60.0 / dt))
    size = count + 2 * padding
    # its mirror image at both ends, faded out: the ends of a record do not ring
    series = np.pad(heaves - heaves.mean(), padding, mode="reflect") * tukey(size, 2.0 * padding / size)
    omega = np.asarray(2.0 * math.pi * np.fft.rfftfreq(size, dt), dtype=np.float64)
    read, response = np.fft.rfft(series), high_pass.response(omega)
    gain = np.divide(1.0, response, out=np.zeros_like(response), where=np.abs(response) > 1e-3)
    noise = noise_level(np.abs(read[omega > QUIET]) ** 2) * np.abs(gain) ** 2
    spread = math.sqrt(1.0 / smoothed_count(omega))
    kept = wiener_gain(smooth_spectrum(np.abs(gain * read) ** 2, omega), noise, spread)
    if high_pass.period > 0.0:  # none below SLOWEST, all from half as much above
        share = np.clip((omega / SLOWEST - 1.0) / 0.5, 0.0, 1.0)
        kept = kept * share * share * (3.0 - 2.0 * share)
    motion, inside = kept * gain * read, slice(padding, padding + count)
    return Tip(
        np.asarray(np.fft.irfft(motion, size)[inside]),
        np.asarray(np.fft.irfft(1j * omega * motion, size)[inside]),
        math.sqrt(2.0 * float(np.sum(kept * noise)) / size**2),
    )


@dataclass(frozen=True)
class TipSource:
    """What the MRU has read of the boom tip, smoothed."""

    time: Array  # of each tick (n,) [s]
    plain: Tip  # boom tip under what is assumed of the MRU
    high_pass: HighPass  # that the MRU has

    def under(self, scale: float = 1.0, delay: float = 0.0) -> Tip:
        """Return the boom tip under what is other than assumed.

        Parameters
        ----------
        scale : reading over truth [-]
        delay : of the readings [s]
        """
        heave, rate = self.plain.heave / scale, self.plain.rate / scale
        if delay != 0.0:
            heave, rate = (np.interp(self.time + delay, self.time, one) for one in (heave, rate))
        return Tip(heave, rate, self.plain.sigma)
