"""The files that a run reads, looked into before any node starts."""

from __future__ import annotations

from heave_node.parameters import ParameterError
from wave_vessel_node.parameters import WaveVesselParameters
from wave_vessel_node.source_registry import SOURCES

from heave_bringup.scenarios import Scenario


def check_files(scenario: Scenario) -> None:
    """Refuse files of sea and vessel that `wave_vessel` could not use in a `scenario`; nothing is read without files.

    Raises ParameterError with what is wrong in the file.
    """
    parameters: WaveVesselParameters = scenario.parameters["wave_vessel"]
    is_recording = parameters.boom_tip_source == "file"
    if not (is_recording or parameters.spectrum_file or parameters.vessel.rao_file):
        return
    from wave_vessel_node.sources.recording import read_recording  # noqa: PLC0415 (few runs need it)
    from wave_vessel_node.sources.scene import build_scene  # noqa: PLC0415

    try:
        if is_recording:
            read_recording(
                parameters.recording_file,
                parameters.recording_topic,
                accept_implausible=parameters.accept_implausible,
            )
        if SOURCES[parameters.boom_tip_source].has_sea:
            build_scene(parameters, scenario.run.seed, scenario.run.tick_period)
    except ValueError as error:
        raise ParameterError(f"{scenario.path}: wave_vessel: {error}") from error
