"""What every decoder of a stream keeps: the same samples whatever the pieces, and nothing raised by random bytes."""

import itertools
import math

import pytest
from heave_devices.formats.kongsberg import EmAttitudeDecoder, KmBinaryDecoder
from heave_devices.formats.nmea import NmeaDecoder
from heave_devices.formats.pattern import PatternDecoder
from heave_devices.formats.tss1 import Tss1Decoder
from hypothesis import given
from hypothesis import strategies as st

from extras.devices.test.test_kongsberg import em3000, km_binary
from extras.devices.test.test_pattern import LCI_90, rd

# what makes the decoder, a stream with whole, cut and foreign parts, and how many samples it holds
STREAMS = {
    "km_binary": (
        KmBinaryDecoder,
        b"x#KMB" + km_binary() + km_binary(0.1)[:99] + km_binary(0.2, status=8) + b"#KMB",
        2,
    ),
    "em3000": (EmAttitudeDecoder, b"\x90\x90" + em3000() + em3000(2) + b"\x01" + em3000(3) * 3, 5),
    "nmea": (
        NmeaDecoder,
        b"$PSXN,20,0,0,0,0*3B\r\n$PSXN,23,0.30,-0.97,298.57,0.13*1B\r\nrubbish\n$PENCR,3FFF,2000\r"
        b"$PASHR,163029.000,158.09,T,-0.30,+0.31,+0.01,0.029,0.029,0.059,1,1*3B\r\n"
        b"$GPZDA,172809.456,12,07,1996,00,00*57",
        5,
    ),
    "line": (
        lambda: PatternDecoder(LCI_90, "sum"),
        rd("00123.45", "-001.250", "0345.600") + b"RD,00123\r\n" + rd("00000001", "00000000", "-0000002") + b"RD,",
        2,
    ),
    "tss1": (
        Tss1Decoder,
        b":053C22  0000f-0046 -0563\r\nx:043C86  0000f-0048 -0563\n:053D1C 00\r:073D89  0000F 0052  0562",
        3,
    ),
}
BEGUN = [
    *(b"#KMB", b"#KMB\x84\0\1\0", b"\x90\x90", b"$PSXN", b"$PSXN,23", b"$PASHR,", b"$PHOCT,01,", b"$PNORSUB2,"),
    *(b"$PENCR", b"$GPZDA,", b":053C22  0000f", b"RD,00123.45,", b"\r\n"),
]
NOISE = st.one_of(
    st.binary(max_size=80),
    st.text("$PSXNAHRCTOUB20123,.*-+TEI\r\n", max_size=80).map(str.encode),
    st.text(": 0123456789ABCDEFf-\r\n", max_size=60).map(str.encode),
    st.sampled_from(BEGUN),
)


def in_pieces(decoder, data, cuts):
    """Return the samples of `data` fed in pieces that are cut at `cuts`."""
    places = [0, *sorted(cut % (len(data) + 1) for cut in cuts), len(data)]
    samples = [sample for a, b in itertools.pairwise(places) for sample in decoder.feed(data[a:b])]
    return samples + decoder.end()


@pytest.mark.parametrize("kind", STREAMS)
@given(cuts=st.lists(st.integers(0, 10_000), max_size=12))
def test_any_pieces_give_the_same_samples(kind, cuts):
    make, stream, count = STREAMS[kind]
    whole = in_pieces(make(), stream, [])
    assert len(whole) == count
    assert in_pieces(make(), stream, cuts) == whole


@given(pieces=st.lists(NOISE, max_size=20))
def test_random_bytes_never_raise_and_give_finite_numbers_only(pieces):
    for make in (*(make for make, _, _ in STREAMS.values()), lambda: NmeaDecoder(needs_checksum=False)):
        decoder = make()
        samples = [sample for piece in pieces for sample in decoder.feed(piece)] + decoder.end()
        assert all(math.isfinite(value) for sample in samples for value in sample.values.values())
