"""What ships log: times of every form, gaps, windows; the truth is the sine that the log was written from."""

import math
from datetime import datetime, timedelta, timezone

import numpy as np
import pytest
from heave_bags.errors import BagError
from heave_bags.play.sea_import import import_sea
from heave_bags.play.sea_mapping import Channel, SeaMapping
from heave_bags.play.ship_time import time_words, unix_time
from heave_bags.play.stretches import longest_stretch
from heave_bags.play.window import Window
from heave_bags.signals import Signal
from hypothesis import given
from hypothesis import strategies as st

BEGUN = datetime(2025, 3, 1, 12, tzinfo=timezone.utc)
OMEGA = 2.0 * math.pi / 9.0
HEAVE = SeaMapping({"heave": Channel(column="heave")})

FORMS = {
    "seconds from any start": ("time_s", ",", lambda t: f"{t + 17.0:.3f}", 17.0),
    "Unix time in seconds": ("unix", ",", lambda t: f"{BEGUN.timestamp() + t:.3f}", BEGUN.timestamp()),
    "Unix time in milliseconds": ("Time", "\t", lambda t: f"{1e3 * (BEGUN.timestamp() + t):.0f}", BEGUN.timestamp()),
    "Unix time in nanoseconds": (
        "t",
        ",",
        lambda t: f"{BEGUN.timestamp() + t:.3f}".replace(".", "") + "0" * 6,
        BEGUN.timestamp(),
    ),
    "ISO time with Z": (
        "utc",
        ",",
        lambda t: f"{BEGUN + timedelta(seconds=t):%Y-%m-%dT%H:%M:%S.%fZ}",
        BEGUN.timestamp(),
    ),
    "ISO time with a zone, one decimal": (
        "timestamp",
        ";",
        lambda t: f"{BEGUN + timedelta(seconds=t, hours=2):%Y-%m-%d %H:%M:%S.%f}"[:-5] + "+02:00",
        BEGUN.timestamp(),
    ),
    "ISO time without a zone, UTC": (
        "DateTime",
        ",",
        lambda t: f"{BEGUN + timedelta(seconds=t):%Y-%m-%d %H:%M:%S.%f}",
        BEGUN.timestamp(),
    ),
}


def sine(time):
    return np.sin(OMEGA * np.asarray(time))


def written(path, times, *, heading="time_s", separator=",", form=lambda t: f"{t:.3f}"):
    """Write a log of the sine at given times [s]."""
    number = "{:.6f}".format
    cells = [(form(float(t)), number(value)) for t, value in zip(times, sine(times), strict=True)]
    if separator == ";":
        cells = [(time, value.replace(".", ",")) for time, value in cells]
    path.write_text(f"{heading}{separator}heave\n" + "\n".join(separator.join(row) for row in cells) + "\n")
    return path


def assert_is_sine(sea, begins_at, start_of_sine=0.0):
    """The motion is the sine, from `begins_at` after the start of the sine on [s]."""
    expected = sine(sea.time + begins_at - start_of_sine)
    assert np.abs(sea.position[:, 2] - (expected - expected.mean())).max() < 2e-3


@pytest.mark.parametrize("form", FORMS)
def test_a_time_of_any_form_is_understood(tmp_path, form):
    heading, separator, text, start = FORMS[form]
    log = written(tmp_path / "mru.txt", 0.1 * np.arange(600), heading=heading, separator=separator, form=text)
    sea = import_sea(log, HEAVE)
    assert sea.start == pytest.approx(start, abs=1e-3)
    assert sea.time[-1] == pytest.approx(59.9, abs=0.051)
    assert_is_sine(sea, 0.0)


def test_date_and_time_may_stand_in_two_columns(tmp_path):
    log = written(
        tmp_path / "mru.csv",
        0.1 * np.arange(600),
        heading="date,clock",
        form=lambda t: f"{BEGUN + timedelta(seconds=t):%Y-%m-%d,%H:%M:%S.%f}",
    )
    sea = import_sea(log, SeaMapping(HEAVE.channels, time_column=["date", "clock"]))
    assert sea.start == pytest.approx(BEGUN.timestamp(), abs=1e-3)
    assert_is_sine(sea, 0.0)


def test_a_short_gap_is_bridged_and_told(tmp_path):
    time = 0.1 * np.arange(1000)
    sea = import_sea(written(tmp_path / "mru.csv", time[(time < 39.95) | (time > 41.45)]), HEAVE)
    assert sea.time[-1] == pytest.approx(99.9)
    assert sea.notes == ["heave: one gap of 1.60 s bridged"]
    assert_is_sine(sea, 0.0)


