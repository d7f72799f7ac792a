"""Datagrams of a stated layout: numbers and checks by hand, and what becomes of lost, double, late and broken ones."""

import struct
import zlib

import pytest
from heave_devices.formats.datagram import DatagramDecoder, crc16, layout_of
from hypothesis import given
from hypothesis import strategies as st

FIELDS = {"mark": "uint16=0x4857", "sequence": "uint16", "time_ms": "uint32", "position": "int32", "crc": "crc32"}


def datagram(sequence, position=1500, mark=0x4857):
    body = struct.pack(">HHIi", mark, sequence % 65536, 12_345, position)
    return body + struct.pack(">I", zlib.crc32(body))


def taken(decoder, *datagrams):
    found = []
    for data in datagrams:
        found += decoder.feed(data) + decoder.end()
    return found


def test_a_datagram_is_read_as_struct_wrote_it():
    (sample,) = taken(DatagramDecoder(layout_of(FIELDS)), datagram(7))
    assert sample.values["position"] == 1500.0
    assert sample.time == pytest.approx(12.345)


def test_the_checks_are_those_of_the_catalogue_of_crc():
    # the check value of "123456789" in the catalogue of parametrised CRC algorithms: MODBUS 0x4B37, ISO-HDLC 0xCBF43926
    assert crc16(b"123456789") == 0x4B37
    layout = layout_of({"a": "uint8", "crc": "crc16"})
    assert layout.pack({"a": 1.0})[1:] == struct.pack(">H", crc16(b"\x01"))


def test_what_comes_late_or_twice_is_not_used_and_what_is_missing_is_counted():
    decoder = DatagramDecoder(layout_of(FIELDS))
    used = taken(decoder, *(datagram(number) for number in (65533, 65534, 65534, 0, 65535, 1, 4)))
    assert [sample.values["sequence"] for sample in used] == [65533, 65534, 0, 1, 4]
    counters = decoder.counters
    assert (counters.repeated, counters.late, counters.lost) == (1, 1, 2)


def test_a_sender_that_began_anew_is_heard_from_its_second_datagram_on():
    decoder = DatagramDecoder(layout_of(FIELDS))
    used = taken(decoder, datagram(30_000), datagram(0), datagram(1), datagram(2))
    assert [sample.values["sequence"] for sample in used] == [30_000, 1, 2]


@given(st.integers(0, 15), st.integers(1, 255))
def test_no_changed_byte_passes_the_check(place, change):
    data = bytearray(datagram(3))
    data[place] ^= change
    decoder = DatagramDecoder(layout_of(FIELDS))
    assert not taken(decoder, bytes(data))
    assert decoder.counters.checksum_errors == 1


@given(st.binary(max_size=64))
def test_random_bytes_are_never_used(data):
    decoder = DatagramDecoder(layout_of(FIELDS))
    assert not taken(decoder, data)


def test_another_make_is_named_by_its_first_bytes():
    decoder = DatagramDecoder(layout_of(FIELDS))
    assert not taken(decoder, datagram(1, mark=0x1234))
    assert list(decoder.counters.unknown) == ["12340001"]


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"a": "int24"}, "a: int24 must be one of int8"),
        ({"crc": "crc32", "a": "int8"}, "a: nothing may follow crc"),
        ({"a": "int8", "crc": "md5"}, "crc: md5 must be one of crc32, crc16"),
        ({"sequence": "float32"}, "sequence: must be one of uint8"),
        ({"time_us": "uint32"}, "time_us: must be one of uint64"),
        ({"mark": "uint8=300"}, "300 does not fit uint8"),
        ({"mark": "uint8=x"}, "mark: 'x' is no whole number"),
    ],
)
def test_a_layout_that_cannot_be_is_refused(fields, words):
    with pytest.raises(ValueError, match=words):
        layout_of(fields)


def test_a_number_that_does_not_fit_is_refused_and_never_wraps():
    with pytest.raises(ValueError, match="speed: 40000 does not fit int16: check unit and scale"):
        layout_of({"speed": "int16"}).pack({"speed": 40_000.0})
    with pytest.raises(ValueError, match="speed: nan cannot be sent"):
        layout_of({"speed": "int16"}).pack({"speed": float("nan")})
