import gzip
import math
from datetime import datetime, timezone
from pathlib import Path

import numpy as np
import pytest
from wave_vessel_node.parameters import WaveVesselParameters
from wave_vessel_node.sea.sea import build_spectrum
from wave_vessel_node.sea.spectra import Bretschneider
from wave_vessel_node.sea.spectrum_files import SpectrumFileError, read_spectra

DATA = Path(__file__).parent / "data"
REAL_TIME, HISTORICAL = DATA / "real_time.data_spec", DATA / "historical.txt"
MEASURED = Path(__file__).parents[2].parent / "shared" / "data" / "waves"


def write(tmp_path, text, name="spectra.txt"):
    path = tmp_path / name
    path.write_text(text)
    return path


def edited(tmp_path, source, line, edit):
    """Return a copy of `source` with one line (from 1) changed."""
    lines = source.read_text().splitlines()
    lines[line - 1] = edit(lines[line - 1])
    return write(tmp_path, "\n".join(lines) + "\n")


def test_the_real_time_format_is_read_in_order_of_time():
    # the sample file was made from Bretschneider spectra: 2.4 m 10 s is the oldest, 2 m 9 s the newest
    file = read_spectra(REAL_TIME)
    assert [record.time.hour for record in file.records] == [2, 3, 4, 5]
    assert file.records[-1].time == datetime(2024, 3, 1, 5, 40, tzinfo=timezone.utc)
    assert file.warnings == ()
    assert file.records[-1].spectrum.significant_wave_height == pytest.approx(2.0, rel=0.02)
    assert file.records[0].spectrum.peak_period == pytest.approx(10.0, abs=0.3)


def test_densities_per_hertz_become_densities_per_radian():
    spectrum = read_spectra(REAL_TIME).records[-1].spectrum
    omega = 2 * math.pi * 0.11
    assert spectrum.density(omega) == pytest.approx(Bretschneider(2.0, 9.0).density(omega), abs=1e-3)


def test_the_historical_format_is_read_and_a_row_of_fill_values_is_left_out_by_name():
    file = read_spectra(HISTORICAL)
    assert [record.time.hour for record in file.records] == [0, 1, 3]
    assert file.records[0].time.year == 1997
    assert len(file.warnings) == 1
    assert "missing" in file.warnings[0]
    assert "first on line 4" in file.warnings[0]


def test_a_compressed_file_is_read(tmp_path):
    path = tmp_path / "w.txt.gz"
    path.write_bytes(gzip.compress(HISTORICAL.read_bytes()))
    assert len(read_spectra(path).records) == 3


def test_one_fill_value_is_bridged_and_said(tmp_path):
    path = edited(tmp_path, HISTORICAL, 2, lambda line: " ".join([*line.split()[:20], "99.00", *line.split()[21:]]))
    with_fill = read_spectra(path)
    assert len(with_fill.records) == 3
    assert any("filled from its neighbours" in warning for warning in with_fill.warnings)
    assert with_fill.records[0].spectrum.significant_wave_height == pytest.approx(3.0, rel=0.05)


def test_nan_counts_as_missing(tmp_path):
    def without_one(line):
        fields = line.split()
        fields[fields.index("(0.110)") - 1] = "NaN"
        return " ".join(fields)

    file = read_spectra(edited(tmp_path, REAL_TIME, 2, without_one))
    assert len(file.records) == 4
    assert "filled from its neighbours" in file.warnings[0]
    assert np.isfinite(file.records[-1].spectrum.density(np.linspace(0.2, 3.0, 200))).all()


def test_a_record_with_negative_density_is_left_out_by_name(tmp_path):
    path = edited(tmp_path, HISTORICAL, 2, lambda line: line.rsplit(maxsplit=1)[0] + " -1.00")
    file = read_spectra(path)
    assert len(file.records) == 2
    assert any("negative density" in warning and "line 2" in warning for warning in file.warnings)


