"""The sea state from the MRU record alone: spectrum, Hs and Tp with confidence, running.

Welch's method: periodograms of half-overlapping Hann segments, the newest of them averaged over the window. The known
response of the unit's high-pass and of the vessel is taken out, and the unit's stated noise subtracted; where the
vessel hardly answers (short waves) the spectrum is continued by its omega^-5 tail.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.special  # noqa: F401  # `spectral_estimate` would load it at the first estimate, within a tick
from heave_node.interface.codes import MruStatus
from heave_node.interface.sensors import MruReading
from heave_node.numerics.arrays import Array
from heave_node.numerics.spectral_estimate import (
    height_interval,
    peak_frequency,
    peak_period_interval,
    resampled_spectra,
    segment_frequencies,
    segment_periodogram,
    segment_size,
)

from wave_vessel_node.parameters import SeaStateEstimateParameters

_MINIMUM_SEGMENTS = 3
_LEAST_RESPONSE = 0.03  # of |H|^2: below, the motion says nothing of the sea
_LOWEST_PERIOD = 40.0  # s: waves are shorter; below this frequency only drift and the unit's wander
_LONGEST_GAP = 2.0  # s: a longer one breaks the record
_FEWEST_LINES = 8  # of the spectrum between drift and ripples: with fewer, readings are too far apart for waves


@dataclass(frozen=True)
class SeaStateEstimate:
    """See the message of the same name. Intervals are 95 %."""

    time: float  # end of the record used [s]
    record_length: float  # [s]
    significant_wave_height: float  # of the sea [m], with intervals
    significant_wave_height_interval: tuple[float, float]
    peak_period: float  # of the sea [s], with intervals
    peak_period_interval: tuple[float, float]
    boom_tip_sigma: float  # standard deviation of the boom-tip heave [m]
    angular_frequency: Array  # of the spectra [rad/s]
    spectral_density: Array  # spectrum of the boom-tip heave [m^2 s/rad]
    sea_density: Array  # spectrum of the sea at the same frequencies, nan where the motion does not tell


class SeaStateEstimator:
    """Feed it every reading; ask it for the estimate.

    Parameters
    ----------
    parameters : see SeaStateEstimateParameters
    sample_period : time between readings [s]
    noise : standard deviation of the heave noise the unit states [m]
    unit_response : |H|^2 of the unit (high-pass) at frequencies [rad/s]
    vessel_response : |H|^2 from the sea to the boom-tip heave; where it is small the sea is not seen
    """

    def __init__(
        self,
        parameters: SeaStateEstimateParameters,
        *,
        sample_period: float,
        noise: float,
        unit_response: Callable[[Array], Array],
        vessel_response: Callable[[Array], Array],
    ) -> None:
        self._period = sample_period
        count = segment_size(parameters.segment, sample_period)
        self._samples = np.zeros(count)
        self._filled = 0
        self._last_time = -math.inf
        keep = max(_MINIMUM_SEGMENTS, int(2.0 * parameters.window / parameters.segment) - 1)
        self._periodograms: deque[Array] = deque(maxlen=keep)
        omega = segment_frequencies(count, sample_period)
        self._band = slice(
            int(np.searchsorted(omega, 2.0 * math.pi / _LOWEST_PERIOD)), int(np.searchsorted(omega, 4.0))
        )
        self._omega = np.asarray(omega[self._band], dtype=np.float64)
        self._sees_waves = self._omega.size >= _FEWEST_LINES
        self._unit = np.maximum(unit_response(self._omega), 1e-6)
        self._vessel = vessel_response(self._omega)
        self._noise_density = noise**2 * sample_period / math.pi
        self._segment_length = count * sample_period

    def add(self, reading: MruReading) -> None:
        """Take one reading; those that are not OK are left out, short gaps are bridged, a long one starts a new
        segment.
        """
        if not self._sees_waves or reading.status != MruStatus.OK or not math.isfinite(reading.heave):
            return
        missing = round((reading.time - self._last_time) / self._period) - 1 if self._filled else 0
        if missing < 0:
            return
        if missing * self._period > _LONGEST_GAP:
            self._filled = missing = 0
        previous = self._samples[self._filled - 1] if self._filled else reading.heave
        for step in range(1, missing + 2):
            self._put(previous + (reading.heave - previous) * step / (missing + 1))
        self._last_time = reading.time

    def _put(self, value: float) -> None:
        self._samples[self._filled] = value
        self._filled += 1
        if self._filled == self._samples.size:
            self._periodograms.append(segment_periodogram(self._samples, self._period)[self._band])
            half = self._samples.size // 2
            self._samples[:half] = self._samples[half:]
            self._filled = half

    def estimate(self) -> SeaStateEstimate | None:
        """Return the estimate from the record so far, None while it is too short (three segments, half overlapping)."""
        if len(self._periodograms) < _MINIMUM_SEGMENTS:
            return None
        segments = np.array(self._periodograms)
        record = self._segment_length * 0.5 * (len(segments) + 1)
        motion = np.maximum(segments.mean(axis=0) - self._noise_density, 0.0) / self._unit
        sea, m0 = self._sea(motion)
        return SeaStateEstimate(
            time=self._last_time,
            record_length=record,
            significant_wave_height=4.0 * math.sqrt(m0),
            significant_wave_height_interval=height_interval(self._omega, np.nan_to_num(sea), m0, record),
            peak_period=float(2.0 * math.pi / peak_frequency(self._omega, np.nan_to_num(sea)[None])[0]),
            peak_period_interval=self._peak_interval(segments, sea),
            boom_tip_sigma=math.sqrt(self._integral(motion)),
            angular_frequency=self._omega,
            spectral_density=motion,
            sea_density=sea,
        )

    def _integral(self, density: Array) -> float:
        """Return the integral over the band of a density at the evenly spaced frequencies of the transform."""
        return float(density.sum() * (self._omega[1] - self._omega[0]))

    def _sea(self, motion: Array) -> tuple[Array, float]:
        """Return the spectrum of the sea where the vessel responds (nan elsewhere), and m_0 with the tail continued."""
        seen = (self._vessel > _LEAST_RESPONSE * self._vessel.max()) & (self._vessel > 1e-12)
        seen &= motion * self._unit > 0.5 * self._noise_density
        sea = np.where(seen, motion / np.maximum(self._vessel, 1e-12), np.nan)
        m0 = self._integral(np.nan_to_num(sea))
        if seen.any():
            last = int(np.flatnonzero(seen)[-1])
            around = sea[max(0, last - 10) : last + 1]
            m0 += float(np.nanmean(around)) * self._omega[last] / 4.0  # integral of S_c (omega_c / omega)^5
        return sea, m0

    def _peak_interval(self, segments: Array, sea: Array) -> tuple[float, float]:
        """Return the 95 % interval of the peak period by resampling the segments."""
        seen = np.isfinite(sea)
        motion = np.maximum(resampled_spectra(segments) - self._noise_density, 0.0) / self._unit
        drawn = np.where(seen, motion / np.where(seen, self._vessel, 1.0), 0.0)
        return peak_period_interval(self._omega, np.nan_to_num(sea), drawn, len(segments))
