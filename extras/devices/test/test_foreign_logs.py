"""Logs as the tools of ships write them: each is read to the motion it was written from, or refused in one line."""

import math
from datetime import datetime, timedelta, timezone

import numpy as np
import pytest
from heave_bags.errors import BagError
from heave_devices.maps.channel import Channel
from heave_devices.maps.device_map import DeviceMap
from heave_devices.records.sea_import import import_sea
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

BEGUN = datetime(2025, 3, 1, 12, tzinfo=timezone.utc)
TIME = np.round(np.arange(0.0, 900.0, 0.1), 1)
HEAVE = np.sin(2.0 * math.pi * TIME / 8.0) + 0.3 * np.sin(2.0 * math.pi * TIME / 6.1)
SIGNIFICANT = 4.0 * math.sqrt((1.0 + 0.09) / 2.0)
"""Four standard deviations of the two sines [m]."""


def moment(time):
    return BEGUN + timedelta(seconds=float(time))


def clock(time, form="%H:%M:%S"):
    return f"{moment(time):{form}}.{moment(time).microsecond // 100000}"


def mapping(column="heave", **others):
    return DeviceMap({"heave": Channel(column=column)}, **others)


def written(path, header, row, *, encoding="utf-8", before="", newline="\n", heave=HEAVE):
    """Write a log: lines before it, a header, and `row` of time and heave for each sample."""
    lines = [header, *(row(float(t), float(z)) for t, z in zip(TIME, heave, strict=True))]
    text = before + "\n".join(lines) + "\n"
    path.write_bytes(text.replace("\n", newline).encode(encoding))
    return path


def comma(text):
    return text.replace(".", ",")


