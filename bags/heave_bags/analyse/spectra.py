"""Spectra of recorded motion: one-sided, over angular frequency, by Welch's method."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from heave_node.numerics.arrays import Array

from heave_bags.signals import Signal

MINIMUM_SAMPLES = 64
SEGMENT_TIME = 200.0
"""Length of a Welch segment [s]: a resolution of 0.03 rad/s, a tenth of a swell's frequency."""
SHORTEST_PERIOD = 1e-5
"""Nobody samples the motion of a vessel faster than this [s]."""


@dataclass(frozen=True)
class Spectrum:
    """One-sided density over angular frequency: `omega` [rad/s] and `density` [unit^2 s/rad].

    Its integral is the variance.
    """

    omega: Array
    density: Array


def spectrum(signal: Signal) -> Spectrum | None:
    """Return the spectrum of an evenly sampled signal about its mean; None if it is too short."""
    if signal.size < MINIMUM_SAMPLES:
        return None
    period = float(np.median(np.diff(signal.time)))
    if not SHORTEST_PERIOD < period < SEGMENT_TIME:
        return None
    segment = min(signal.size, max(MINIMUM_SAMPLES, round(SEGMENT_TIME / period)))
    frequency, density = scipy.signal.welch(signal.value, fs=1.0 / period, nperseg=segment, detrend="constant")
    return Spectrum(2.0 * np.pi * frequency[1:], density[1:] / (2.0 * np.pi))


def transmissibility(output: Spectrum, driver: Spectrum, floor: float = 1e-4) -> Spectrum:
    """Return `sqrt(S_output / S_driver)` of the spectra `output` and `driver`.

    Only where the driver has at least `floor` of its peak density.
    """
    density = np.interp(driver.omega, output.omega, output.density)
    excited = driver.density > floor * driver.density.max()
    return Spectrum(driver.omega[excited], np.sqrt(density[excited] / driver.density[excited]))