def test_of_the_stretches_between_long_gaps_the_longest_is_taken_and_told(tmp_path):
    time = 0.1 * np.arange(2000)
    kept = time[((time < 40.0) | (time > 50.0)) & ((time < 150.0) | (time > 155.0))]
    log = written(tmp_path / "mru.csv", kept, heading="unix", form=lambda t: f"{BEGUN.timestamp() + t:.3f}")
    sea = import_sea(log, HEAVE)
    assert sea.time[-1] == pytest.approx(99.8, abs=0.06)
    assert_is_sine(sea, 50.1)
    (told,) = sea.notes
    assert "2 gaps of more than 2 s, the longest 10.2 s: of 3 stretches the longest is taken, 99.8 s" in told
    assert "from 2025-03-01T12:00:50.100Z; 100.1 s left out" in told
    assert import_sea(log, HEAVE, Window(bridge=6.0)).time[-1] == pytest.approx(149.8, abs=0.06)


def test_a_gap_in_any_channel_ends_a_stretch(tmp_path):
    rows = [f"{0.1 * n:.1f},{math.sin(0.07 * n):.6f},{'' if 300 <= n < 400 else 0.1}" for n in range(1000)]
    (tmp_path / "mru.csv").write_text("time,heave,roll\n" + "\n".join(rows) + "\n")
    channels = {"heave": Channel(column="heave"), "roll": Channel(column="roll")}
    sea = import_sea(tmp_path / "mru.csv", SeaMapping(channels))
    assert sea.time[-1] == pytest.approx(59.9, abs=0.06)


@pytest.mark.parametrize(
    ("window", "start", "duration"),
    [
        (Window("20", "50"), 20.0, 30.0),
        (Window("2025-03-01T12:00:20Z", "2025-03-01T14:00:50+02:00"), 20.0, 30.0),
        (Window(end="30"), 0.0, 30.0),
        (Window("-5", "1e6"), 0.0, 99.9),
    ],
)
def test_a_window_is_cut_by_seconds_or_by_the_clock(tmp_path, window, start, duration):
    log = written(
        tmp_path / "mru.csv", 0.1 * np.arange(1000), heading="t", form=lambda t: f"{BEGUN.timestamp() + t:.3f}"
    )
    sea = import_sea(log, HEAVE, window)
    assert sea.start - BEGUN.timestamp() == pytest.approx(start, abs=1e-3)
    assert sea.time[-1] == pytest.approx(duration, abs=0.06)
    assert_is_sine(sea, start)


@pytest.mark.parametrize(
    ("heading", "window", "complaint"),
    [
        ("t", Window("lunch"), "--from lunch: must be seconds from the start, or a time as in"),
        ("t", Window("2025-03-01T12:00:00"), "the record has no date"),
        ("t", Window("200"), "the record is from t = 0.000 s to t = 99.900 s: nothing of it is in the window"),
        ("t", Window("10", "10.2"), "the longest stretch has only 0.20 s"),
        ("when", Window(), "name it by --time-column, or by time_column in a mapping file"),
    ],
)
def test_what_cannot_be_taken_is_said_in_one_line(tmp_path, heading, window, complaint):
    log = written(tmp_path / "mru.csv", 0.1 * np.arange(1000), heading=heading)
    with pytest.raises(BagError, match=r"mru\.csv") as caught:
        import_sea(log, HEAVE, window)
    assert complaint in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_time_that_is_neither_number_nor_date_is_shown(tmp_path):
    log = written(tmp_path / "mru.csv", 0.1 * np.arange(100), heading="time", form=lambda t: f"T+{t:.1f}")
    with pytest.raises(BagError, match=r"time: 'T\+0.0' is neither a number nor a time as in 2025-03-01T12:00:00.5Z"):
        import_sea(log, HEAVE)


@pytest.mark.parametrize(
    "text",
    ["2025-03-01T12:00:00Z", "2025-03-01 12:00:00", "2025-03-01T14:00:00.000000001+02:00", "2025-03-01T12:00:00,0Z"],
)
def test_iso_times_are_read(text):
    assert unix_time(text) == BEGUN.timestamp()
    assert time_words(unix_time(text)) == "2025-03-01T12:00:00.000Z"


def test_no_time_is_no_number():
    assert math.isnan(unix_time("yesterday"))
    assert math.isnan(unix_time(""))


@given(st.lists(st.floats(0.05, 5.0), min_size=2, max_size=60), st.floats(0.5, 4.0))
def test_no_stretch_without_a_long_gap_is_longer_than_the_one_taken(steps, bridge):
    time = np.cumsum([0.0, *steps])
    start, end = longest_stretch({"heave": Signal(time, time)}, Window(bridge=bridge), [])
    runs = np.split(time, np.flatnonzero(np.diff(time) > bridge) + 1)
    assert end - start == pytest.approx(max(run[-1] - run[0] for run in runs))
    taken = time[(time >= start) & (time <= end)]
    assert np.diff(taken).max(initial=0.0) <= bridge
