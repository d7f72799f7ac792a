"""NetCDF of the makers that `wavespectra` reads: each is known by its variables, and read to the sea it was made of."""

import json
import math
from datetime import datetime, timezone

import numpy as np
import pytest
from wave_vessel_node.sea.spectra import Bretschneider
from wave_vessel_node.sea.spectrum_files import SpectrumFileError, read_spectra

wavespectra = pytest.importorskip("wavespectra")
xarray = pytest.importorskip("xarray")

FREQUENCY, DIRECTION = np.arange(0.04, 0.4, 0.01), np.arange(0.0, 360.0, 30.0)
ONED = 2.0 * math.pi * Bretschneider(2.0, 9.0).density(2.0 * math.pi * FREQUENCY)
PER_DEGREE = np.repeat(ONED[None, :, None], DIRECTION.size, axis=2) / 360.0
"""Density of a sea of Hs 2 m and Tp 9 s, from all directions alike [m^2/Hz/deg], shape (1, f, d)."""
TIMES = np.array(["2024-01-01T00:00"], dtype="datetime64[ns]")


def dataset(name, density, dims, **coordinates):
    return xarray.Dataset({name: (dims, density)}, {"time": TIMES, **coordinates})


def own(density=PER_DEGREE, frequency=FREQUENCY, direction=DIRECTION):
    return dataset("efth", density, ("time", "freq", "dir"), freq=frequency, dir=direction)


def of_ww3(density=PER_DEGREE * 180.0 / math.pi):
    data = dataset(
        "efth",
        density[:, None],
        ("time", "station", "frequency", "direction"),
        frequency=FREQUENCY,
        direction=DIRECTION,
    )
    return data.assign(latitude=(("time", "station"), [[0.0]]), longitude=(("time", "station"), [[0.0]]))


def of_swan():
    return dataset(
        "density",
        PER_DEGREE[:, None] * 180.0 / math.pi,
        ("time", "points", "frequency", "direction"),
        frequency=FREQUENCY,
        direction=np.radians(DIRECTION),
    )


def of_era5():
    # ERA5's grid is its own: 30 frequencies from 0.03453 Hz on, each a tenth above the one before; log10 [m^2 s/rad]
    frequency = 0.03453 * 1.1 ** np.arange(30)
    oned = 2.0 * math.pi * Bretschneider(2.0, 9.0).density(2.0 * math.pi * frequency)
    density = np.repeat(oned[None, :, None], 24, axis=2) / (2.0 * math.pi)
    logarithm = np.where(density > 1e-9, np.log10(np.maximum(density, 1e-12)), np.nan)[..., None, None]
    return dataset(
        "d2fd",
        logarithm,
        ("time", "frequency", "direction", "latitude", "longitude"),
        frequency=np.arange(1, 31),
        direction=np.arange(1, 25),
        latitude=[50.0],
        longitude=[0.0],
    )


def of_ndbc():
    return dataset("spectral_wave_density", ONED[None], ("time", "frequency"), frequency=FREQUENCY)


def written(tmp_path, data, name="sea.nc"):
    path = tmp_path / name
    data.to_netcdf(path, engine="netcdf4")
    return path


@pytest.mark.parametrize("maker", [own, of_ww3, of_swan, of_era5, of_ndbc])
def test_the_file_of_each_maker_is_the_sea_it_was_made_from(tmp_path, maker):
    file = read_spectra(written(tmp_path, maker()))
    # the tail of f^-5 is that of Bretschneider; NDBC's has none, and lacks 2 % of the energy
    assert file.records[0].spectrum.significant_wave_height == pytest.approx(2.0, rel=0.02)
    assert file.records[0].spectrum.peak_period == pytest.approx(9.0, abs=0.5)
    assert file.records[0].time == datetime(2024, 1, 1, tzinfo=timezone.utc)


def ww3_station():
    """WAVEWATCH III's point output: frequencies, directions [rad], then a place and its densities [m^2/Hz/rad]."""
    rows = [f"'WAVEWATCH III SPECTRA' {FREQUENCY.size:5d} {DIRECTION.size:5d} {1:5d} 'points'"]
    rows += [" ".join(f"{one:.4E}" for one in FREQUENCY), " ".join(f"{one:.4E}" for one in np.radians(DIRECTION))]
    rows += ["20240101 000000", "'BUOY      '  50.00   0.00   100.0  10.0 270.0   0.0   0.0"]
    density = (PER_DEGREE[0] * 180.0 / math.pi).T  # over direction, then frequency
    return "\n".join([*rows, *(" ".join(f"{one:.6E}" for one in row) for row in density), ""]), "points.spec"


