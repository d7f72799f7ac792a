"""Weather windows and the seas of a place, against an independent program and by cases with an exact answer."""

from __future__ import annotations

import gzip

import numpy as np
import pandas
import pytest
from heave_node.parameters import ParameterError
from heave_studies.operability.seas import (
    beyond_the_grid,
    monthly_share,
    read_record,
    waiting_by_month,
    waiting_times,
    window_starts,
    workable,
    workable_share,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from wave_vessel_node.sea.spectra import Bretschneider

HOURS = 24 * 365
PEER = {
    # metocean-stats 1.2.0, stats.general.weather_window_length(series, 2.0, hours, 1, month): mean, P10, P50, P90 of
    # waiting time and window together [days]
    (6, "all"): (1.2331762802208261, 0.25, 0.5, 3.5),
    (6, "3"): (2.832941308243728, 0.5416666666666666, 2.8333333333333335, 5.041666666666667),
    (6, "8"): (0.36816756272401435, 0.25, 0.25, 0.7916666666666666),
    (6, "11"): (0.35532407407407407, 0.25, 0.25, 0.712500000000001),
    (24, "all"): (25.146245850978598, 1.0, 2.75, 95.55833333333335),
    (24, "3"): (82.72916666666667, 70.34583333333333, 82.72916666666666, 95.1125),
    (24, "8"): (1.6286962365591398, 1.0, 1.0, 3.0833333333333335),
    (24, "11"): (1.636689814814815, 1.0, 1.0, 3.1666666666666665),
}


def year() -> pandas.Series:
    """Return a year of hourly wave heights, of three sines."""
    i = np.arange(HOURS)
    heights = 2.0 + 1.1 * np.sin(2 * np.pi * i / 8760.0) + 0.9 * np.sin(2 * np.pi * i / 131.0)
    heights += 0.5 * np.sin(2 * np.pi * i / 37.0 + 1.0)
    return pandas.Series(heights, index=pandas.date_range("2001-01-01", periods=HOURS, freq="h"))


@pytest.mark.parametrize("hours", [6, 24])
def test_waiting_times_are_those_of_metocean_stats(hours):
    heights = year()
    table = waiting_by_month(pandas.DatetimeIndex(heights.index), (heights < 2.0).to_numpy(), 1.0, hours)
    for (window, month), expected in PEER.items():
        if window == hours:
            found = (table.loc[month, ["mean", "p10", "p50", "p90"]].to_numpy(dtype=float) + hours) / 24.0
            np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_waiting_ends_at_the_first_hour_of_the_next_window():
    flags = np.array([0, 1, 1, 0, 1, 1, 1, 0], dtype=bool)
    assert window_starts(flags, 3).tolist() == [False, False, False, False, True, False, False, False]
    np.testing.assert_array_equal(waiting_times(flags, 0.5, 1.5), [2.0, 1.5, 1.0, 0.5, 0.0, np.nan, np.nan, np.nan])
    assert np.isnan(waiting_times(flags, 0.5, 10.0)).all()  # longer than the record


@settings(max_examples=40, deadline=None)
@given(st.lists(st.booleans(), min_size=1, max_size=60), st.integers(1, 8))
def test_a_window_that_starts_is_workable_throughout_and_none_is_missed(flags, steps):
    array = np.array(flags)
    starts = window_starts(array, steps)
    for at in range(array.size):
        assert starts[at] == (at + steps <= array.size and all(flags[at : at + steps]))


def test_a_month_counts_measured_seas_only():
    time = pandas.date_range("2001-01-30", periods=72, freq="h")
    flags = np.arange(72) % 2 == 0
    known = np.arange(72) < 60
    shares = monthly_share(time, flags & known, known)
    assert shares.to_dict() == {1: 0.5, 2: 0.5}


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
    assert record.missing == 0.25  # the hour of fill values is there, and empty
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
    assert (record.step, record.missing) == (3.0, 0.0)
    np.testing.assert_allclose(record.states["hs"], heights, rtol=0.04)  # what lies beyond 0.4 Hz is not in the file
    np.testing.assert_allclose(record.states["tp"], periods, rtol=0.05)


CURVE = pandas.DataFrame({"period": [6.0, 10.0], "limit": [1.0, 3.0], "lower": [0.5, 2.0], "upper": [1.5, 4.0]})


def test_the_share_of_workable_seas_is_counted_on_the_curve(tmp_path):
    path = tmp_path / "scatter.csv"
    path.write_text("# numbers of seas\nhs, 4, 8, 12\n0.8, 10, 10, 0\n1.9, 20, 20, 20\n2.9, 0, 10, 10\n")
    record = read_record(path)
    assert not record.has_order
    # limits 1 m at 4 s (held), 2 m at 8 s, 3 m at 12 s (held): workable are 10, 10 + 20, 20 + 10 of 100
    assert workable_share(record, CURVE) == pytest.approx(0.7)
    # lower: 0.5, 1.25, 2: 0, 10, 20
    assert workable_share(record, CURVE, "lower") == pytest.approx(0.3)
    assert beyond_the_grid(record, CURVE) == pytest.approx(0.6)


def test_a_share_of_the_limit_may_be_all_that_counts(tmp_path):
    seas = tmp_path / "seas.csv"
    seas.write_text("time,hs,tp\n" + "".join(f"2001-01-01T{h:02d}:00,{0.2 * h},8\n" for h in range(24)))
    record = read_record(seas)
    assert workable(record, CURVE).sum() == 11  # hs up to 2.0
    assert workable(record, CURVE, alpha=0.8).sum() == 9  # up to 1.6


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.csv", "time,height\n1,2\n", "must have the columns time, hs, tp, or hs and peak periods"),
        ("a.csv", "time,hs,tp\nyesterday,1,8\n", "a.csv: "),
        ("a.csv", "time,hs,tp\n2001-01-01,1,8\n", "holds 1 sea states with a height and a period: too few"),
        ("a.csv", "hs,4,8\n1,-1,2\n", "must hold numbers of seas, none below 0"),
        ("a.csv", "hs,4,8\n1,0,0\n", "and not all 0"),
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
