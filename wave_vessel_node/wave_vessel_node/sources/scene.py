"""Everything that a source of motion is made of: sea, vessel, seed and time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.randomness import random_stream

from wave_vessel_node.parameters import WaveVesselParameters
from wave_vessel_node.registries import SOURCES
from wave_vessel_node.sea.realisation import WaveComponents, draw_components
from wave_vessel_node.sea.sea import build_spectrum
from wave_vessel_node.sea.spectra import WaveSpectrum
from wave_vessel_node.vessel.fit import VesselFit, VesselOnCourse
from wave_vessel_node.vessel.motion import lever_arm_matrix
from wave_vessel_node.vessel.rao import ResponseTable
from wave_vessel_node.vessel.rao_files import read_rao
from wave_vessel_node.vessel.second_order import SecondOrderVessel


@dataclass(frozen=True)
class Scene:
    """What the parameters describe, read and built once."""

    parameters: WaveVesselParameters  # as given
    seed: int  # of the sea
    tick_period: float  # [s]
    spectrum: WaveSpectrum | None  # of the sea; None for sources without one
    rao: ResponseTable | None  # of the vessel, where it moves by a table in a sea
    vessel_fit: VesselFit | None  # the second-order vessel fitted to a table, where the parameters ask for it
    warnings: list[str]  # what was repaired in the files read; sources add to it

    @property
    def vessel(self) -> SecondOrderVessel | None:
        """The second-order vessel; None where the boom tip follows the surface."""
        if self.vessel_fit is not None:
            return self.vessel_fit.vessel
        vessel = self.parameters.vessel
        if vessel.model == "direct":
            return None
        return SecondOrderVessel(vessel.natural_frequency, vessel.damping_ratio, vessel.gain)

    @property
    def boom_tip_arm(self) -> Array:
        """Boom tip from the point whose motion the source gives [m], shape (3,): zero but for a vessel with RAOs."""
        return np.zeros(3) if self.rao is None else np.array(self.parameters.vessel.boom_tip_arm)

    def components(self) -> WaveComponents:
        """Draw the components of the sea; the same at each call."""
        assert self.spectrum is not None
        return draw_components(
            self.spectrum,
            self.parameters.components,
            random_stream(self.seed, "wave_vessel/sea"),
            direction=self.parameters.direction,
            spreading_exponent=self.parameters.spreading.exponent,
        )

    def power_response(self, omega: Array) -> Array:
        """Return |H|^2 from the sea to boom-tip heave at `omega` [rad/s], at its heading and speed."""
        if self.rao is not None:
            course = self.parameters.course
            relative = np.full(omega.shape, self.parameters.direction - course.heading)
            response = self.rao.at(omega, relative, course.speed)
            return np.asarray(np.abs(lever_arm_matrix(self.boom_tip_arm)[2] @ response) ** 2)
        if self.spectrum is None or self.vessel is None:
            return np.ones_like(omega)
        return np.asarray(np.abs(self.vessel.response(omega)) ** 2)


def build_scene(parameters: WaveVesselParameters, seed: int, tick_period: float) -> Scene:
    """Read the files that the parameters name, and build sea and vessel.

    Parameters
    ----------
    parameters : of sea and vessel
    seed : of the sea
    tick_period : [s]

    Raises SpectrumError, SpectrumFileError or RaoError where the parameters name something that cannot be used.
    """
    warnings: list[str] = []
    has_sea = SOURCES[parameters.boom_tip_source].has_sea
    spectrum = build_spectrum(parameters, warnings) if has_sea else None
    return Scene(
        parameters=parameters,
        seed=seed,
        tick_period=tick_period,
        spectrum=spectrum,
        rao=_read_rao(parameters, warnings) if has_sea and parameters.vessel.model == "rao" else None,
        vessel_fit=_fit_vessel(parameters, spectrum) if spectrum and parameters.vessel.model == "fitted" else None,
        warnings=warnings,
    )


def _read_rao(parameters: WaveVesselParameters, warnings: list[str]) -> ResponseTable:
    """Read the table of RAOs at the speed of the vessel."""
    file, speed = parameters.vessel.rao_file, parameters.course.speed
    table = read_rao(file, sorted({0.0, speed}), parameters.accept_implausible)
    warnings.extend(table.warnings)
    if speed > table.speed[-1] + 1e-9:
        warnings.append(
            f"{file or 'shipped RAO'}: covers speeds up to {table.speed[-1]:g} m/s, but the course "
            f"reaches {speed:g} m/s: the responses at the highest speed are used"
        )
    return table


def _fit_vessel(parameters: WaveVesselParameters, spectrum: WaveSpectrum) -> VesselFit:
    """Fit the second-order vessel to the RAO of the boom tip, in this sea, at its heading and speed."""
    vessel, course = parameters.vessel, parameters.course
    heading = parameters.direction - course.heading
    on_course = VesselOnCourse(
        vessel.rao_file, vessel.boom_tip_arm, heading, course.speed, parameters.accept_implausible
    )
    return on_course.fit(spectrum)
