"""Sentences of motion sensors: examples of each maker's own documentation, with the signs that it states."""

import functools
import math
import operator

import pytest
from heave_devices.formats.nmea import NmeaDecoder
from heave_devices.formats.sample import TimeBase
from heave_node.interface.codes import MruStatus
from hypothesis import given
from hypothesis import strategies as st

DEGREE = math.radians(1.0)


def sealed(body: str) -> bytes:
    """Return a sentence with the checksum that NMEA 0183 asks for: XOR of all characters between $ and *."""
    return f"${body}*{functools.reduce(operator.xor, body.encode(), 0):02X}\r\n".encode()


def read(*sentences: bytes):
    decoder = NmeaDecoder()
    return decoder, [sample for line in sentences for sample in decoder.feed(line)]


def test_psxn_23_is_roll_port_up_pitch_bow_up_and_heave_down():
    """Samples printed with the Seapath's format; positive down is heave of -0.13 m here, bow up a negative pitch."""
    _, (quality, motion) = read(b"$PSXN,20,0,0,0,0*3B\r\n", b"$PSXN,23,0.30,-0.97,298.57,0.13*1B\r\n")
    assert quality.kind == "PSXN20"
    assert motion.kind == "PSXN23"
    assert motion.values == pytest.approx(
        {"roll": 0.30 * DEGREE, "pitch": 0.97 * DEGREE, "heading": 298.57 * DEGREE, "heave": -0.13}
    )
    assert motion.time is None, "PSXN has no time"


def test_psxn_20_calls_the_motion_that_follows_invalid():
    _, (_, motion, _, good) = read(
        sealed("PSXN,20,0,2,0,0"), sealed("PSXN,23,1,2,3,99.0"), sealed("PSXN,20,0,1,0,0"), sealed("PSXN,23,1,2,3,0.5")
    )
    assert "heave" not in motion.values
    assert motion.invalid == {"heave"}
    assert good.values["heave"] == -0.5, "reduced performance is not invalid"


def test_psxn_22_and_24_are_read_and_other_numbers_are_unknown():
    decoder, (gyro, rates) = read(sealed("PSXN,22,0.43,0.09"), sealed("PSXN,24,1.0,2.0,3.0,0.4"), sealed("PSXN,26,0,1"))
    assert gyro.values == pytest.approx({"gyro_calibration": 0.43 * DEGREE, "gyro_offset": 0.09 * DEGREE})
    assert rates.values["heave_rate"] == -0.4
    assert rates.values["pitch_rate"] == pytest.approx(-2.0 * DEGREE)
    assert decoder.counters.unknown == {"PSXN,26": 1}


def test_pashr_of_novatel_and_of_applanix():
    """NovAtel OEM7 log 1177, and a line of a POS MV that is published as one of good quality."""
    _, (novatel, applanix) = read(
        b"$PASHR,163029.000,158.09,T,-0.30,+0.31,+0.01,0.029,0.029,0.059,1,1*3B\r\n",
        b"$PASHR,183944.821,74.52,T,-1.63,1.51,0.14,0.020,0.020,0.012,2,1*05\r\n",
    )
    assert novatel.values["roll"] == pytest.approx(-0.30 * DEGREE)
    assert novatel.values["pitch"] == pytest.approx(-0.31 * DEGREE)
    assert novatel.values["heave"] == 0.01, "as it is sent: a map says which way is positive"
    assert (novatel.time, novatel.time_base) == (16 * 3600 + 30 * 60 + 29.0, TimeBase.DAY)
    assert applanix.values["aiding_status"] == 2.0


def test_an_empty_pashr_holds_nothing():
    """SBG Systems: fields are empty if invalid."""
    _, (empty,) = read(b"$PASHR,,,T,,,,,,,0,1*21\r\n")
    assert empty.values == {"aiding_status": 0.0, "imu_status": 1.0}
    assert empty.time is None


def test_phoct_is_pitch_bow_down_and_heave_up_with_a_flag_for_each():
    """First line: as an OCTANS sends it. Second: SBG Systems' own example, attitude invalid, heave valid."""
    _, (octans, sbg) = read(
        b"$PHOCT,01,192621.400,T,00,080.378,T,-000.106,T,-03.105,T,+00.220,T,+00.084,-00.025,+00.013,+00.235,+00.024,"
        b"+00.078,-0008.03*09\r\n",
        b"$PHOCT,01,000201.000,E,00,356.592,E,+000.225,E,+00.039,E,+00.023,T,+00.023,+00.016,+00.003,+00.002,-00.001,"
        b"+00.000,+0001.96*04\r\n",
    )
    assert octans.values["pitch"] == pytest.approx(-3.105 * DEGREE)
    assert (octans.values["heave"], octans.values["heave_rate"], octans.values["surge"]) == (0.084, 0.235, -0.025)
    assert octans.time == 19 * 3600 + 26 * 60 + 21.4
    assert sbg.values["heave"] == 0.023
    assert {"roll", "pitch", "heading"} <= sbg.invalid
    assert sbg.time is None, "its UTC is invalid"


