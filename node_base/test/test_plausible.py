"""What can plausibly be: the table is asked in its own units, and names the likely cause."""

import math

import pytest
from heave_node.files.plausible import PLAUSIBLE, is_plausible, question, refusal, sea_question


@pytest.mark.parametrize("quantity", PLAUSIBLE)
def test_every_range_has_its_ends_and_refuses_what_is_beyond_them_with_a_cause(quantity):
    known = PLAUSIBLE[quantity]
    assert known.least < known.most
    assert known.above.endswith("?")
    assert known.below.endswith("?")
    for value in (known.least, known.most):
        assert is_plausible(quantity, value)
        assert question(quantity, value) == ""
    beyond = question(quantity, known.most * 1.01, "file.csv")
    assert beyond.startswith(f"file.csv: {quantity} is ")
    assert beyond.endswith(known.above)
    assert question(quantity, known.least - 1.0).endswith(known.below)
    assert not is_plausible(quantity, math.nan)


@pytest.mark.parametrize(
    ("sea", "says"),
    [
        ((2.0, 6.0, 8.0), ""),
        ((19.0, 14.0, 17.0), ""),  # the highest that a buoy has measured (WMO, 2013)
        ((2625.0, 6.0, 8.0), "significant wave height is 2625 m"),
        # 41010d of wavespectra's samples, directions in the form of densities: 2 pi 20.6/(g 3.6^2) = 1.02
        ((20.6, 3.6, 27.0), "significant steepness is 1.018"),
        ((0.05, 20.0, 60.0), "peak period is 60 s"),
    ],
)
def test_a_sea_is_judged_by_height_steepness_and_period(sea, says):
    assert says in sea_question(*sea)
    assert bool(says) == bool(sea_question(*sea))


def test_a_refusal_is_one_line_with_the_option():
    one = question("heave response", 1029.0, "ship.csv")
    assert refusal([one], "--accept") == f"{one} --accept takes the figures as they are"
    assert "(and 2 more such figures)" in refusal([one] * 3, "--accept")