def triaxys():
    """A Triaxys report without directions: two columns, frequency and density."""
    head = (
        "TRIAXYS BUOY DATA REPORT\nVERSION = 5a.04.03\nTYPE     = NON-DIRECTIONAL SPECTRUM\n"
        f"DATE     = 2024 Jan 01 00:00 (UTC)\nNUMBER OF FREQUENCIES = {FREQUENCY.size}\n"
        "INITIAL FREQUENCY (Hz) = 0.040\nFREQUENCY SPACING (Hz) = 0.010\n"
        "COLUMN 1 = FREQUENCY (HZ)\nCOLUMN 2 = ENERGY (M^2/HZ)\n"
    ).replace("COLUMN 1 = FREQUENCY (HZ)\n", "")
    return head + "".join(f"{f:.3f} {s:.6E}\n" for f, s in zip(FREQUENCY, ONED, strict=True)), "report.NONDIRSPEC"


def spotter():
    """What Sofar's programming interface returns for a Spotter."""
    zeros = np.zeros(FREQUENCY.size).tolist()
    stamp = "2024-01-01T00:00:00.000Z"
    waves = {"significantWaveHeight": 2.0, "peakPeriod": 9.0, "timestamp": stamp, "latitude": 50.0, "longitude": 0.0}
    spectrum = {"frequency": FREQUENCY.tolist(), "varianceDensity": ONED.tolist(), "timestamp": stamp}
    spectrum |= dict.fromkeys(("direction", "directionalSpread", "a1", "b1", "a2", "b2"), zeros)
    return json.dumps({"data": {"spotterId": "SPOT-1", "waves": [waves], "frequencyData": [spectrum]}}), "spot.json"


def spotter_csv(more=""):
    """A Spotter's table of a day: the headings of Sofar's files, a record a row, `more` of them."""
    kinds = ("f", "df", "a1", "b1", "a2", "b2", "varianceDensity", "direction", "directionalSpread")
    first = "Battery Voltage (V),Power (W),Humidity (%rel),Epoch Time,Significant Wave Height (m),Peak Period (s)"
    names = [f"{kind}_{number}" for kind in kinds for number in range(FREQUENCY.size)]
    values = {"f": FREQUENCY, "df": np.gradient(FREQUENCY), "varianceDensity": ONED}
    numbers = [f"{x:.6g}" for kind in kinds for x in values.get(kind, np.zeros(FREQUENCY.size))]
    row = ",".join(["4.0", "0.1", "30", "1704067200", "2.0", "9.0", *numbers])
    return "\n".join([",".join([first, *names]), row, more]), "SPOT-1386.csv"


def spotter_csv_with_short_records():
    """As its memory card has them: between two spectra the heights alone, and a dash for each frequency."""
    gaps = ",".join("-" for _ in range(9 * FREQUENCY.size))
    return spotter_csv(f"4.0,0.1,30,1704069000,2.1,9.0,{gaps}\n")


def datawell():
    """A .spt file: twelve lines, then frequency, density over its largest, direction, spread, skewness, kurtosis."""
    head = [8, 200, 7.0, f"{ONED.max():.6f}", 20.0, 12.0, 7, 0.0, 0.0, 0.0, 0.0, 0.0]
    rows = [f"{f:.3f},{s / ONED.max():.6f},0,30,0,0" for f, s in zip(FREQUENCY, ONED, strict=True)]
    return "\n".join([*map(str, head), *rows, ""]), "buoy}2024-01-01T00h00Z.spt"


@pytest.mark.parametrize(
    "maker", [ww3_station, triaxys, spotter, spotter_csv, spotter_csv_with_short_records, datawell]
)
def test_the_text_of_each_maker_is_the_sea_it_was_made_from(tmp_path, maker):
    """Forms by the makers' manuals. What was measured has no tail, and lacks 2 % of the height's square."""
    text, name = maker()
    path = tmp_path / name
    path.write_text(text)
    file = read_spectra(path)
    assert file.records[0].spectrum.significant_wave_height == pytest.approx(2.0, rel=0.03)
    assert file.records[0].spectrum.peak_period == pytest.approx(9.0, abs=0.5)
    assert file.records[0].time == datetime(2024, 1, 1, tzinfo=timezone.utc)


def test_a_netcdf_file_is_known_by_its_first_bytes_not_by_its_name(tmp_path):
    assert len(read_spectra(written(tmp_path, own(), "sea.data")).records) == 1


@pytest.mark.parametrize(
    "direction",
    [
        (DIRECTION + 180.0) % 360.0,
        DIRECTION[::-1],
        np.append(DIRECTION, 360.0),
        np.append(DIRECTION, 360.0) - 180.0,
        np.array([0.0, 10.0, 40.0, 90.0, 150.0, 180.0, 240.0, 300.0]),
    ],
)
def test_the_directions_of_a_rose_are_summed_whatever_their_order(tmp_path, direction):
    density = np.repeat(PER_DEGREE[:, :, :1], direction.size, axis=2)
    (record,) = read_spectra(written(tmp_path, own(density, direction=direction))).records
    assert record.spectrum.significant_wave_height == pytest.approx(2.0, rel=0.02)


