"""Fit of the thesis's second-order vessel (Eq. 6.25) to an RAO of boom-tip heave, in the frequency domain."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from heave_node.numerics.arrays import Array, ComplexArray
from numpy.typing import NDArray

from wave_vessel_node.sea.spectra import WaveSpectrum
from wave_vessel_node.vessel.motion import lever_arm_matrix
from wave_vessel_node.vessel.rao import RaoError, above_the_table, between
from wave_vessel_node.vessel.rao_files import read_rao
from wave_vessel_node.vessel.second_order import SecondOrderVessel


@dataclass(frozen=True)
class VesselFit:
    """A second-order vessel fitted to an RAO."""

    vessel: SecondOrderVessel  # with the natural frequency, damping and gain found
    # sqrt(integral (|H_fit| - |H|)^2 S / integral |H|^2 S) [-]: of the amplitude, weighted with the sea
    relative_error: float
    sigma_ratio: float  # standard deviation of heave by the fit over that by the RAO, in the sea [-]


@dataclass(frozen=True)
class VesselOnCourse:
    """A vessel with RAOs that meets the sea at one heading and speed."""

    rao_file: str  # table of RAOs, as `read_rao` takes it
    boom_tip_arm: tuple[float, ...]  # boom tip from the vessel's reference point [m], shape (3,)
    heading: float  # of the waves relative to the bow [rad]
    speed: float  # forward speed [m/s]
    accept_implausible: bool = False  # take implausible RAOs, as `read_rao` does

    def response(self, omega: Array) -> NDArray[np.complex128]:
        """Return boom-tip heave per wave amplitude at `omega` [rad/s], shape (n,); raise RaoError for a wrong file."""
        path = Path(self.rao_file)
        changed = path.stat().st_mtime_ns if self.rao_file and path.is_file() else 0
        frequency, motions = _on_course(self, changed)
        inside = np.clip(omega, frequency[0], frequency[-1])
        heave = lever_arm_matrix(np.array(self.boom_tip_arm))[2] @ between(frequency, motions, inside)
        return np.asarray(heave * above_the_table(omega, frequency[-1]))

    def fit(self, spectrum: WaveSpectrum) -> VesselFit:
        """Return the second-order vessel fitted to this one in a sea (`spectrum`); raise RaoError as `response`."""
        omega = np.linspace(0.4, 3.5, 200) * spectrum.peak_frequency
        return fit_vessel(omega, self.response(omega), spectrum)


@lru_cache(maxsize=16)
def _on_course(vessel: VesselOnCourse, changed: int) -> tuple[Array, ComplexArray]:  # noqa: ARG001
    """Return the frequencies of the table [rad/s], shape (f,), and the six motions per wave amplitude, shape (6, f).

    A design asks for it again and again, and the whole table takes a second to read and to turn to one heading.

    Parameters
    ----------
    vessel : and its course
    changed : when the file of RAOs was: a new file is read again
    """
    table = read_rao(vessel.rao_file, sorted({0.0, vessel.speed}), vessel.accept_implausible)
    return table.frequency, table.at(table.frequency, vessel.heading, vessel.speed)


def fit_vessel(omega: Array, response: NDArray[Any], spectrum: WaveSpectrum) -> VesselFit:
    """Fit natural frequency, damping and gain to amplitudes of an RAO, weighted with the sea's spectrum.

    Parameters
    ----------
    omega : [rad/s], shape (n,)
    response : |H| at these frequencies, or H, whose amplitude is taken
    spectrum : of the sea

    Phases are left out: seen from another point of the ship they differ by the wave's travel, which a causal filter
    cannot follow, and the spectrum of the motion does not depend on them. Raises RaoError when there is nothing to fit.
    """
    amplitude = np.abs(np.asarray(response))
    weight = np.sqrt(spectrum.density(omega) * np.gradient(omega))
    if omega.size < 6 or not np.isfinite(amplitude).all() or not (weight * amplitude > 0.0).any():
        raise RaoError("a fit needs at least 6 frequencies with finite responses where the sea has energy")
    norm = math.sqrt(float(((weight * amplitude) ** 2).sum()))

    def vessel(parameters: Array) -> SecondOrderVessel:
        natural, damping, gain = (float(value) for value in np.exp(parameters))
        return SecondOrderVessel(natural, damping, gain)

    def residual(parameters: Array) -> Array:
        return np.asarray(weight * (np.abs(vessel(parameters).response(omega)) - amplitude) / norm)

    bounds = (np.log([0.05, 0.02, 1e-3]), np.log([10.0, 5.0, 20.0]))
    starts = [
        np.log([natural * spectrum.peak_frequency, damping, max(1e-2, float(amplitude[0]))])
        for natural in (0.6, 1.0, 1.5)
        for damping in (0.2, 0.7)
    ]
    results = [scipy.optimize.least_squares(residual, np.clip(start, *bounds), bounds=bounds) for start in starts]
    best = min(results, key=lambda result: result.cost)
    fitted = vessel(best.x)
    ratio = float(np.abs(fitted.response(omega)) * weight @ (np.abs(fitted.response(omega)) * weight)) / norm**2
    return VesselFit(fitted, math.sqrt(2.0 * best.cost), math.sqrt(ratio))
