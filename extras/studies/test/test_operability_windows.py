"""The seas of a place and a time from a file, and which of them are workable."""

from __future__ import annotations

import gzip
import math

import numpy as np
import pandas
import pytest
from heave_node.parameters import ParameterError
from heave_studies.operability.seas import SeaRecord, read_record, workable_share
from wave_vessel_node.sea.spectra import Bretschneider

NDBC = """YY MM DD hh   .050   .075   .100   .125   .150   .200
96 01 01 00    .10   1.00   8.00   2.00   1.00    .50
96 01 01 01    .10   1.00   8.00   2.00   1.00    .50
96 01 01 02  99.00  99.00  99.00  99.00  99.00  99.00
96 01 01 03    .40   4.00  32.00   8.00   4.00   2.00
"""


def test_heights_and_periods_of_a_record_of_spectra_are_theirs(tmp_path):
    path = tmp_path / "own.txt.gz"
    path.write_bytes(gzip.compress(NDBC.encode()))
    record = read_record(path)
    assert record.step == 1.0
    assert record.states["hs"].isna().tolist() == [False, False, True, False]
    # four times the density is twice the height; the peak is at 0.1 Hz
    assert record.states["hs"].iloc[3] == pytest.approx(2.0 * record.states["hs"].iloc[0])
    # trapezoidal rule by hand: m0 = 0.025 (0.55 + 4.5 + 5 + 1.5) + 0.05 0.75
    assert record.states["hs"].iloc[0] == pytest.approx(4.0 * np.sqrt(11.55 / 40 + 0.0375), rel=0.01)
    assert record.states["tp"].iloc[0] == pytest.approx(10.0, rel=0.05)


def test_heights_and_periods_of_a_hindcast_that_wavespectra_reads_are_theirs(tmp_path):
    wavespectra = pytest.importorskip("wavespectra")
    xarray = pytest.importorskip("xarray")
    frequency, direction = np.arange(0.04, 0.4, 0.01), np.arange(0.0, 360.0, 30.0)
    times = pandas.date_range("2024-01-01", periods=4, freq="3h")
    heights, periods = np.array([1.0, 2.0, 3.0, 2.0]), np.array([8.0, 10.0, 12.5, 10.0])
    oned = [
        2.0 * np.pi * Bretschneider(hs, tp).density(2.0 * np.pi * frequency)
        for hs, tp in zip(heights, periods, strict=True)
    ]
    density = np.repeat(np.array(oned)[:, :, None], direction.size, axis=2) / 360.0
    data = xarray.DataArray(density, {"time": times, "freq": frequency, "dir": direction}, ("time", "freq", "dir"))
    assert wavespectra.SpecDataset is not None
    data.to_dataset(name="efth").spec.to_netcdf(str(tmp_path / "hindcast.nc"))
    record = read_record(tmp_path / "hindcast.nc")
    assert record.step == 3.0
    assert not record.states.isna().any(axis=None)
    np.testing.assert_allclose(record.states["hs"], heights, rtol=0.04)  # what lies beyond 0.4 Hz is not in the file
    np.testing.assert_allclose(record.states["tp"], periods, rtol=0.05)


CURVE = pandas.DataFrame({"period": [6.0, 10.0], "limit": [1.0, 3.0], "lower": [0.5, 2.0], "upper": [1.5, 4.0]})


def test_the_share_of_workable_seas_is_counted_on_the_curve():
    counts = np.array([10, 10, 20, 20, 20, 10, 10])
    heights, periods = [0.8, 0.8, 1.9, 1.9, 1.9, 2.9, 2.9], [4.0, 8.0, 4.0, 8.0, 12.0, 8.0, 12.0]
    record = SeaRecord("seas", pandas.DataFrame({"hs": heights, "tp": periods, "share": counts / 100.0}), math.nan)
    # limits 1 m at 4 s (held), 2 m at 8 s, 3 m at 12 s (held): workable are 10, 10 + 20, 20 + 10 of 100
    assert workable_share(record, CURVE) == pytest.approx(0.7)
    # lower: 0.5, 1.25, 2: 0, 10, 20
    assert workable_share(record, CURVE, "lower") == pytest.approx(0.3)


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.csv", "time,height\n1,2\n", "must have the columns time, hs, tp, not time, height"),
        ("a.csv", "time,hs,tp\nyesterday,1,8\n", "a.csv: "),
        ("a.csv", "time,hs,tp\n2001-01-01,1,8\n", "holds 1 sea states with a height and a period: too few"),
        ("a.csv", "", "is not CSV"),
        ("a.csv", "time,hs,tp\n01.06.2025 00:00,1,8\n01.06.2025 03:00,1,8\n", "'01.06.2025 00:00' is not a time as in"),
        ("a.txt", "no spectra\n", "a.txt"),
    ],
)
def test_what_is_no_record_is_refused_in_one_line(tmp_path, name, text, words):
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(ParameterError) as error:
        read_record(path)
    assert words in str(error.value)
    assert "\n" not in str(error.value)
