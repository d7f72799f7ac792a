"""What ships log: times of every form, gaps, windows; the truth is the sine that the log was written from."""

import math
from datetime import datetime, timedelta, timezone

import numpy as np
import pytest
from heave_bags.errors import BagError
from heave_bags.signals import Signal
from heave_devices.maps.channel import Channel
from heave_devices.maps.device_map import DeviceMap
from heave_devices.records.sea_import import import_sea
from heave_devices.records.ship_time import time_words, unix_time
from heave_devices.records.stretches import Window, longest_stretch
from hypothesis import given
from hypothesis import strategies as st

BEGUN = datetime(2025, 3, 1, 12, tzinfo=timezone.utc)
OMEGA = 2.0 * math.pi / 9.0
HEAVE = DeviceMap({"heave": Channel(column="heave")})

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
    # the years 1 and 1601 of .NET and Windows in 100 ns, 1904 of LabVIEW: as Unix time 1990, 1974, 2091
    **{
        name: ("time", ",", lambda t, zero=zero: str(zero + round(1e7 * t)), BEGUN.timestamp())
        for name, zero in (("ticks of .NET", 638764272 * 10**9), ("a FILETIME", 133853040 * 10**9))
    },
    "seconds from 1904": ("time", ",", lambda t: f"{3823675200.0 + t:.3f}", BEGUN.timestamp()),
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
    sea = import_sea(log, DeviceMap(HEAVE.channels, time_column=["date", "clock"]))
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
    sea = import_sea(tmp_path / "mru.csv", DeviceMap(channels))
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


TIMES = 0.1 * np.arange(1200)


def rows(scale_time=1.0, scale=1.0, form="{:.4f}"):
    """Return lines of the sine, its time and heave in other units."""
    return [f"{t * scale_time:.6f},{form.format(z * scale)}" for t, z in zip(TIMES, sine(TIMES), strict=True)]


def imported(path, lines, column="heave", encoding="utf-8"):
    path.write_bytes(("\n".join(lines) + "\n").encode(encoding))
    return import_sea(path, DeviceMap({"heave": Channel(column=column)}))


def is_the_sine(sea):
    heave = sine(sea.time)
    return sea.time[-1] > 119.0 and np.allclose(sea.position[:, 2], heave - heave.mean(), atol=2e-3)


DAY_END = datetime(2016, 12, 31, 23, 59, tzinfo=timezone.utc)


def with_leap_second(t):
    """Return the UTC of `t` seconds after DAY_END; 31 December 2016 ended with a second 60."""
    if 60.0 <= t < 61.0:
        return f"2016-12-31T23:59:{t:06.3f}Z"
    return f"{DAY_END + timedelta(seconds=t - (t >= 61.0)):%Y-%m-%dT%H:%M:%S.%f}Z"


READ = {
    "minutes in the heading": ["time [min],heave", *rows(1.0 / 60.0)],
    "hours in the line of units": [
        "time,heave",
        "h,m",
        *(f"{t / 3600.0:.9f},{z:.4f}" for t, z in zip(TIMES, sine(TIMES), strict=True)),
    ],
    "units that are not known": ["time,wind,heave", "[s],[Beaufort],[m]", *(row.replace(",", ",4,") for row in rows())],
    "compound units": ["time,rate,heave", "s,m/s,m", *(row.replace(",", ",4,") for row in rows())],
    "a word in the first row": ["time,heave", "-0.1,NULL", *rows()],
    "headings and units repeated": ["time,heave", "s,m", *rows()[:600], "time,heave", "s,m", *rows()[600:]],
    "a leap second": [
        "time,heave",
        *(f"{with_leap_second(round(t, 3))},{z:.4f}" for t, z in zip(TIMES, sine(TIMES), strict=True)),
    ],
    "am and pm": [
        "time,heave",
        *(
            f"{datetime(2026, 3, 13, 11, 59) + timedelta(seconds=t):%m/%d/%Y %I:%M:%S.%f %p},{z:.4f}"
            for t, z in zip(TIMES, sine(TIMES), strict=True)
        ),
    ],
}


@pytest.mark.parametrize("kind", READ)
def test_a_log_as_tools_write_it_is_read(kind, tmp_path):
    assert is_the_sine(imported(tmp_path / "mru.csv", READ[kind]))


