"""Raw logs of motion sensors, by the maps that read them live; the truth is the sine that each log was written from."""

import math
import struct
from datetime import datetime, timedelta, timezone

import numpy as np
import pytest
from heave_bags.errors import BagError
from heave_devices.records.sea_import import import_sea
from heave_devices.records.sea_mapping import read_mapping

from extras.devices.test import test_nmea
from extras.devices.test.test_kongsberg import km_binary

OMEGA, AMPLITUDE, STEP = 2.0 * math.pi / 9.0, 0.6, 0.1
BEGUN = datetime(2025, 3, 1, 23, 58, tzinfo=timezone.utc)
TIMES = STEP * np.arange(2400)


def up(t):
    return AMPLITUDE * math.sin(OMEGA * t)


def sealed(body):
    return test_nmea.sealed(body).decode().strip()


def psxn(t):
    return sealed(f"PSXN,23,0.30,-0.97,298.57,{-up(t):.3f}")


def pashr(t):
    at = BEGUN + timedelta(seconds=t)
    return sealed(f"PASHR,{at:%H%M%S}.{at.microsecond // 1000:03d},312.95,T,-0.83,-0.42,{-up(t):+.3f},0.2,0.2,0.3,1,0")


def phoct(t):
    at, flag, z = BEGUN + timedelta(seconds=t), "T" if t % 30.0 < 29.5 else "E", up(t) if t % 30.0 < 29.5 else 99.0
    stamp = f"{at:%H%M%S}.{at.microsecond // 1000:03d}"
    rest = f"T,{z:+.3f},{flag},{z:+.3f},+0.0,+0.0,+0.0,+0.0,+0.0,-8.03"
    return sealed(f"PHOCT,01,{stamp},T,00,080.378,T,-000.106,T,-03.105,{rest}")


def zda(t):
    at = BEGUN + timedelta(seconds=t)
    return sealed(f"GPZDA,{at:%H%M%S}.{at.microsecond // 10000:02d},{at:%d,%m,%Y},00,00")


def imported(tmp_path, text, mapping, name="mru.nmea"):
    path = tmp_path / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    (tmp_path / "map.yaml").write_text(mapping)
    return import_sea(path, read_mapping(tmp_path / "map.yaml"))


def assert_is_the_sine(sea, duration=230.0):
    assert sea.time[-1] > duration
    heave = sea.position[:, 2]
    offset = sea.start % 86400.0 - (BEGUN.timestamp() % 86400.0) if sea.start > 1e4 else sea.start
    truth = np.array([up(offset + t) for t in sea.time])
    assert np.abs(heave - (truth - truth.mean())).max() < 0.01


def kmb(t):
    seconds, nanoseconds = divmod(round((BEGUN.timestamp() + t) * 1e9), 10**9)
    return km_binary(-up(t), seconds=seconds, nanoseconds=nanoseconds)


PSXN = "format: nmea\nheave: PSXN23.heave\n"
# what is written for each time, between what, the map, and a part of a note
LOGS = {
    "a stamp before each": (lambda t: f"{(BEGUN + timedelta(seconds=t)).isoformat()} {psxn(t)}", "\n", PSXN, ""),
    "UTC of the day over midnight": (
        pashr,
        "\n",
        "format: nmea\nclock: own\nheave: {field: PASHR.heave, positive: down}\n",
        "",
    ),
    # 99 m in half a second of thirty: with them the significant height would be tens of metres
    "called invalid": (phoct, "\n", "format: nmea\nclock: own\nheave: PHOCT.heave\n", "that the device calls invalid"),
    "binary": (kmb, b"", "format: km_binary\nclock: own\nheave: KMB.heave\n", ""),
}


@pytest.mark.parametrize("kind", LOGS)
def test_a_log_is_read_by_the_map_of_its_device(kind, tmp_path):
    line, between, mapping, note = LOGS[kind]
    sea = imported(tmp_path, between.join(map(line, TIMES)), mapping, "mru.log")
    assert_is_the_sine(sea)
    assert any(note in said for said in [*sea.notes, ""])


def test_sentences_without_a_time_have_that_of_zda_between_them(tmp_path):
    lines = [line for n, t in enumerate(TIMES) for line in ([zda(t)] if n % 10 == 0 else []) + [psxn(t)]]
    sea = imported(tmp_path, "\r\n".join(lines), PSXN)
    assert "time: by 240 sentences ZDA, evenly between them" in sea.notes
    heave = sea.position[:, 2]
    assert np.abs(heave).max() == pytest.approx(AMPLITUDE, rel=0.03)


def test_tss1_has_no_time_and_a_map_says_how_often_it_comes(tmp_path):
    def line(t):
        heave = round(100.0 * up(t))
        return f":000000 {'-' if heave < 0 else ' '}{abs(heave):04d}F-0046 -0563"

    text = "\r\n".join(map(line, TIMES))
    with pytest.raises(BagError, match=r"has no time: .* give sample_rate"):
        imported(tmp_path, text, "format: tss1\nheave: TSS1.heave\n")
    sea = imported(tmp_path, text, "format: tss1\nheave: TSS1.heave\nsample_rate: 10\n", "mru.tss")
    assert np.abs(sea.position[:, 2]).max() == pytest.approx(AMPLITUDE, abs=0.02)


