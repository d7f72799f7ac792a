"""Sheets: what people see, what machines get, and what neither has."""

import math
from types import SimpleNamespace

from heave_node.sheet import Column, Sheet

NAMED = Sheet(Column("sea", "name", "name"))
SHEET = Sheet(
    NAMED,
    Column("depth km", "place.depth", "depth_m", ".2f", 1e-3),
    Column("", "place.depth", "again_m"),
    Column("words", lambda row: row.place.depth, form=lambda value: f"<{value:g}>"),
)


def row(depth):
    return SimpleNamespace(name="calm", place=SimpleNamespace(depth=depth))


def test_people_see_scaled_numbers_under_headings_and_machines_get_them_in_the_unit_of_the_key():
    assert SHEET.headings == ["sea", "depth km", "words"]
    assert SHEET.cells([row(1500.0)]) == [["calm", "1.50", "<1500>"]]
    assert SHEET.records([row(1500.0)]) == [{"name": "calm", "depth_m": 1500.0, "again_m": 1500.0}]
    assert SHEET.lines(row(2000.0))[1] == ("depth km", "2.00")


def test_a_number_that_is_not_known_is_a_dash_and_none_is_minus_zero():
    assert SHEET.cells([row(math.nan)]) == [["calm", "-", "-"]]
    assert SHEET.cells([row(-0.0)])[0][1] == "0.00"