@pytest.mark.parametrize(("flag", "status"), [("E", MruStatus.OK), ("I", MruStatus.SETTLING)])
def test_phoct_that_calls_heave_invalid_gives_none(flag, status):
    body = f"PHOCT,01,192621.400,T,00,80.3,T,-0.1,T,-3.1,T,+99.0,{flag},+99.0,0,0,99.0,0,0,-8.03"
    _, (sample,) = read(sealed(body))
    assert not {"heave", "heave_rate", "heave_primary", "surge"} & set(sample.values)
    assert sample.status is status


def test_pnorsub_and_pnorsub2_are_z_down():
    """Fields of Norwegian Subsea's examples; their printed checksum is that of neither, so it is computed here."""
    _, (plain, two, bad) = read(
        sealed("PNORSUB,203798,2,+0.117,-0.505,259.893,1.350,1"),
        sealed("PNORSUB2,203798,2,+0.117,-0.505,259.893,1.350,0.023,1"),
        sealed("PNORSUB2,203798,2,+0.117,-0.505,259.893,99.0,0.023,0"),
    )
    assert plain.values == pytest.approx(
        {"roll": 0.117 * DEGREE, "pitch": 0.505 * DEGREE, "heading": 259.893 * DEGREE, "heave": -1.35}
    )
    assert two.values["heave_rate"] == -0.023
    assert (two.time, two.time_base) == (203.798, TimeBase.COUNTER)
    assert not bad.values
    assert "heave" in bad.invalid


def test_pencr_is_hexadecimal_and_needs_no_checksum():
    """SMC IMU-108: 90 degrees of rotation, 45 of the first knuckle, 22 of the second, as printed (to a degree)."""
    _, (crane, long) = read(b"$PENCR,3FFF,2000,0FA0,0000,0000\r\n", b"$PENCR,0000,3FFF,03E8,0000,0000\r\n")
    assert [round(math.degrees(crane.values[f"angle_{n}"])) for n in (1, 2, 3, 4)] == [90, 45, 22, 0]
    assert long.values["extension_3"] == 10.0, "03E8 is 1000 cm"


def test_zda_is_utc_of_any_talker():
    _, (gps, inertial) = read(b"$GPZDA,172809.456,12,07,1996,00,00*57\r\n", sealed("INZDA,000000.00,01,01,1970,,"))
    assert gps.time == 837192489.456, "1996-07-12T17:28:09.456Z"
    assert inertial.time == 0.0


def test_what_is_wrong_is_counted_by_its_kind():
    decoder, samples = read(
        b"$PSXN,23,0.30,-0.97,298.57,9.99*1B\r\n",  # a digit was changed
        b"$PSXN,23,0.30,-0.97,298.57,0.13\r\n",  # no checksum
        b"$PSXN,23,0.30,-0.9$PSXN,23,0.30,-0.97,298.57,0.13*1B\r\n",  # a half one before a whole one
        sealed("PSXN,23,nan,1e9,0x1,0"),
        sealed("GPGGA,1,2"),
        b"hello\r\n",
    )
    assert len(samples) == 1
    counters = decoder.counters
    assert (counters.checksum_errors, counters.incomplete_lines, counters.malformed) == (2, 1, 2)
    assert counters.unknown == {"GPGGA": 1}


def test_a_stamp_before_a_sentence_is_passed_over():
    _, (sample,) = read(b"2013/05/06 11:00:00.805 MRU $PSXN,23,0.30,-0.97,298.57,0.13*1B\r\n")
    assert sample.values["heave"] == -0.13


def test_a_datagram_may_end_without_an_end_of_line_but_not_within_a_sentence():
    decoder = NmeaDecoder()
    assert not decoder.feed(b"$PSXN,23,0.30,-0.97,298.57,0.13*1B")
    assert len(decoder.end()) == 1
    decoder.feed(b"$PSXN,23,0.30,-0.9")
    assert not decoder.end()
    assert decoder.counters.incomplete_lines == 1


@given(st.integers(0, 33), st.integers(1, 255))
def test_a_sentence_with_a_changed_character_is_never_read(place, change):
    good = bytearray(b"$PSXN,23,0.30,-0.97,298.57,0.13*1B")
    good[place] ^= change
    decoder = NmeaDecoder()
    samples = decoder.feed(bytes(good) + b"\r\n")
    assert [dict(sample.values) for sample in samples] in ([], [SAME]), "only a letter's case, or a mark before $"


SAME = dict(read(b"$PSXN,23,0.30,-0.97,298.57,0.13*1B\r\n")[1][0].values)
