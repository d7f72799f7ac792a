"""What a run is refused for before any node starts: files, design, rest, and the sea, depth and boom tip on which
vessel and plant must agree.
"""

from __future__ import annotations

import math

import numpy as np
from cable_sim_node.component import NO_COMPONENTS
from cable_sim_node.errors import PlantError
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.node_parameters import CableSimNodeParameters
from cable_sim_node.parameters import CableSimParameters
from cable_sim_node.physics.tension_law import overstrained_words
from cable_sim_node.vertical.axial_line import axial_line
from heave_node.numerics.constants import STANDARD_GRAVITY
from heave_node.parameters import ParameterError
from wave_vessel_node.component import WaveVessel
from wave_vessel_node.parameters import WaveVesselParameters
from wave_vessel_node.registries import NEED_NO_PERIOD, SOURCES, SPECTRUM_FILE
from winch_controller_node.design.design import check_inputs
from winch_controller_node.model.lqr import DesignError
from winch_controller_node.parameters.model import VesselModelParameters

from heave_bringup.scenarios import Scenario


def check_files(scenario: Scenario) -> list[str]:
    """Refuse files of sea and vessel that `wave_vessel` could not use in a `scenario`; return what it leaves out.

    Nothing is read without files. Raises ParameterError with what is wrong in the file.
    """
    parameters: WaveVesselParameters = scenario.parameters["wave_vessel"]
    is_recording = parameters.boom_tip_source == "file"
    if not (is_recording or parameters.spectrum_file or parameters.vessel.rao_file):
        return []
    from wave_vessel_node.sources.recording import read_recording  # noqa: PLC0415 (few runs need it)
    from wave_vessel_node.sources.scene import build_scene  # noqa: PLC0415

    warnings: list[str] = []
    try:
        if is_recording:
            recording = read_recording(parameters.recording_file, accept_implausible=parameters.accept_implausible)
            warnings += recording.warnings
        if SOURCES[parameters.boom_tip_source].has_sea:
            warnings += build_scene(parameters, scenario.run.seed, scenario.run.tick_period).warnings
    except ValueError as error:
        raise ParameterError(f"{scenario.path}: wave_vessel: {error}") from error
    return warnings


def vessel_warnings(scenario: Scenario) -> list[str]:
    """Return what is left out of the RAOs that the controller of a `scenario` is designed with; raise RaoError."""
    vessel: VesselModelParameters = scenario.parameters["winch_controller"].vessel
    if not vessel.rao_file:
        return []
    from wave_vessel_node.vessel.rao_files import read_rao  # noqa: PLC0415 (few runs need it)

    return list(read_rao(vessel.rao_file, sorted({0.0, vessel.speed}), vessel.accept_implausible).warnings)


def check_design(scenario: Scenario) -> None:
    """Refuse a load that floats, sensors that do not suffice, or a delay beyond prediction in a `scenario` that moves
    the winch, as the controller would once it runs.

    Raises ParameterError with the cause.
    """
    if scenario.moves_winch:
        try:
            check_inputs(scenario.parameters["winch_controller"], scenario.run.tick_period)
        except DesignError as error:
            raise ParameterError(f"{scenario.path}: winch_controller: {error}") from error


def check_rest(scenario: Scenario) -> None:
    """Refuse a cable that would part under its own load in a `scenario`, or whose tension law does not carry it, a
    unit that floats up, and a seabed that leaves no room.

    Raises ParameterError with the cause.
    """
    plant: CableSimParameters = scenario.parameters["cable_sim"]
    try:
        height = scenario.parameters["wave_vessel"].boom_tip_height
        strain = axial_line(plant, height).static_strain(plant.length)
        floats = plant.unit.weight_in_fluid(plant.water_density, plant.gravity) < 0.0
        if floats or plant.seabed.depth > 0.0:  # only a solver knows where it rests
            CableDynamics(plant).start_at_equilibrium(np.array([0.0, 0.0, height]))
    except PlantError as error:
        raise ParameterError(f"{scenario.path}: cable_sim: {error}") from error
    words = overstrained_words(strain, plant.cable.axial_stiffness)
    if words:
        raise ParameterError(f"{scenario.path}: cable_sim: {words}")


_HIGHEST_OF_DEPTH = 0.78
"""Largest height of a wave as a share of the depth in which it breaks (McCowan 1894; DNV-RP-C205, 3.4.6)."""


def check_waves(scenario: Scenario) -> list[str]:
    """Refuse a `scenario` whose sea cannot act on cable and unit, or whose boom tip stands at two heights.

    Returns what its depth makes of the waves, in words. Raises ParameterError with the cause.
    """
    plant: CableSimNodeParameters = scenario.parameters["cable_sim"]
    vessel: WaveVesselParameters = scenario.parameters["wave_vessel"]
    heights = (plant.boom_tip_height, vessel.boom_tip_height)
    if heights[0] != heights[1]:
        raise ParameterError(
            f"{scenario.path}: boom_tip_height is {heights[0]:g} m in cable_sim and {heights[1]:g} m in wave_vessel: "
            "set system.boom_tip_height, which both take"
        )
    if plant.wave.source == "sea":
        sea = WaveVessel(vessel, seed=scenario.run.seed, tick_period=scenario.run.tick_period)
        if not len(sea.waves().frequency):
            raise ParameterError(f"{scenario.path}: cable_sim: {NO_COMPONENTS}")
    return _of_depth(scenario, plant, vessel)


def _of_depth(scenario: Scenario, plant: CableSimNodeParameters, vessel: WaveVesselParameters) -> list[str]:
    """Refuse waves that break by the depth of the seabed; return that they feel it where they act on the unit."""
    depth, wave = plant.seabed.depth, plant.wave
    warnings: list[str] = []
    has_sea = SOURCES[vessel.boom_tip_source].has_sea and vessel.spectrum not in (SPECTRUM_FILE, *NEED_NO_PERIOD)
    seas = [("sea", vessel.significant_wave_height, vessel.peak_period)] if has_sea else []
    seas += [("regular", 2.0 * wave.amplitude, wave.period)] if wave.source == "regular" else []
    for source, height, period in seas if depth > 0.0 else ():
        if height > _HIGHEST_OF_DEPTH * depth:
            raise ParameterError(
                f"{scenario.path}: waves of {height:g} m break in seabed.depth = {depth:g} m: they are at most "
                f"{_HIGHEST_OF_DEPTH:g} of it"
            )
        length = STANDARD_GRAVITY * period**2 / (2.0 * math.pi)
        if wave.source == source and depth < 0.5 * length:
            warnings.append(
                f"cable_sim: the waves on cable and unit are those of deep water, but seabed.depth = {depth:g} m is "
                f"less than half of their length of {length:.3g} m"
            )
    return warnings
