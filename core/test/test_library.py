"""The table of the layout beside the library that was compiled from it, and beside its page."""

import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
from heave_core import layout, library
from heave_core.envelope_table import DRUM
from heave_core.library import LibraryError, dtype_of
from heave_core.page import ORDER, page
from heave_core.rows import COUNTER, NUMBER, Row, Structure

REPOSITORY = Path(__file__).parents[2]


def test_the_library_has_the_layout_and_the_sizes_of_this_python():
    loaded = library.library()
    assert loaded.heave_core_layout() == layout.layout_number()
    sizes = [loaded.heave_core_size(place) for place in range(len(layout.STRUCTURES) + 1)]
    kinds = layout.STRUCTURES
    assert sizes == [*(dtype_of(kind).itemsize for kind in kinds), 0]


@pytest.mark.parametrize("number", [0, layout.layout_number()])
def test_a_library_of_another_layout_or_size_is_refused_in_one_line(number):
    class Function:
        restype = None

        def __init__(self, value):
            self.value = value

        def __call__(self, *_):
            return self.value

    other = type("Other", (), {"heave_core_layout": Function(number), "heave_core_size": Function(8)})()
    with pytest.raises(LibraryError, match=r"^/x/libheave_core.so has layout .* build it again") as error:
        library._check(other, Path("/x/libheave_core.so"))
    assert "\n" not in str(error.value)


def test_a_library_that_is_missing_is_named_with_where_it_was_looked_for(monkeypatch, tmp_path):
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    monkeypatch.setattr(library.sys, "prefix", str(tmp_path / "python"))
    with pytest.raises(LibraryError, match=r"libheave_core.so is not below .* install heave again"):
        library.library.__wrapped__()


def test_another_field_or_kind_makes_another_layout_and_another_meaning_does_not(monkeypatch):
    before = layout.layout_number()
    *others, last = layout.STRUCTURES
    place, row = next((place, row) for place, row in enumerate(last.rows) if row.kind == NUMBER and not row.shape)
    for changed, is_same in (
        (Row(row.name, row.unit, "other words", row.kind), True),
        (Row("other", row.unit, row.meaning, row.kind), False),
        (Row(row.name, row.unit, row.meaning, COUNTER), False),
    ):
        altered = Structure(last.name, last.meaning, (*last.rows[:place], changed, *last.rows[place + 1 :]))
        monkeypatch.setattr(layout, "STRUCTURES", (*others, altered))
        assert (layout.layout_number() == before) is is_same


def test_a_design_without_a_value_or_with_an_unknown_one_is_refused():
    record = np.zeros(1, dtype_of(DRUM))
    with pytest.raises(ValueError, match=r"missing \['rate'\], unknown \['speed'\]"):
        library.fill(record[0], {"payout": 1.0, "speed": 2.0})


def test_a_delay_longer_than_what_is_kept_is_refused():
    with pytest.raises(ValueError, match=r"keep at most 25\.5 s"):
        library.Envelope({"tick_period": 0.05, "winch": {"delay": 30.0}})


def test_the_page_of_the_documentation_is_the_table():
    assert (REPOSITORY / "docs/core.md").read_text(encoding="utf-8") == page()


def test_the_page_has_the_numbers_that_the_order_of_a_plc_names():
    order = (REPOSITORY / "core/heave_core/plc/controller.h").read_text(encoding="utf-8").partition("/* The order")[2]
    named = {kind.__name__ for kind in layout.ENUMERATIONS if re.search(rf"\b{kind.__name__}[:;]", order)}
    assert named == set(ORDER)
    assert [name for name in named if f"| `{name}` |" not in page()] == []


MATHEMATICS = (
    "acos asin atan2 ceil cos exp expm1 floor fmod hypot log log1p nearbyint pow round sin sincos sqrt tan tanh"
)
"""What parts may call of the mathematical library."""

OF_THE_LINKER = {
    "__cxa_finalize",
    "__gmon_start__",
    "__stack_chk_fail",
    "_ITM_deregisterTMCloneTable",
    "_ITM_registerTMCloneTable",
}
"""What each shared library has."""


def test_the_library_asks_the_system_for_mathematics_and_copies_alone():
    """No allocator, clock, file, lock or exception: what a shared library uses of others is listed in it."""
    path = library.library()._name
    listed = subprocess.run(["nm", "-D", "--undefined-only", path], capture_output=True, text=True, check=True).stdout
    used = {line.split()[-1].partition("@")[0] for line in listed.splitlines()}
    assert used - OF_THE_LINKER <= {*MATHEMATICS.split(), "memcpy", "memmove", "memset"}