def test_a_record_with_missing_densities_is_repaired_or_left_out_by_name(tmp_path):
    hole, gone = PER_DEGREE.copy(), np.full_like(PER_DEGREE, np.nan)
    hole[0, 3] = np.nan
    two = xarray.concat([own(hole), own(gone).assign_coords(time=TIMES + np.timedelta64(1, "h"))], "time")
    file = read_spectra(written(tmp_path, two))
    assert file.records[0].spectrum.significant_wave_height == pytest.approx(2.0, rel=0.03)
    assert len(file.records) == 1
    assert any("record 1: 36 of 36 densities are missing" in warning for warning in file.warnings)


def test_frequencies_in_any_order_and_one_of_zero_are_understood(tmp_path):
    frequency, density = np.append(FREQUENCY, 0.0)[::-1], np.concatenate((PER_DEGREE, 0.0 * PER_DEGREE[:, :1]), 1)
    (record,) = read_spectra(written(tmp_path, own(density[:, ::-1], frequency))).records
    assert record.spectrum.significant_wave_height == pytest.approx(2.0, rel=0.02)


def test_a_height_that_the_file_itself_states_is_compared(tmp_path):
    swan = of_swan()
    right = swan.assign(hs=(("time", "points"), [[2.0]]))
    wrong = swan.assign(hs=(("time", "points"), [[2.0 * math.sqrt(180.0 / math.pi)]]))
    assert read_spectra(written(tmp_path, right, "right.nc")).warnings == ()
    (warning,) = read_spectra(written(tmp_path, wrong, "wrong.nc")).warnings
    assert "significant wave height of 2 m, the file states 15.1 m" in warning


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (own().rename(efth="q"), "no wave spectra of a known kind: its variables are dir, freq, q, time"),
        (xarray.Dataset(), "its variables are none"),
        (own(PER_DEGREE * np.nan), "no usable spectrum: skipped: record 0: 36 of 36 densities are missing"),
        (own(-PER_DEGREE), "is negative"),
        (own(57.3 * 57.3 * PER_DEGREE), "significant wave height is 11"),
        (own(57.3 * PER_DEGREE), "significant steepness is"),
        (own(frequency=2.0 * math.pi * FREQUENCY), "significant steepness is"),
        (own(PER_DEGREE[:, :, :1], direction=DIRECTION[:1]), "has 1 directions"),
    ],
)
def test_a_file_that_cannot_be_used_is_refused_in_one_line_with_its_name(tmp_path, data, says):
    with pytest.raises(SpectrumFileError, match=says) as refused:
        read_spectra(written(tmp_path, data))
    assert str(refused.value).startswith(str(tmp_path / "sea.nc"))
    assert "\n" not in str(refused.value)


def test_a_netcdf_file_that_is_broken_is_refused(tmp_path):
    (tmp_path / "x.nc").write_bytes(b"not netcdf")
    with pytest.raises(SpectrumFileError, match="wavespectra cannot read it"):
        read_spectra(tmp_path / "x.nc")
    whole = written(tmp_path, own()).read_bytes()
    for size in (10, 500, len(whole) // 2):
        (tmp_path / "cut.nc").write_bytes(whole[:size])
        with pytest.raises(SpectrumFileError, match=r"cut\.nc"):
            read_spectra(tmp_path / "cut.nc")


@pytest.mark.parametrize(
    ("maker", "variable", "share", "units"),
    [
        (of_ww3, "efth", math.pi / 180.0, "m2 s deg-1"),
        (of_swan, "density", math.pi / 180.0, "m2/Hz/degr"),
        (own, "efth", 180.0 / math.pi, "m^{2}.s.rad^{-1}"),
    ],
)
def test_the_unit_of_angle_that_a_file_states_is_used(tmp_path, maker, variable, share, units):
    data = maker()
    data[variable] = data[variable] * share
    data[variable].attrs["units"] = units
    file = read_spectra(written(tmp_path, data))
    assert file.records[0].spectrum.significant_wave_height == pytest.approx(2.0, rel=0.02)
    assert any("as their unit says" in warning for warning in file.warnings)


@pytest.mark.parametrize("form", ["NETCDF3_CLASSIC", "NETCDF3_64BIT"])
def test_a_classic_file_that_is_cut_is_refused_not_filled_with_zeros(tmp_path, form):
    path = tmp_path / "sea.nc"
    of_ww3().to_netcdf(path, engine="netcdf4", format=form)
    assert read_spectra(path).records[0].spectrum.significant_wave_height == pytest.approx(2.0, rel=0.02)
    path.write_bytes(path.read_bytes()[:-1500])
    with pytest.raises(SpectrumFileError, match=r"sea\.nc: is cut short or damaged"):
        read_spectra(path)
