"""The sources of the vessel's motion: one line each, with what the rest must know of a source.

A source's module has `build(Scene) -> MotionSource`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from heave_node.registry import Entry


def _check_nothing(_: Any) -> None:
    """Take any parameters."""


def _check_filter(parameters: Any) -> None:
    if parameters.vessel.model == "rao":
        raise ValueError("boom_tip_source = filter needs vessel.model second_order, fitted or direct, not rao")
    if parameters.vessel.pitch_gain > 0.0:
        raise ValueError("vessel.pitch_gain needs boom_tip_source = spectrum: filtered noise has no wave slope")


def _check_recording(parameters: Any) -> None:
    if not parameters.recording_file:
        raise ValueError("boom_tip_source = file needs recording_file: name the CSV file or the bag")


@dataclass(frozen=True)
class SourceEntry(Entry):
    """A motion source."""

    has_sea: bool  # a sea with a spectrum moves the vessel: it has a course, and a response to waves
    # raises ValueError where the other parameters, those of `WaveVesselParameters`, contradict this source
    check: Callable[[Any], None] = _check_nothing


SOURCES: dict[str, SourceEntry] = {
    "spectrum": SourceEntry("wave_vessel_node.sources.components:build", "sum of components", has_sea=True),
    "filter": SourceEntry(
        "wave_vessel_node.sources.filtered:build", "shaped white noise", has_sea=True, check=_check_filter
    ),
    "regular": SourceEntry("wave_vessel_node.sources.regular:build", "a sine", has_sea=False),
    "file": SourceEntry(
        "wave_vessel_node.sources.recorded:build", "a recording", has_sea=False, check=_check_recording
    ),
}
