"""The spectra that a sea can have, and the forms of the shaping filter that models it: one line each.

A spectrum's class has `from_parameters(SeaParameters) -> WaveSpectrum`. A filter form is a function of the spectrum
[WaveSpectrum] and the number of states, which returns a LinearModel with the output wave_elevation.
"""

from __future__ import annotations

from heave_node.registry import Entry

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