def test_what_is_wrong_in_a_log_is_said(tmp_path):
    lines = [f"{(BEGUN + timedelta(seconds=t)).isoformat()} {psxn(t)}" for t in TIMES]
    lines[100:105] = [line.replace("298.57", "298.58") for line in lines[100:105]]
    sea = imported(tmp_path, "\n".join(lines), PSXN)
    assert "lines left out: 5 checksums do not fit" in sea.notes
    with pytest.raises(BagError, match=r"nothing in it has PASHR.heave; it has PSXN23"):
        imported(tmp_path, "\n".join(lines), "format: nmea\nheave: {field: PASHR.heave, positive: up}\n")


def test_a_line_of_a_load_cell_alone_is_no_sea(tmp_path):
    mapping = "format: line\npattern: '(?P<x>.*)'\ntension: x\n"
    with pytest.raises(BagError, match="heave is missing"):
        imported(tmp_path, "1\n2\n", mapping)


@pytest.mark.parametrize("zero", [0.0, 2082844800.0], ids=["Unix", "LabVIEW"])
def test_a_clock_of_the_devices_own_and_its_values_for_not_available_are_those_of_the_map(tmp_path, zero):
    """A line with milliseconds from 1970 or 1904, and 7777 for no heave."""
    text = "".join(
        f"T{1000.0 * (zero + BEGUN.timestamp() + t):.0f} H{7777.0 if n in (500, 501) else up(t):.4f}\n"
        for n, t in enumerate(TIMES)
    )
    mapping = (
        "format: line\npattern: 'T(?P<ms>[0-9]+) H(?P<h>[-0-9.]+)'\n"
        "heave: {field: h, invalid_values: 7777}\ndevice_time: {field: ms, unit: ms}\n"
    )
    sea = imported(tmp_path, text, mapping, "mru.log")
    assert sea.start == pytest.approx(BEGUN.timestamp(), abs=1e-3)
    assert_is_the_sine(sea)
    with pytest.raises(BagError, match=r"device_time = \d\.\d*e\+12 s, at most .* check its unit"):
        imported(tmp_path, text, mapping.replace(", unit: ms", ""), "mru.log")
    with pytest.raises(BagError, match=r"\d wrong checksums: check the map's"):
        wrong = mapping.replace("pattern: 'T", "checksum: xor\npattern: '(?P<checksum>T)")
        imported(tmp_path, text, wrong, "mru.log")


@pytest.mark.parametrize("places", [[100], [700, 1500], [2000, 2001]])
def test_a_time_that_is_wrong_costs_its_sample_alone(tmp_path, places):
    """An hour ahead; all that came after it was left out."""
    text = "".join(
        f"T{1000.0 * (BEGUN.timestamp() + t + 3600.0 * (n in places)):.0f} H{up(t):.4f}\n" for n, t in enumerate(TIMES)
    )
    mapping = (
        "format: line\npattern: 'T(?P<ms>[0-9]+) H(?P<h>[-0-9.]+)'\nheave: h\ndevice_time: {field: ms, unit: ms}\n"
    )
    sea = imported(tmp_path, text, mapping, "mru.log")
    assert sea.time[-1] == pytest.approx(TIMES[-1] - TIMES[0], abs=0.1)
    assert any(note.startswith(f"heave: {len(places)} sample") and "goes back by" in note for note in sea.notes)


def test_samples_on_whole_seconds_are_spread_over_them(tmp_path):
    text = "".join(f"T{math.floor(BEGUN.timestamp() + t + 0.04)} H{up(t):.4f}\n" for t in TIMES)
    mapping = "format: line\npattern: 'T(?P<s>[0-9]+) H(?P<h>[-0-9.]+)'\nheave: h\ndevice_time: {field: s, unit: s}\n"
    sea = imported(tmp_path, text, mapping, "mru.log")
    assert_is_the_sine(sea)
    assert "time: 10 rows on each stamp, spread evenly over 1 s" in sea.notes


def test_a_log_of_datagrams_is_read_by_their_layout_and_their_counter_that_wraps(tmp_path):
    """A counter of 16 bits in 10 ms wraps each 655 s; 0x8000 is no heave."""
    data = b"".join(
        struct.pack(">HhB", round(60_000 + 10 * n) % 65_536, -32768 if n in (500, 501) else round(1e3 * up(t)), 7)
        for n, t in enumerate(TIMES)
    )
    mapping = (
        "format: datagram\nlayout: {count: uint16, heave: int16, kind: uint8=7}\n"
        "heave: {field: heave, unit: mm}\ndevice_time: {field: count, unit: ms, scale: 10.0}\n"
    )
    sea = imported(tmp_path, data, mapping, "mru.bin")
    heave = sea.position[:, 2]
    truth = np.array([up(t) for t in sea.time])
    assert sea.time[-1] > 230.0
    assert np.abs(heave - (truth - truth.mean())).max() < 0.01
