"""The files that a run reads, looked into before any node starts."""

from __future__ import annotations

from heave_node.parameters import ParameterError
from wave_vessel_node.parameters import WaveVesselParameters
from wave_vessel_node.source_registry import SOURCES
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
            warnings += read_recording(
                parameters.recording_file,
                parameters.recording_topic,
                accept_implausible=parameters.accept_implausible,
            ).warnings
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