@pytest.mark.parametrize("encoding", ["utf-16-le", "utf-16-be"])
def test_utf_16_without_a_byte_order_mark_is_read_and_said(encoding, tmp_path):
    sea = imported(tmp_path / "mru.csv", ["time,heave", *rows()], encoding=encoding)
    assert is_the_sine(sea)
    assert "read as UTF-16 without a byte order mark" in sea.notes


ASKED = {
    "minutes, unsaid": (["time,heave", *rows(1.0 / 60.0)], "time in another unit?"),
    "days, unsaid": (
        ["time,heave", *(f"{60 + t / 86400:.9f},{z:.4f}" for t, z in zip(TIMES, sine(TIMES), strict=True))],
        "--time-scale",
    ),
    "columns exchanged in mid-file": (
        [
            "time,heave,roll",
            *(f"{row},0" for row in rows()[:600]),
            "time,roll,heave",
            *(f"{row},0" for row in rows()[600:]),
        ],
        "has other headings in line 602 (time, roll, heave) than in line 1",
    ),
    "another unit in mid-file": (
        ["time,heave", *rows()[:600], "time,heave_cm", *rows(scale=100.0)[600:]],
        "has other headings in line 602 (time, heave_cm)",
    ),
    "one heading twice": (
        ["time,heave,heave", *(f"{row},0" for row in rows())],
        "'heave' for heave names more than one",
    ),
    "one name in two units": (
        ["time,heave [m],heave [cm]", *(f"{row},0" for row in rows())],
        "names more than one column",
    ),
    "marks for thousands": (
        ["time,heave", *(f'{t:.1f},"{2000.0 * z:,.0f}"' for t, z in zip(TIMES, sine(TIMES), strict=True))],
        "can be read in two ways: write all numbers of the file with decimal points",
    ),
    "positive down": (["time,heave [m; positive down]", *rows()], "in m positive down by its heading: give --scale -1"),
    "centimetres positive down": (["time,heave (down) [cm]", *rows(scale=100.0)], "give --scale -0.01"),
    "another separator in mid-file": (
        ["time,heave", *rows()[:600], *(row.replace(",", ";") for row in rows()[600:])],
        "has no headings for its 2 columns, parted by semicolons from line 602 on",
    ),
    "time that runs backwards": (["time,heave", *reversed(rows())], "the time goes back by 0.1 s after t = 119.900 s"),
    "time with too few digits": (
        ["time,heave", *(f"{1.7e9 + t:.5e},{z:.4f}" for t, z in zip(TIMES, sine(TIMES), strict=True))],
        "too few digits?",
    ),
}


@pytest.mark.parametrize("kind", ASKED)
def test_a_log_that_can_be_read_wrongly_is_refused_with_the_cause(kind, tmp_path):
    lines, words = ASKED[kind]
    with pytest.raises(BagError) as caught:
        imported(tmp_path / "mru.csv", lines)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_time_that_is_taken_out_of_several_is_said(tmp_path):
    sea = imported(tmp_path / "mru.csv", ["time,gps_time,heave", *(row.replace(",", ",18,") for row in rows())])
    assert "time: taken from time, not from gps_time; --time-column names another" in sea.notes


@pytest.mark.parametrize(
    ("back", "form", "says", "lasts"),
    [
        (3600.0, "{:.1f}", "put back by an hour, as summer time ends", 119.9),
        (3600.0, "clock", "put back by an hour, as summer time ends", 119.9),
        (1800.0, "{:.1f}", "the time goes back by 1799.9 s after t = 7299.900 s", 99.9),
    ],
)
def test_a_clock_that_is_put_back_is_said(tmp_path, back, form, says, lasts):
    """At the end of summer time a local clock runs twice through an hour, which is counted on; else it is a loss."""
    stamps = TIMES - back * (TIMES >= 100.0) + 7200.0
    texts = [f"{BEGUN + timedelta(seconds=t):%H:%M:%S.%f}" if form == "clock" else form.format(t) for t in stamps]
    moved = [f"{text},{z:.4f}" for text, z in zip(texts, sine(TIMES), strict=True)]
    sea = imported(tmp_path / "mru.csv", ["time,heave", *moved])
    assert any(says in note for note in sea.notes)
    assert sea.time[-1] == pytest.approx(lasts, abs=0.06)
