"""Public files of other makers, where they are at hand: below the folder that HEAVE_FOREIGN_FILES names.

A file is found by its name, anywhere below. The sample files of the library `wavespectra` lie in the folder
`tests/sample_files` of its repository; what they give is what that library and the files themselves state.
"""

import os
from pathlib import Path

import numpy as np
import pytest
from heave_bags.errors import BagError
from heave_devices.maps.channel import Channel
from heave_devices.maps.device_map import DeviceMap
from heave_devices.records.sea_import import import_sea
from wave_vessel_node.sea.spectrum_files import SpectrumFileError, read_spectra
from wave_vessel_node.vessel.rao import RaoError
from wave_vessel_node.vessel.rao_files import read_rao

FOLDER = os.environ.get("HEAVE_FOREIGN_FILES", "")
pytestmark = pytest.mark.skipif(not FOLDER, reason="HEAVE_FOREIGN_FILES names no folder of public files")


def found(name: str) -> Path:
    """Return the file of a `name`, such as `omega.nc` or `rao_units/mm.csv`; skip where there is none."""
    paths = [path for path in Path(FOLDER).rglob(Path(name).name) if path.match(name)]
    if not paths:
        pytest.skip(f"{name} is not below HEAVE_FOREIGN_FILES")
    return paths[0]


# significant wave height of the first record [m]: of the library with its tail, or of the file's own table
@pytest.mark.parametrize(
    ("name", "height"),
    [
        ("ww3file.nc", 0.755),
        ("wavespectra.nc", 0.755),
        ("era5file.nc", 4.605),
        ("swanfile.nc", 0.208),
        ("swanfile.spec", 1.719),
        ("41010w2019part.txt.gz", 1.90),
        ("42098w9999.nc", 0.178),
    ],
)
def test_spectra_have_the_height_that_their_makers_state(name, height):
    if not name.endswith(".gz"):
        pytest.importorskip("wavespectra")
    record = read_spectra(found(name)).records[0]
    # half a per cent: trapezia here, rectangles there
    assert record.spectrum.significant_wave_height == pytest.approx(height, rel=0.006)


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("41010d2019part.txt.gz", "directions or r1, r2"),
        ("41010i2019part.txt.gz", "significant wave height is"),
        ("41010j2019part.txt.gz", "directions or r1, r2"),
        ("41010k2019part.txt.gz", "directions or r1, r2"),
        ("41010.swdir", "holds alpha1_1, not densities"),
        ("41010.swr1", "holds r1_1, not densities"),
        ("41010.spec", "heights and periods, not spectra"),
        ("not_density.txt", "implausible record"),
    ],
)
def test_what_has_the_form_of_spectra_and_is_none_is_refused(name, says):
    with pytest.raises(SpectrumFileError, match=says):
        read_spectra(found(name))


@pytest.mark.parametrize("name", ["omega_inf.nc", "period.nc"])
def test_a_capytaine_database_over_anything_gives_the_same_table(name):
    pytest.importorskip("netCDF4")
    plain, other = read_rao(found("omega.nc")), read_rao(found(name))
    np.testing.assert_allclose(other.response, plain.response, rtol=1e-9, atol=1e-12)
    assert bool(other.warnings) == (name == "omega_inf.nc")


def test_a_database_with_holes_gives_the_frequencies_it_has():
    pytest.importorskip("netCDF4")
    table = read_rao(found("shallow.nc"))
    assert table.frequency[0] == pytest.approx(0.2)
    assert "frequencies 0.02, 0.05 rad/s left out" in table.warnings[0]


def test_a_table_saved_by_a_spreadsheet_is_the_table():
    right, saved = read_rao(found("right.csv")), read_rao(found("bom.csv"))
    np.testing.assert_array_equal(saved.response, right.response)
    assert right.warnings == ()


@pytest.mark.parametrize(
    ("name", "says"), [("mm.csv", "millimetres"), ("phase_deg.csv", "degrees"), ("roll_deg.csv", "degrees")]
)
def test_a_table_in_other_units_is_refused(name, says):
    with pytest.raises(RaoError, match=says):
        read_rao(found(name))


# heave of 1 m at 8 s and 0.3 m at 6.1 s: four standard deviations are 2.953 m
@pytest.mark.parametrize(
    ("name", "column", "duration", "says"),
    [
        ("hhmmss.csv", "heave", 899.9, "hhmmss"),
        ("latin1.csv", "heave [m]", 899.9, "Latin-1"),
        ("sod.csv", "heave", 899.9, "passes midnight once"),
        ("spaces.txt", "heave", 899.9, "spaces"),
        ("sentinel.csv", "heave", 595.9, "39 samples of -9999"),
        ("stuck.csv", "heave", 300.0, "stands still"),
    ],
)
def test_logs_of_motion_units_give_the_motion_they_hold(name, column, duration, says):
    sea = import_sea(found(f"mru_logs/{name}"), DeviceMap({"heave": Channel(column=column)}))
    assert sea.time[-1] == pytest.approx(duration, abs=0.2)
    assert 4.0 * sea.position[:, 2].std() == pytest.approx(2.953, rel=0.02)
    assert any(says in note for note in sea.notes)


def test_a_log_in_centimetres_is_refused():
    with pytest.raises(BagError, match="heave_cm is in cm by its heading"):
        import_sea(found("mru_logs/cm.csv"), DeviceMap({"heave": Channel(column="heave_cm")}))
