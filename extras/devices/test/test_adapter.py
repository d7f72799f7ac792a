"""A device behind its map: bytes or messages in, readings of the suite out."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from heave_devices.formats.sample import Sample, TimeBase
from heave_devices.live.adapter import Adapter, WinchReading
from heave_devices.maps.device_map import device_map_of
from heave_node.interface.codes import MruStatus
from heave_node.interface.sensors import mru_reading

from extras.devices.test.test_nmea import sealed

PNORSUB2 = {
    "format": "nmea",
    **{name: f"PNORSUB2.{name}" for name in ("heave", "heave_rate", "roll", "pitch")},
}


def mru(adapter, *sentences, step=0.1):
    decoder = adapter.device.decoder()
    made = [adapter.on_samples(decoder.feed(line), step * n) for n, line in enumerate(sentences)]
    return [mru_reading(reading) for readings in made for _, reading in readings]


def norsub(heave, rate=0.0, ok=1, milliseconds=1000, pitch=0.0):
    return sealed(f"PNORSUB2,{milliseconds},2,0.0,{pitch},0.0,{heave},{rate},{ok}")


def test_a_sentence_becomes_a_reading_of_the_boom_tip():
    adapter = Adapter(device_map_of("m", PNORSUB2))
    first, second = mru(adapter, norsub(1.35, 0.2), norsub(1.3))
    assert (first.heave, first.heave_rate, first.status, first.sequence) == (-1.35, -0.2, MruStatus.OK, 1)
    assert second.sequence == 2
    assert math.isnan(first.heave_acceleration)
    assert first.time == 0.0, "the time of arrival counts"


def test_an_invalid_sample_is_told_and_holds_no_heave():
    adapter = Adapter(device_map_of("m", PNORSUB2))
    bad, big = mru(adapter, norsub(99.0, ok=0), norsub(99.0))
    assert bad.status == big.status == MruStatus.INVALID
    assert math.isnan(bad.heave)
    assert math.isnan(big.heave), "99 m is no heave, whatever the status says"


FAR = 10.0**9
"""Stamp of a counter of 0 [s]: no simulated time is near it, so that it is not taken for one."""


def test_its_own_clock_stamps_it_where_the_map_says_so():
    adapter = Adapter(device_map_of("m", {**PNORSUB2, "clock": "own"}))
    (reading,) = mru(adapter, norsub(0.0, milliseconds=203798))
    assert reading.time == pytest.approx(FAR + 203.798, abs=1e-6)


def test_roll_and_pitch_of_another_sentence_are_used_while_they_are_fresh():
    content = {
        "format": "nmea",
        "heave": "PSXN23.heave",
        "heave_rate": "PSXN24.heave_rate",
        "timeout": 0.5,
    }
    adapter = Adapter(device_map_of("m", content))
    rate, motion = sealed("PSXN,24,0,0,0,-0.25"), sealed("PSXN,23,0,0,0,-1.0")
    readings = mru(adapter, rate, motion, motion, motion, motion, motion, motion, motion)
    assert readings[0].heave_rate == 0.25
    assert math.isnan(readings[-1].heave_rate), "an old rate is not measured"
    assert readings[-1].heave == 1.0


def test_a_lever_arm_carries_heave_by_pitch():
    adapter = Adapter(device_map_of("m", {**PNORSUB2, "lever_arm": [10.0, 0.0, 0.0]}))
    level, up = mru(adapter, norsub(0.0), norsub(0.0, pitch=2.0), step=1e-3)
    assert level.heave == 0.0
    assert up.heave == pytest.approx(10.0 * math.sin(math.radians(2.0)), rel=1e-3), "bow up lifts what is forward"


def test_a_line_gives_a_winch_and_a_load_cell():
    content = {
        "format": "line",
        "pattern": "(?P<t>[-.0-9]+),(?P<p>[-.0-9]+)",
        "tension": {"field": "t", "unit": "kN", "sigma": 100.0},
        "payout": {"field": "p", "positive": "in", "zero_at_start": True},
    }
    adapter = Adapter(device_map_of("m", content))
    made = [adapter.on_samples([Sample("LINE", {"t": 25.0, "p": 300.0 - 0.5 * n})], 0.1 * n) for n in range(10)]
    (cell_topic, cell), (winch_topic, winch) = made[-1]
    assert (cell_topic, winch_topic) == ("winch/load_cell", "winch/state")
    assert cell.numbers == (25e3, 100.0)
    assert isinstance(winch, WinchReading)
    assert winch.payout == pytest.approx(4.5)
    assert winch.payout_rate == pytest.approx(5.0), "by its last positions, since it says none"
    assert winch.tension == 25e3
    assert math.isnan(winch.brake)


def test_messages_of_two_topics_make_one_reading():
    twist = {"topic": "/v", "type": "t", "field": "twist.linear.z"}
    content = {
        "clock": "own",
        "heave": {**twist, "velocity": True, "high_pass": 200.0},
        "heave_rate": twist,
        "roll": {"topic": "/i", "type": "t", "field": "orientation", "part": "roll"},
    }
    adapter = Adapter(device_map_of("m", content))
    turn = SimpleNamespace(orientation=SimpleNamespace(x=math.sin(0.05), y=0.0, z=0.0, w=math.cos(0.05)))
    omega, readings = 2.0 * math.pi / 8.0, []
    for n in range(8000):
        t = 0.05 * n
        assert not adapter.on_message("/i", turn, round(t * 1e9), 0.0)
        velocity = SimpleNamespace(twist=SimpleNamespace(linear=SimpleNamespace(z=omega * math.cos(omega * t))))
        ((_, reading),) = adapter.on_message("/v", velocity, 1 + round(t * 1e9), 0.0)
        readings.append(mru_reading(reading))
    assert readings[100].status == MruStatus.SETTLING
    last = readings[-320:]
    assert {reading.status for reading in last} == {MruStatus.OK}
    assert last[-1].roll == pytest.approx(0.1)
    # the theory: a phase lead of 2 * 0.7 * 8 / 200 rad; 6 % of the amplitude at most
    error = [reading.heave - math.sin(omega * reading.time) for reading in last]
    assert np.max(np.abs(error)) < 0.07


def test_sentences_without_a_time_are_stamped_by_their_stated_rate_and_not_by_a_late_arrival():
    arrivals = [5.0, 5.1, 5.36, 5.36, 5.4]  # the third was handed over 0.16 s late, together with the fourth
    by_rate = {"clock": "receipt", "sample_rate": 10, "format": "nmea", "heave": "PSXN23.heave"}
    stamps = [stamps_of(by_rate, arrivals), stamps_of({**by_rate, "sample_rate": 0}, arrivals)]
    assert np.diff(stamps[0]) * 1e-9 == pytest.approx(0.1, abs=1e-6)
    assert stamps[1] == [0] * 5, "the time of arrival counts"


def stamps_of(given, arrivals):
    """Stamps [ns] of one PSXN,23 sentence at each of the `arrivals` [s]."""
    adapter = Adapter(device_map_of("m", given))
    sample = Sample("PSXN23", {"heave": 0.5})
    return [reading.stamp for now in arrivals for _, reading in adapter.on_samples([sample], now)]


PLC = {
    "source": {"modbus": "127.0.0.1:502"},
    "payout": {"field": "input:0:int32", "unit": "mm", "scale": 0.1, "positive": "in", "zero_at_start": True},
    "payout_rate": {"field": "input:2:int32", "unit": "mm/s", "scale": 0.1, "positive": "in"},
    "device_time": {"field": "input:5", "unit": "ms", "scale": 10.0},
}
"""A drum at 10 readings per second, and a counter of cycles of 10 ms in 16 bits."""


def read_plc(adapter, now, payout, cycles, rate=0.0):
    """Return the reading of a drum, and of its count of cycles."""
    values = {"input:0:int32": -1e4 * payout, "input:2:int32": -1e4 * rate, "input:5": float(cycles % 65_536)}
    ((_, reading),) = adapter.on_samples([Sample("MODBUS", values)], now)
    return reading


def test_a_plc_stamps_by_its_own_count_over_its_wrap_and_whatever_the_arrivals():
    adapter = Adapter(device_map_of("m", PLC))
    assert adapter.device.clock == "own"
    first = 65_500
    stamps = [read_plc(adapter, 0.1 * k + 0.06 * (k % 2), 0.0, first + 10 * k).stamp for k in range(20)]
    assert np.diff(stamps) * 1e-9 == pytest.approx(0.1, abs=1e-6)


def test_a_plc_that_lost_its_count_is_counted_on_and_named():
    adapter = Adapter(device_map_of("m", PLC))
    before = [read_plc(adapter, 0.1 * k, 40.0 - 0.001 * k, 30_000 + 10 * k) for k in range(10)]
    after = [read_plc(adapter, 3.0 + 0.1 * k, 0.0, 5 + 10 * k) for k in range(10)]
    assert [reading.payout for reading in after] == pytest.approx(10 * [before[-1].payout])
    assert np.diff([reading.stamp for reading in after]) * 1e-9 == pytest.approx(0.1, abs=1e-6)
    assert after[0].stamp > before[-1].stamp
    assert adapter.drum_count.jumps == 1
    assert "clock restarted" in adapter.drum_count.words
    # a set-point of the controller is sent in the drive's own count: where the controller has it, less this
    assert adapter.taker.zeros["payout"] + adapter.newest["payout"] == pytest.approx(0.0)


@pytest.mark.parametrize(
    ("unit", "first"),
    [("s", 1.764e9), ("ms", 1.764e12), ("us", 1.764e15), ("s", 3.0), ("s", 3.847e9), ("ms", 6.39e13)],
)
def test_a_device_time_of_any_epoch_stamps_within_what_a_stamp_holds(unit, first):
    """Seconds since 1970, as a PLC with a clock sends them, since its start, since 1904 (LabVIEW) and the year 1."""
    time = {"field": "input:9:float64", "unit": unit}
    adapter = Adapter(device_map_of("m", {"source": {"modbus": "1"}, "payout": "input:0", "device_time": time}))
    step = 0.1 * {"s": 1.0, "ms": 1e3, "us": 1e6}[unit]
    stamps = []
    for k in range(5):
        sample = Sample("MODBUS", {"input:0": 1.0, "input:9:float64": first + step * k})
        stamps += [reading.stamp for _, reading in adapter.on_samples([sample], 50.0 + 0.1 * k)]
    assert all(0 < stamp < 2**31 * 10**9 for stamp in stamps)
    resolution = np.spacing(first) / step * 0.1
    assert np.diff(stamps) * 1e-9 == pytest.approx(0.1, abs=1e-5 + 2.0 * resolution)


@pytest.mark.parametrize("wrong", [1e300, math.inf, math.nan, -5.0, 1e12])
def test_a_device_time_that_cannot_be_is_named_and_the_arrival_counts(wrong):
    time = {"field": "input:9:float64", "unit": "s"}
    adapter = Adapter(device_map_of("m", {"source": {"modbus": "1"}, "payout": "input:0", "device_time": time}))
    sample = Sample("MODBUS", {"input:0": 1.0, "input:9:float64": wrong})
    ((_, reading),) = adapter.on_samples([sample], 50.0)
    assert reading.stamp == 0
    assert wrong == -5.0 or adapter.taker.counters.implausible == {"device_time": 1}


def test_one_time_that_is_wrong_is_rejected_and_counted_and_the_drum_that_moves_has_not_jumped():
    adapter = Adapter(device_map_of("m", PLC))
    cycles = [30_000 + 10 * k for k in range(20)]
    cycles[9] = 60_000
    readings = [read_plc(adapter, 0.1 * k, 0.1 * k, count, 1.0) for k, count in enumerate(cycles)]
    stamps = [reading.stamp for reading in readings]
    assert np.diff(stamps) * 1e-9 == pytest.approx(0.1, abs=1e-6)
    (clock,) = adapter.clocks.values()
    assert (clock.glitches, clock.restarts, adapter.drum_count.jumps) == (1, 0, 0)


def test_a_sample_that_is_older_than_one_before_is_not_used():
    """As one of NMEA over UDP that another way has held up, or that a second sender sent."""
    content = {"format": "nmea", "clock": "own", "heave": {"field": "PASHR.heave", "positive": "down"}}
    adapter = Adapter(device_map_of("m", content))
    times = [100.0, 100.1, 100.05, 100.2, 40.0, 100.3]
    made = [
        adapter.on_samples([Sample("PASHR", {"heave": 0.5}, time=time, time_base=TimeBase.DAY)], 3.0 + 0.1 * k)
        for k, time in enumerate(times)
    ]
    assert [len(readings) for readings in made] == [1, 1, 0, 1, 1, 1]
    stamps = [reading.stamp * 1e-9 for readings in made for _, reading in readings]
    assert stamps == pytest.approx([100.0, 100.1, 100.2, 100.3, 100.3])
    (clock,) = adapter.clocks.values()
    assert (clock.late, clock.glitches, clock.restarts) == (1, 1, 0)


@pytest.mark.parametrize(("kind", "first"), [("uint16", 65_300), ("int16", 32_600)])
def test_a_count_in_a_whole_number_goes_on_past_its_end(kind, first):
    """Millimetres in 16 bits begin again each 65 m; it was taken for a lost count, and what the drum moved was lost."""
    bits = int(kind.lstrip("uint"))
    least = 0 if kind.startswith("u") else -(1 << bits - 1)
    counts = [(first + 100 * k - least) % (1 << bits) + least for k in (0, 1, 2, 3, 2, 1)]
    field = f"input:0:{kind}"
    payout = {"field": field, "unit": "mm", "zero_at_start": True}
    adapter = Adapter(device_map_of("m", {"source": {"modbus": "1"}, "payout": payout}))
    found = [adapter.on_samples([Sample("MODBUS", {field: float(one)})], 0.05 * k) for k, one in enumerate(counts)]
    assert [reading.payout for ((_, reading),) in found] == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.2, 0.1])
    assert adapter.drum_count.jumps == 0


def test_a_drum_whose_first_value_stands_for_none_in_a_way_that_nobody_stated_is_read_once_it_has_one():
    """-9999 m can be, so it is the zero; the true 12.3 m then was 10 km from it, and was refused for ever."""
    adapter = Adapter(
        device_map_of("m", {"source": {"modbus": "1"}, "payout": {"field": "input:0", "zero_at_start": True}})
    )
    read = [-9999.0] * 3 + [12.3, 12.31, 12.32]
    found = [adapter.on_samples([Sample("MODBUS", {"input:0": one})], 0.05 * k) for k, one in enumerate(read)]
    assert [reading.payout for ((_, reading),) in found] == pytest.approx([0.0, 0.0, 0.0, 0.0, 0.01, 0.02])
    assert "jumped" in adapter.drum_count.words