# name: header, row, how it is written, what it must say, start of the record [s]
FORMS = {
    "a line of units": ("time,heave,roll\ns,m,deg", lambda t, z: f"{t:.2f},{z:.3f},0", {}, "units in line 2", 0.0),
    "Latin-1, decimal commas": (
        "time;heave [m];roll [°]",
        lambda t, z: comma(f"{t:.2f};{z:.3f};0"),
        {"encoding": "latin-1"},
        "read as Latin-1",
        0.0,
    ),
    "a preamble": (
        "time,heave",
        lambda t, z: f"{t:.2f},{z:.3f}",
        {"before": "Vessel,MV Example\nSensor,MRU 5\nStart,2025-03-01 12:00\n\n"},
        "3 lines before the headings",
        0.0,
    ),
    "tabs and decimal commas": ("time\theave", lambda t, z: comma(f"{t:.2f}\t{z:.3f}"), {}, "decimal commas", 0.0),
    "hhmmss.s": ("time,heave", lambda t, z: f"{clock(t, '%H%M%S')},{z:.3f}", {}, "taken as hhmmss", 43200.0),
    "hh:mm:ss.s": ("time,heave", lambda t, z: f"{clock(t)},{z:.3f}", {}, "of the day alone", 43200.0),
    "dd.mm.yyyy": (
        "date,time,heave",
        lambda t, z: f"{moment(t):%d.%m.%Y},{clock(t)},{z:.3f}",
        {},
        "day first",
        BEGUN.timestamp(),
    ),
    "serial days of Excel": ("time,heave", lambda t, z: f"{45717.5 + t / 86400:.9f},{z:.3f}", {}, "Excel", None),
    "serial days of Matlab": ("time,heave", lambda t, z: f"{739677.5 + t / 86400:.10f},{z:.3f}", {}, "Matlab", None),
    "spaces": ("time heave roll", lambda t, z: f"{t:8.2f} {z:8.3f}   0.0", {}, "columns parted by spaces", 0.0),
    "ten rows on each second": (
        "utc,heave",
        lambda t, z: f"{moment(t):%Y-%m-%d %H:%M:%S},{z:.3f}",
        {},
        "10 rows on each stamp",
        BEGUN.timestamp(),
    ),
    "UTF-16": (
        "time,heave",
        lambda t, z: f"{t:.2f},{z:.3f}",
        {"encoding": "utf-16", "newline": "\r\n"},
        "read as UTF-16",
        0.0,
    ),
    "a byte order mark": ("time,heave", lambda t, z: f"{t:.2f},{z:.3f}", {"encoding": "utf-8-sig"}, "", 0.0),
    "milliseconds by the heading": (
        "time_ms,heave",
        lambda t, z: f"{1e3 * t:.0f},{z:.3f}",
        {},
        "units of 0.001 s",
        0.0,
    ),
    "seconds of the day over midnight": (
        "time,heave",
        lambda t, z: f"{(86000 + t) % 86400:.1f},{z:.3f}",
        {},
        "passes midnight once",
        86000.0,
    ),
    "hh:mm:ss over midnight": (
        "time,heave",
        lambda t, z: f"{clock(t + 43200 - 300)},{z:.3f}",
        {},
        "passes midnight once",
        86100.0,
    ),
    "local time with an offset": (
        "time,heave",
        lambda t, z: f"{moment(t + 3600):%Y-%m-%dT%H:%M:%S}.{moment(t).microsecond // 1000:03d}+0100,{z:.3f}",
        {},
        "",
        BEGUN.timestamp(),
    ),
    # week 2355 begins on Sunday 23 February 2025; 1 March 12:00 UTC is 561,618 s of GPS time later
    "GPS week and seconds": (
        "gps_week,tow,heave",
        lambda t, z: f"2355,{561618 + t:.1f},{z:.3f}",
        {},
        "GPS",
        BEGUN.timestamp(),
    ),
    "quotes": ('"time","heave, up [m]"', lambda t, z: f'"{t:.2f}","{z:.3f}"', {}, "", 0.0),
    "headings in a comment": ("# time,heave", lambda t, z: f"{t:.2f},{z:.3f}", {}, "comment in line 1", 0.0),
    "a month by its name": (
        "time;heave",
        lambda t, z: comma(f"{moment(t):%d-%b-%Y} {clock(t)};{z:.3f}"),
        {},
        "",
        BEGUN.timestamp(),
    ),
    "yyyymmdd and hhmmss": (
        "date,time,heave",
        lambda t, z: f"{moment(t):%Y%m%d},{clock(t, '%H%M%S')},{z:.3f}",
        {},
        "",
        BEGUN.timestamp(),
    ),
}


@pytest.mark.parametrize("name", FORMS)
def test_a_log_of_any_form_is_the_motion_it_was_written_from(tmp_path, name):
    header, row, how, says, start = FORMS[name]
    column = "heave, up" if name == "quotes" else "heave"
    sea = import_sea(written(tmp_path / "mru.txt", header, row, **how), mapping(column))
    assert sea.time[-1] == pytest.approx(899.9, abs=0.06)
    # three decimals, and Excel's nine of a day, which are 0.1 ms
    expected = np.interp(sea.time, TIME, HEAVE)
    assert np.abs(sea.position[:, 2] - (expected - expected.mean())).max() < 3e-3
    assert not says or any(says in note for note in sea.notes)
    assert sea.start == pytest.approx(BEGUN.timestamp() if start is None else start, abs=1e-3)


def test_a_date_that_can_be_read_in_two_ways_needs_the_option_it_names(tmp_path):
    log = written(tmp_path / "mru.csv", "date,time,heave", lambda t, z: f"{moment(t):%d/%m/%Y},{clock(t)},{z:.3f}")
    with pytest.raises(BagError, match="01/03/2025 can be read with the day or the month first: say --date-order dmy"):
        import_sea(log, mapping())
    assert import_sea(log, mapping(date_order="dmy")).start == BEGUN.timestamp()
    january = datetime(2025, 1, 3, 12, tzinfo=timezone.utc).timestamp()
    assert import_sea(log, mapping(date_order="mdy")).start == january