def test_a_record_cut_short_is_left_out_by_name(tmp_path):
    for source in (REAL_TIME, HISTORICAL):
        lines = source.read_text().splitlines()
        cut = write(tmp_path, "\n".join([*lines[:-1], lines[-1][: len(lines[-1]) // 2]]))
        file = read_spectra(cut)
        assert len(file.records) == len(read_spectra(source).records) - 1
        assert any("skipped" in warning and f"line {len(lines)}" in warning for warning in file.warnings)


def test_two_records_of_one_time_are_one(tmp_path):
    lines = REAL_TIME.read_text().splitlines()
    file = read_spectra(write(tmp_path, "\n".join([*lines, lines[1]])))
    assert len(file.records) == 4
    assert "second record with the same time" in file.warnings[0]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "has 0 lines"),
        ("#YY  MM DD hh mm Sep_Freq  < spec_1 (freq_1) >\n", "has 1 lines"),
        ("time,hs\n1,2\n", "line 1: expected an NDBC header"),
        ("YY MM DD hh .03 .04\n97 01 01 00 1.0 2.0\n", "at least 3 frequencies"),
        ("YY MM DD hh .03 .05 .04\n97 01 01 00 1.0 2.0 1.0\n", "strictly increasing"),
        ("YY MM DD hh .03 .04 .05\n97 13 01 00 1.0 2.0 1.0\n", "line 2: '97 13 01 00' is not a date"),
        ("YY MM DD hh .03 .04 .05\n97 01 01 00 1.0 0.0a47 1.0\n", "line 2: '0.0a47' is not a number"),
        ("YY MM DD hh .03 .04 .05\n97 01 01 00 0.0 0.0 0.0\n", "no usable spectrum"),
        ("YY MM DD hh .03 .04 .05\n97 01 01 00 999.0 999.0 999.0\n", "no usable spectrum"),
        (
            "#YY  MM DD hh mm alpha1_1 (freq_1) alpha1_2 (freq_2) ... >\n2020 06 08 03 50 36.0 (0.033) 52.0 (0.038)\n",
            "holds alpha1_1, not densities",
        ),
        (
            "#YY  MM DD hh mm r1_1 (freq_1) r1_2 (freq_2) ... >\n2020 06 08 03 50 0.37 (0.033) 0.19 (0.038)\n",
            "holds r1_1, not densities",
        ),
        ("#YY  MM DD hh mm WVHT  SwH  SwP\n#yr  mo dy hr mn m m sec\n2020 06 08 03 40 1.1 1.0 5.6\n", "not spectra"),
    ],
)
def test_a_file_that_cannot_be_used_is_refused_in_one_line(tmp_path, text, says):
    with pytest.raises(SpectrumFileError, match=says) as error:
        read_spectra(write(tmp_path, text))
    assert "\n" not in str(error.value)
    assert "spectra.txt" in str(error.value)


def test_a_missing_file_a_binary_one_and_a_broken_archive_are_refused(tmp_path):
    with pytest.raises(SpectrumFileError, match="no such file"):
        read_spectra(tmp_path / "none.txt")
    (tmp_path / "b.txt").write_bytes(bytes(range(256)))
    with pytest.raises(SpectrumFileError, match="not a text file"):
        read_spectra(tmp_path / "b.txt")
    (tmp_path / "c.txt.gz").write_bytes(gzip.compress(HISTORICAL.read_bytes())[:200])
    with pytest.raises(SpectrumFileError, match="cannot be read to its end"):
        read_spectra(tmp_path / "c.txt.gz")


def test_the_sea_is_the_first_record_of_its_file_or_that_of_its_time():
    file, named = read_spectra(REAL_TIME), {"spectrum": "file", "spectrum_file": str(REAL_TIME)}
    for record, time in ((file.records[0], ""), (file.records[2], file.records[2].time.isoformat())):
        found = build_spectrum(WaveVesselParameters(**named, spectrum_time=time), [])
        assert found.significant_wave_height == record.spectrum.significant_wave_height


def test_a_record_is_found_by_its_time():
    file = read_spectra(REAL_TIME)
    assert file.nearest("2024-03-01T04:20").time.hour == 4
    assert file.nearest("2024-03-01T06:20+02:00").time.hour == 4
    with pytest.raises(SpectrumFileError, match="no record within a day of 2025-01-01: the file covers 2024-03-01"):
        file.nearest("2025-01-01")
    with pytest.raises(SpectrumFileError, match="'noon' is not a time"):
        file.nearest("noon")


def test_the_newer_historical_header_with_minutes_is_read(tmp_path):
    text = "#YY  MM DD hh mm   .0500  .1000  .2000  .3000\n2010 05 01 12 30 0.00 4.00 1.00 0.20\n"
    record = read_spectra(write(tmp_path, text)).records[0]
    assert record.time == datetime(2010, 5, 1, 12, 30, tzinfo=timezone.utc)
    # trapezium over 0.05, 0.1, 0.2, 0.3 Hz: 0.1 + 0.25 + 0.06 m^2
    assert record.spectrum.moment(0) == pytest.approx(0.41, rel=1e-9)


@pytest.mark.skipif(not MEASURED.is_dir(), reason=f"the measured files are not beside the checkout ({MEASURED})")
@pytest.mark.parametrize(
    ("name", "count", "warnings"),
    [
        ("ndbc_41010.data_spec", 149, ""),
        pytest.param("ndbc_46042w1996.txt.gz", 8600, "112 times", marks=pytest.mark.long),
    ],
    ids=["atlantic", "pacific"],
)
def test_the_measured_files_of_two_buoys_are_read(name, count, warnings):
    # counts as in the files: 149 rows; 8712 rows of which 112 are fill values
    file = read_spectra(MEASURED / name)
    assert len(file.records) == count
    assert warnings in " ".join(file.warnings)
    heights = [record.spectrum.significant_wave_height for record in file.records[:200]]
    assert min(heights) > 0.3
    assert max(heights) < 12.0


GRID = np.concatenate(([0.02], np.arange(0.03, 0.485, 0.005)))
"""Frequencies of a historical file [Hz]."""


def historical(tmp_path, values, name="spectra.txt"):
    """Write a historical file with one record."""
    header = "#YY  MM DD hh mm " + " ".join(f"{f:.4f}" for f in GRID)
    return write(tmp_path, f"{header}\n2019 02 06 00 40 {' '.join(f'{v:g}' for v in values)}\n", name)


@pytest.mark.parametrize(
    ("values", "says"),
    [
        # mean directions [deg] and 100 r1: the same form as densities, as in NDBC's files d, i and j, k
        (140.0 + 100.0 * np.cos(40.0 * GRID), "significant wave height is"),
        (60.0 + 25.0 * np.sin(10.0 * GRID), "significant steepness is .*: directions or r1, r2"),
        # a sea of 2 m and 8 s in cm^2/Hz
        (
            1e4 * 2.0 * math.pi * Bretschneider(2.0, 8.0).density(2.0 * math.pi * GRID),
            r"significant wave height is (19\d|200)\b",
        ),
        (1e2 * 2.0 * math.pi * Bretschneider(2.0, 8.0).density(2.0 * math.pi * GRID), "significant steepness is"),
    ],
)
def test_figures_that_are_no_densities_are_refused_unless_they_are_accepted(tmp_path, values, says):
    path = historical(tmp_path, values)
    with pytest.raises(SpectrumFileError, match=says) as refused:
        read_spectra(path)
    assert "--set system.accept_implausible=true takes" in str(refused.value)
    assert "\n" not in str(refused.value)
    (warning,) = read_spectra(path, accept_implausible=True).warnings
    assert "implausible record kept (1 times, first on line 2" in warning


def test_one_record_that_cannot_be_a_sea_is_left_out_by_name(tmp_path):
    path = edited(
        tmp_path, HISTORICAL, 2, lambda line: " ".join([*line.split()[:4], *["160.0"] * (len(line.split()) - 4)])
    )
    file = read_spectra(path)
    assert len(file.records) == 2
    assert any("implausible record skipped (1 times, first on line 2: " in warning for warning in file.warnings)


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16"])
def test_a_file_saved_by_another_editor_is_read(tmp_path, encoding):
    path = tmp_path / "saved.txt"
    path.write_bytes(HISTORICAL.read_text().encode(encoding))
    saved, plain = (read_spectra(file).records[0].spectrum for file in (path, HISTORICAL))
    assert saved.significant_wave_height == pytest.approx(plain.significant_wave_height)
