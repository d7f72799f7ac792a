"""What a parameter may name, one line each: spectra of a sea, forms of the shaping filter, sources of motion.

The parameter's choices, its help and whoever builds the thing named all read its registry, so that one more spectrum,
say, is its own file and one line. Reading a registry loads nothing: parameters can be checked without the models that
they name. A spectrum's class has `from_parameters(SeaParameters) -> WaveSpectrum`. A filter form is a function of the
spectrum [WaveSpectrum] and the number of states, which returns a LinearModel with the output wave_elevation. A source's
module has `build(Scene) -> MotionSource`.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Entry:
    """One line of a registry."""

    location: str  # "module:name" of what builds the thing
    description: str  # a phrase for the help of the parameter

    def load(self) -> Any:
        """Return what is at the location. Raises ImportError or AttributeError where nothing does."""
        module, name = self.location.split(":")
        return getattr(importlib.import_module(module), name)


def describe_choices(registry: Mapping[str, Entry]) -> str:
    """Return names and descriptions of a `registry` as one phrase: `regular (a sine), file (a recording)`."""
    return ", ".join(f"{name} ({entry.description})" for name, entry in registry.items())


SPECTRA: dict[str, Entry] = {
    "bretschneider": Entry("wave_vessel_node.sea.spectra:Bretschneider", "two parameters, thesis Eq. 6.20"),
    "pierson_moskowitz": Entry(
        "wave_vessel_node.sea.spectra:PiersonMoskowitz", "fully developed: the height determines the period"
    ),
    "jonswap": Entry("wave_vessel_node.sea.spectra:Jonswap", "limited fetch, peak_enhancement"),
    "ochi_hubble": Entry("wave_vessel_node.sea.spectra:OchiHubble", "wind sea of given shape, and swell"),
}

NEED_NO_PERIOD = frozenset({"pierson_moskowitz"})
"""Spectra whose height determines their peak period."""

SPECTRUM_FILE = "file"
"""Value of `spectrum` that takes a measured spectrum from a file."""

FILTER_FORMS: dict[str, Entry] = {
    "thesis": Entry("wave_vessel_node.sea.shaping_filter:thesis_filter", "Eq. 6.22"),
    "four_state": Entry("wave_vessel_node.sea.shaping_filter:four_state_filter", "Bretschneider's, two zeros"),
    "six_state": Entry("wave_vessel_node.sea.shaping_filter:six_state_filter", "Bretschneider's, four zeros"),
    "fit": Entry("wave_vessel_node.sea.filter_fit:fitted_filter", "any spectrum, by least squares"),
}

AUTO = "auto"
"""Value of a filter's form that takes the best one for the spectrum."""


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
        "wave_vessel_node.sources.recording:build", "a recording", has_sea=False, check=_check_recording
    ),
}
