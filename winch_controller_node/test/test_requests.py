"""A request of an operator is reported so that it can be given again."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from winch_controller_node.interface.requests import (
    DEPTH,
    DESIGN,
    FACTOR,
    HOLD,
    MODE,
    NO_SPEED,
    SPEED,
    Request,
    request_of,
    stated,
)

figures = st.floats(allow_nan=False).map(stated)


@given(figures, figures, st.floats(0.0, 1e4), st.sampled_from(["", ": refused", ": the mean payout has moved by +4 m"]))
def test_a_request_is_read_back_as_it_was(one, other, plain, remark):
    for request in (
        Request(MODE, ("manual",)),
        Request(MODE, ("constant_tension", one)),
        Request(DEPTH, (one,)),
        Request(DEPTH, (one, other)),
        Request(HOLD),
        Request(SPEED, (one,)),
        Request(NO_SPEED),
        Request(FACTOR, (one,)),
        Request(DESIGN, (plain, plain + 1.0, plain + 2.0)),
    ):
        assert request_of(request.words + remark) == request
        assert "," not in request.words


@pytest.mark.parametrize("words", ["", "fault of mru: gap", "speed fast m/s", "depth 3 m at", "hold on"])
def test_what_is_no_request_is_none(words):
    assert request_of(words) is None


def test_a_name_that_somebody_has_made_up_is_one_word():
    assert request_of(Request(MODE, ("dance, now; t = 1.00 s: hold",)).words) == Request(
        MODE, ("dance__now__t___1_00_s__hold",)
    )