def test_milliseconds_without_a_heading_that_says_so_are_asked_for(tmp_path):
    log = written(tmp_path / "mru.csv", "time,heave", lambda t, z: f"{1e3 * t:.0f},{z:.3f}")
    with pytest.raises(BagError, match=r"sample interval is 100 s.*milliseconds\? give.*--time-scale"):
        import_sea(log, mapping())
    assert import_sea(log, mapping(time_scale=1e-3)).time[-1] == pytest.approx(899.9, abs=0.06)


def test_zero_bytes_of_a_power_cut_are_left_out_and_said(tmp_path):
    log = written(tmp_path / "mru.csv", "time,heave", lambda t, z: f"{t:.2f},{z:.3f}")
    log.write_bytes(log.read_bytes() + bytes(4096))
    sea = import_sea(log, mapping())
    assert sea.time[-1] == pytest.approx(899.9, abs=0.06)
    assert "4096 zero bytes" in sea.notes[0]


def test_a_second_header_in_the_middle_is_left_out(tmp_path):
    log = written(tmp_path / "mru.csv", "time,heave", lambda t, z: f"{t:.2f},{z:.3f}" + "\ntime,heave" * (t == 450.0))
    sea = import_sea(log, mapping())
    assert sea.time[-1] == pytest.approx(899.9, abs=0.06)
    assert "headings repeated among the rows: 1 lines left out" in sea.notes


def plain(path, heave):
    return written(path, "time,heave", lambda t, z: f"{t:.2f},{z:.6f}", heave=heave)


def test_a_fill_value_is_a_gap(tmp_path):
    # -9999 for the 39 samples between 300 and 304 s: a gap of 4 s, after which 596 s remain
    heave = np.where((TIME > 300.0) & (TIME < 304.0), -9999.0, HEAVE)
    sea = import_sea(plain(tmp_path / "mru.csv", heave), mapping())
    assert sea.time[-1] == pytest.approx(595.9, abs=0.06)
    assert 4.0 * sea.position[:, 2].std() == pytest.approx(SIGNIFICANT, rel=0.01)
    assert "39 samples of -9999, the first at t = 300.100 s, taken as fill values" in sea.notes[0]
    taken = import_sea(plain(tmp_path / "mru.csv", heave), mapping(), accept_implausible=True)
    assert taken.time[-1] == pytest.approx(899.9, abs=0.06)
    assert any("plausible is 0 to 25 m" in note for note in taken.notes)


def test_a_sensor_that_stands_still_is_a_gap(tmp_path):
    heave = np.where((TIME > 300.0) & (TIME < 600.0), HEAVE[3000], HEAVE)
    sea = import_sea(plain(tmp_path / "mru.csv", heave), mapping())
    assert 4.0 * sea.position[:, 2].std() == pytest.approx(SIGNIFICANT, rel=0.02)
    assert sea.time[-1] == pytest.approx(300.0, abs=0.2)
    assert any("stands still at" in note and "for 299.9 s from t = 300.000 s" in note for note in sea.notes)


@pytest.mark.parametrize(
    ("heave", "says"),
    [
        (100.0 * HEAVE, "centimetres or millimetres"),
        (1000.0 * HEAVE, "centimetres or millimetres"),
        (20.0 * HEAVE, "plausible is 0 to 25 m"),
        (8.0 * HEAVE, "significant steepness"),  # 24 m at 8 s: waves of that period break at 7
        (HEAVE + np.where(TIME % 10.0 == 0.0, 31.0 + TIME, 0.0), "plausible is 0 to 30 m"),
    ],
)
def test_a_motion_that_cannot_be_is_refused_unless_it_is_accepted(tmp_path, heave, says):
    log = plain(tmp_path / "mru.csv", heave)
    with pytest.raises(BagError, match=says) as refused:
        import_sea(log, mapping())
    assert "--accept-implausible takes the figures as they are" in str(refused.value)
    assert "\n" not in str(refused.value)
    sea = import_sea(log, mapping(), accept_implausible=True)
    # a spline rounds what is but one sample long
    assert sea.position[:, 2].std() == pytest.approx(np.std(heave), rel=0.1)
    assert any(says in note for note in sea.notes)


