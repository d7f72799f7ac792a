"""Modbus registers: names, blocks of one request, and numbers by hand."""

import struct

import pytest
from heave_devices.formats.registers import blocks_of, register_of, values_in, words_for
from hypothesis import given
from hypothesis import strategies as st


def test_a_block_reads_what_lies_together_and_no_register_between():
    names = ("input:0:int32", "input:2", "input:10:float32", "holding:3", "input:2.4")
    blocks = [(block.table, block.address, block.count) for block in blocks_of(map(register_of, names))]
    assert blocks == [("holding", 3, 1), ("input", 0, 3), ("input", 10, 2)]


@pytest.mark.parametrize(("order", "words"), [("big", [0xFFFF, 0xFFFE]), ("little", [0xFFFE, 0xFFFF])])
def test_minus_two_in_two_registers(order, words):
    (block,) = blocks_of([register_of("holding:8:int32")])
    assert values_in(block, words, order) == {"holding:8:int32": -2.0}
    assert words_for(block, {"holding:8:int32": -2.0}, order) == words


@given(st.floats(width=32, allow_nan=False, allow_infinity=False))
def test_a_float_takes_the_bits_of_ieee_754(value):
    (block,) = blocks_of([register_of("holding:0:float32")])
    assert words_for(block, {"holding:0:float32": value}, "big") == list(struct.unpack(">HH", struct.pack(">f", value)))


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("40001", "is no register, such as input:4:int32"),
        ("input:4:int24", "int24 must be one of int16"),
        ("coil:4:int16", "a coil is one bit"),
        ("input:4.16", "uint16 has no bit 16"),
        ("input:65535:int32", "addresses end at 65535"),
    ],
)
def test_a_register_that_cannot_be_is_refused(name, words):
    with pytest.raises(ValueError, match=words):
        register_of(name)


def test_a_number_that_does_not_fit_is_refused_with_its_register():
    (block,) = blocks_of([register_of("holding:0:int16")])
    with pytest.raises(ValueError, match="holding:0:int16: 40000 does not fit int16: check unit and scale"):
        words_for(block, {"holding:0:int16": 40_000.0}, "big")
