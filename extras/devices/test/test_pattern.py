"""Lines by a pattern: a winch's display as its manual describes it, and a load cell's."""

import pytest
from heave_devices.adapt.shipped import find_map
from heave_devices.formats.pattern import PatternDecoder

LCI_90 = r"(?P<covered>RD,(?P<tension>[^,]{8}),(?P<speed>[^,]{8}),(?P<payout>[^,]{8}),)(?P<checksum>\d{4})$"


def rd(tension: str, speed: str, payout: str) -> bytes:
    """Return a line as section 6.6.4 of the LCI-90's manual has it: the checksum is the sum of what is before it."""
    covered = f"RD,{tension},{speed},{payout},"
    return f"{covered}{sum(covered.encode()):04d}\r\n".encode()


def test_a_line_of_the_winch_display_with_the_sum_of_its_characters():
    decoder = PatternDecoder(LCI_90, "sum")
    (sample,) = decoder.feed(b"\x00\x7f" + rd("00123.45", "-001.250", "0345.600"))
    assert sample.values == {"tension": 123.45, "speed": -1.25, "payout": 345.6}
    assert not decoder.feed(rd("00123.45", "-001.250", "0345.600").replace(b"123", b"124"))
    assert decoder.counters.checksum_errors == 1


def test_a_line_with_the_checksum_of_nmea():
    decoder = PatternDecoder(r"\$(?P<covered>LC,(?P<tension>[-0-9.]+))\*(?P<checksum>[0-9A-F]{2})", "xor")
    # by hand: L ^ C ^ , ^ 5 = 4C ^ 43 ^ 2C ^ 35 = 16
    assert decoder.feed(b"$LC,5*16\r\n")[0].values == {"tension": 5.0}
    assert not decoder.feed(b"$LC,6*16\r\n")
    assert PatternDecoder(r"\$LC,(?P<tension>[-0-9.]+)\*(?P<checksum>..)", "xor").feed(b"$LC,5*16\r\n")


def test_words_are_kept_beside_numbers():
    (sample,) = PatternDecoder(r"(?P<state>ST|US),GS,(?P<force>[+-][\d.]+)kN").feed(b"US,GS,+0012.50kN\r\n")
    assert sample.values == {"force": 12.5}
    assert sample.words == {"state": "US"}


@pytest.mark.parametrize(
    ("pattern", "checksum", "words"),
    [
        ("(", "", "no regular expression"),
        ("abc", "", "no named group"),
        ("(?P<a>.)", "crc", "must be one of xor, sum"),
        ("(?P<a>.)", "sum", "group"),
        ("(?P<a>.)(?P<checksum>.)", "", "needs its kind"),
    ],
)
def test_a_pattern_that_cannot_be_is_refused(pattern, checksum, words):
    with pytest.raises(ValueError, match=words):
        PatternDecoder(pattern, checksum)


@pytest.mark.parametrize(
    "head",
    [
        "#INSPVAA,COM1,0,31.0,FINESTEERING,2371,54418.000,00000000,54e2,13386",
        "%INSPVASA,2371,54418.000",
    ],
)
def test_an_ascii_log_of_novatel_with_a_long_head_or_a_short_one(head):
    """INSPVAS has the body of INSPVA (OEM7 Commands and Logs Reference Manual, log 508)."""
    body = "2371,54418.000000000,58.97,5.73,45.0000,0.1,0.2,0.1000,0.5,1.2,90.0,INS_SOLUTION_GOOD"
    decoder = find_map("novatel_ascii").decoder()
    (sample,) = decoder.feed(f"{head};{body}*00000000\r\n".encode())
    assert (sample.values["height"], sample.values["up"], sample.values["pitch"]) == (45.0, 0.1, 1.2)
    assert sample.words["status"] == "INS_SOLUTION_GOOD"