def test_a_heading_that_states_another_unit_needs_the_scale_it_names(tmp_path):
    row = lambda t, z: f"{t:.2f},{100 * z:.1f}"  # noqa: E731
    log = written(tmp_path / "mru.csv", "time,heave_cm", row)
    with pytest.raises(BagError, match=r"column heave_cm is in cm by its heading: give --scale 0\.01"):
        import_sea(log, mapping("heave_cm"))
    sea = import_sea(log, DeviceMap({"heave": Channel(column="heave_cm", scale=0.01)}))
    assert 4.0 * sea.position[:, 2].std() == pytest.approx(SIGNIFICANT, rel=0.01)
    both = written(tmp_path / "both.csv", "time,heave,roll\ns,m,deg", lambda t, z: f"{t:.2f},{z:.3f},{z:.3f}")
    channels = {"heave": Channel(column="heave"), "roll": Channel(column="roll")}
    with pytest.raises(BagError, match=r"column roll is in deg by its heading: give --scale 0\.0174533"):
        import_sea(both, DeviceMap(channels))


def test_angles_in_degrees_are_asked_for(tmp_path):
    log = written(tmp_path / "mru.csv", "time,heave,roll", lambda t, z: f"{t:.2f},{z:.3f},{3.0 * z:.3f}")
    channels = {"heave": Channel(column="heave"), "roll": Channel(column="roll")}
    with pytest.raises(BagError, match=r"roll is 3\.\d+ rad, plausible is 0 to 1\.2 rad: degrees"):
        import_sea(log, DeviceMap(channels))


@pytest.mark.parametrize(
    ("valid", "channel"),
    [
        (("heave_valid", "true", "false"), {}),
        (("valid", "1", "0"), {}),
        (("gps_status", "A", "V"), {"valid": "gps_status"}),
        (("status", "1", "4"), {"valid": "status", "invalid_bits": 4}),
        (("status", "0x0001", "0x8001"), {"valid": "status", "invalid_bits": 0x8000}),
        (("status", "3", "9"), {"valid": "status", "valid_values": (3.0, 6.0)}),
        (("state", "ST", "US"), {"valid": "state", "valid_values": ("ST",)}),
        (("status", "1", "nan"), {"valid": "status"}),
    ],
)
def test_samples_that_the_log_calls_invalid_are_gaps(tmp_path, valid, channel):
    name, good, bad = valid
    log = written(
        tmp_path / "mru.csv",
        f"time,heave,{name}",
        lambda t, z: f"{t:.2f},{99.0 if 100.0 <= t < 101.0 else z:.3f},{bad if 100.0 <= t < 101.0 else good}",
    )
    sea = import_sea(log, DeviceMap({"heave": Channel(column="heave", **channel)}))
    assert sea.time[-1] == pytest.approx(899.9, abs=0.06)
    assert f"heave: 10 samples that {name} calls invalid left out" in sea.notes
    assert 4.0 * sea.position[:, 2].std() == pytest.approx(SIGNIFICANT, rel=0.01)


def test_a_validity_that_is_no_word_of_it_is_refused(tmp_path):
    log = written(tmp_path / "mru.csv", "time,heave,quality", lambda t, z: f"{t:.2f},{z:.3f},purple")
    with pytest.raises(BagError, match="quality = 'purple' is neither a number nor one of true, valid"):
        import_sea(log, DeviceMap({"heave": Channel(column="heave", valid="quality")}))


NMEA = ["$PSXN,23,0.12,-1.4,211.3,0.25*1C", "$GPZDA,120000.10,01,03,2025,00,00*6A"]


