"""TSS1: examples printed by Coda Octopus, NovAtel and a POS MV on a research vessel; 27 characters with their end.

Where a page shows one space for two, the second is put back: the texts say that it is there.
"""

import math

import pytest
from heave_devices.formats.tss1 import Tss1Decoder
from heave_node.interface.codes import MruStatus

DEGREE = math.radians(1.0)


def test_the_example_of_novatel():
    """Fields as NovAtel decodes them: FFCA is -54 digits of 0.0625 cm/s^2, heave -0.03 m, roll -3.25, pitch 3.19."""
    (sample,) = Tss1Decoder().feed(b":00FFCA -0003F-0325  0319\r\n")
    assert sample.values == pytest.approx(
        {
            "horizontal_acceleration": 0.0,
            "heave_acceleration": -54 * 0.000625,
            "heave": -0.03,
            "roll": -3.25 * DEGREE,
            "pitch": -3.19 * DEGREE,
        }
    )
    assert sample.status is MruStatus.OK
    assert sample.time is None


def test_the_example_of_coda_octopus_is_settling():
    (sample,) = Tss1Decoder().feed(b":053C22  0000f-0046 -0563\r\n")
    assert sample.status is MruStatus.SETTLING
    assert sample.values["heave_acceleration"] == pytest.approx(0x3C22 * 0.000625)
    assert sample.values["pitch"] == pytest.approx(5.63 * DEGREE), "bow down"


def test_a_stamp_before_the_line_of_a_log_is_passed_over():
    """A line of a ship's log, with what its documentation reads in it: heave 13 cm, roll -0.67, pitch 0.35."""
    (sample,) = Tss1Decoder().feed(b"MRU 2013/07/23 20:00:02.077 POSMV :090048  0013F-0067  0035\r\n")
    assert sample.values["heave"] == pytest.approx(0.13)
    assert sample.values["roll"] == pytest.approx(-0.67 * DEGREE)


def test_what_is_wrong_is_counted():
    decoder = Tss1Decoder()
    assert not decoder.feed(b":053C22  0000f-00\r\n:053C2G  0000f-0046 -0563\r\nhello\r\n")
    assert decoder.feed(b":053C22  0000f:053C22  0000f-0046 -0563\r\n")
    assert (decoder.counters.incomplete_lines, decoder.counters.malformed) == (2, 2)
