"""One line in a registry is all that a spectrum, a filter form or a motion source needs besides its own code."""

import math
import subprocess
import sys

import pytest
from heave_node.parameters import describe
from wave_vessel_node.component import WaveVessel
from wave_vessel_node.parameters import SeaParameters, WaveVesselParameters
from wave_vessel_node.registries import FILTER_FORMS, SPECTRA
from wave_vessel_node.sea.sea import named_spectrum
from wave_vessel_node.sea.shaping_filter import shaping_filter
from wave_vessel_node.sea.spectra import Bretschneider

CHOICES = {info.name: info.choices for info in describe(WaveVesselParameters)}


@pytest.mark.parametrize("name", list(SPECTRA))
def test_every_spectrum_has_the_height_that_the_parameters_ask_for(name):
    sea = SeaParameters(spectrum=name, significant_wave_height=2.0, peak_period=9.0)
    asked = math.hypot(2.0, sea.swell.significant_wave_height) if name == "ochi_hubble" else 2.0
    assert named_spectrum(sea).significant_wave_height == pytest.approx(asked, rel=1e-4)


@pytest.mark.parametrize("form", list(FILTER_FORMS))
def test_every_filter_form_gives_an_elevation(form):
    assert shaping_filter(Bretschneider(2.0, 9.0), form).output_names == ("wave_elevation",)


def test_a_line_more_is_a_choice_a_help_and_a_sea():
    program = """
from wave_vessel_node.registries import Entry
from wave_vessel_node.registries import SPECTRA
SPECTRA["own"] = Entry("wave_vessel_node.sea.spectra:Bretschneider", "for a test")
from heave_node.parameters import build_parameters, describe
from wave_vessel_node.component import WaveVessel
from wave_vessel_node.parameters import WaveVesselParameters
assert "own (for a test)" in {info.name: info.description for info in describe(WaveVesselParameters)}["spectrum"]
parameters = build_parameters(WaveVesselParameters, {"spectrum": "own"}, where="test")
print(WaveVessel(parameters, seed=1, tick_period=0.05).sea_state().spectrum)
"""
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert run.stdout == "own\n", run.stderr


def test_parameters_load_no_numerics():
    program = "import sys, wave_vessel_node.parameters; print(sorted({'numba', 'numpy', 'scipy'} & set(sys.modules)))"
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert run.stdout == "[]\n"


def test_a_sine_is_published_as_the_sea_of_its_variance():
    # amplitude 2 m: variance 2 m^2, 4 sigma = 4 sqrt(2) m
    parameters = WaveVesselParameters(boom_tip_source="regular", amplitude=(1.0, 0.0, -2.0), period=11.0)
    sea = WaveVessel(parameters, seed=1, tick_period=0.05).sea_state()
    assert (sea.spectrum, sea.peak_period, sea.peak_enhancement) == ("regular", 11.0, 1.0)
    assert sea.significant_wave_height == pytest.approx(4.0 * math.sqrt(2.0))