@pytest.mark.parametrize("before", ["", "2025-03-01 12:00:00.1,"])
@pytest.mark.parametrize("name", ["mru.nmea", "mru.txt", "mru"])
@pytest.mark.parametrize("wanted", ["/mru/heave", mapping()])
def test_raw_nmea_says_that_it_is(tmp_path, before, name, wanted):
    (tmp_path / name).write_text("\n".join(before + line for line in NMEA * 50) + "\n")
    with pytest.raises(BagError, match=r"this is NMEA 0183 \(\$PSXN, \$GPZDA\): sentences, not columns"):
        import_sea(tmp_path / name, wanted)


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"PK\x03\x04" + bytes(100), "an Excel workbook: save it as CSV"),
        (b"\x28\xb5\x2f\xfd" + bytes(100), "compressed by zstd"),
        (bytes(range(256)), "is not a text file"),
        (b"", "is empty"),
        (b"\xff\xfet", "not complete UTF-16"),
        (b"1.0,2.0\n2.0,3.0\n", "has no line of headings: name its 2 columns"),
        (b"time,heave\n", "has a header but no rows"),
    ],
)
def test_a_file_of_another_kind_is_refused_in_one_line(tmp_path, content, says):
    (tmp_path / "mru.csv").write_bytes(content)
    with pytest.raises(BagError, match=says) as refused:
        import_sea(tmp_path / "mru.csv", mapping())
    assert str(tmp_path / "mru.csv") in str(refused.value)
    assert "\n" not in str(refused.value)


LOG = "utc,heave,roll,status\n" + "".join(
    f"{moment(t):%Y-%m-%dT%H:%M:%S}.{round(10 * t) % 10},{z:.3f},{0.02 * z:.4f},1\n"
    for t, z in zip(TIME[:1500], HEAVE[:1500], strict=True)
)


@st.composite
def mistreated(draw):
    """Return the log as another tool would have saved it: units, columns, lines or encoding are not what they were."""
    rows = [line.split(",") for line in LOG.splitlines()]
    header, rows = rows[0], rows[1:]
    factor = draw(st.sampled_from([1.0, 1.0, 0.01, 3.2808, 57.2958, 100.0, 1e3, -1.0]))
    rows = [[row[0], f"{factor * float(row[1]):g}", *row[2:]] for row in rows]
    if draw(st.booleans()):  # a fill value, or a sensor that stands still
        fill = draw(st.sampled_from(["-9999", "99.99", "", "nan", "32767", rows[700][1]]))
        for row in rows[draw(st.integers(0, 700)) : draw(st.integers(701, 1400))]:
            row[1] = fill
    if draw(st.booleans()):
        order = draw(st.permutations(range(4)))
        rows = [[row[i] for i in order] for row in rows]
        header = [header[i] for i in order] if draw(st.booleans()) else header
    lines = [",".join(row) for row in (header, *rows)]
    for _ in range(draw(st.integers(0, 3))):
        at = draw(st.integers(0, len(lines) - 1))
        lines[at] = lines[at][: draw(st.integers(0, len(lines[at])))]
    text = "\n".join(lines) + "\n"
    if draw(st.booleans()):
        text = text.replace(",", draw(st.sampled_from([";", "\t", "  "])))
        text = text.replace(".", ",") if draw(st.booleans()) else text
    return text.encode(draw(st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "latin-1"])))


@given(content=mistreated(), column=st.sampled_from(["heave", "roll", "utc"]))
@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_mistreated_log_is_refused_in_one_line_or_gives_a_sea_that_can_be(tmp_path, content, column):
    path = tmp_path / "mru.csv"
    path.write_bytes(content)
    try:
        sea = import_sea(path, mapping(column))
    except BagError as error:
        assert "mru.csv" in str(error)
        assert "\n" not in str(error)
        return
    assert np.isfinite(sea.position).all()
    assert 4.0 * sea.position[:, 2].std() <= 25.0
