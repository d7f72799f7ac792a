"""Kongsberg's binary formats: frames built from the tables of the EK80 reference manual, field by field."""

import math
import struct

import pytest
from heave_devices.formats.kongsberg import EmAttitudeDecoder, KmBinaryDecoder
from heave_devices.formats.sample import TimeBase

DEGREE = math.radians(1.0)


def km_binary(heave=0.5, *, status=0, roll=2.0, seconds=1_700_000_000, nanoseconds=250_000_000):
    """Return a datagram: offsets and types as the manual's table has them, in its order."""
    words = struct.pack("<4sHHIII", b"#KMB", 132, 1, seconds, nanoseconds, status)
    position = struct.pack("<ddf", 59.0, 10.0, 40.0)
    attitude = struct.pack("<ffff", roll, 1.0, 90.0, heave)
    rates = struct.pack("<fff", 0.1, 0.2, 0.3)
    velocity = struct.pack("<fff", 1.0, 2.0, 0.25)
    errors = struct.pack("<fffffff", 1.0, 1.0, 1.0, 0.02, 0.02, 0.1, -1.0)
    acceleration = struct.pack("<fff", 0.0, 0.0, 0.75)
    delayed = struct.pack("<IIf", seconds - 60, 0, 0.4)
    return words + position + attitude + rates + velocity + errors + acceleration + delayed


def test_km_binary_is_heave_down_roll_port_up_pitch_bow_up_and_utc():
    assert len(km_binary()) == 132, "the manual's table adds up to it"
    (sample,) = KmBinaryDecoder().feed(km_binary())
    values = sample.values
    assert (values["heave"], values["heave_rate"], values["heave_acceleration"]) == (-0.5, -0.25, -0.75)
    assert values["roll"] == pytest.approx(2.0 * DEGREE)
    assert values["pitch"] == pytest.approx(-1.0 * DEGREE)
    assert values["delayed_heave"] == pytest.approx(-0.4)
    assert "heave_sigma" not in values, "-1 is not implemented"
    assert (sample.time, sample.time_base) == (1_700_000_000.25, TimeBase.UNIX)


@pytest.mark.parametrize(
    ("bit", "gone"), [(1, {"roll", "pitch"}), (3, {"heave", "heave_rate"}), (4, {"heave_acceleration"})]
)
def test_a_status_bit_calls_its_quantities_invalid_and_a_reduced_one_does_not(bit, gone):
    bad, reduced = KmBinaryDecoder().feed(km_binary(99.0, status=1 << bit) + km_binary(status=1 << (bit + 16)))
    assert gone <= bad.invalid
    assert not gone & set(bad.values)
    assert gone <= set(reduced.values)


def test_km_binary_that_is_cut_off_is_not_read():
    decoder = KmBinaryDecoder()
    cut = km_binary(7.0)[:70]
    samples = decoder.feed(b"noise#KM" + cut + km_binary(0.5) + km_binary(0.25) + km_binary()[:20])
    assert [sample.values["heave"] for sample in samples] == [-0.5, -0.25]
    assert decoder.counters.malformed == 1
    decoder.end()
    assert decoder.counters.incomplete_lines == 1


def em3000(heave=50, *, status=0x90, roll=-300, pitch=120, heading=9000):
    return struct.pack("<BBhhhH", status, 0x90, roll, pitch, heave, heading)


def test_em_attitude_is_heave_up():
    first, second, last = EmAttitudeDecoder().feed(em3000() + em3000(51) + em3000(52))
    assert first.values == pytest.approx(
        {"roll": -3.0 * DEGREE, "pitch": -1.2 * DEGREE, "heave": 0.5, "heading": 90.0 * DEGREE}
    )
    assert second.values["heave"] == 0.51
    assert last.values["heave"] == 0.52, "in step, no frame waits for the next one"


@pytest.mark.parametrize(
    ("status", "is_good"), [(0x00, True), (0x90, True), (0x99, True), (0x9A, False), (0xA0, False)]
)
def test_em_attitude_says_by_its_first_byte_whether_it_is_valid(status, is_good):
    samples = EmAttitudeDecoder().feed(em3000(99, status=status) * 2)
    assert all(("heave" in sample.values) == is_good for sample in samples)
    assert all(("heave" in sample.invalid) != is_good for sample in samples)


def test_em_attitude_finds_its_step_again_and_a_datagram_needs_no_second_frame():
    decoder = EmAttitudeDecoder()
    samples = decoder.feed(b"\x90" + em3000(1) + em3000(2) + b"\x07" + em3000(3) + em3000(4))
    assert [round(100 * sample.values["heave"]) for sample in samples] == [1, 2, 3, 4]
    assert decoder.counters.malformed == 1
    alone = EmAttitudeDecoder()
    assert not alone.feed(em3000())
    assert len(alone.end()) == 1


def test_em_attitude_out_of_its_valid_range_is_not_read():
    """The manual: heave +-9.99 m, angles +-179.99 degrees; outside it is not valid, and rejected."""
    assert not EmAttitudeDecoder().feed(em3000(1000) * 3)
