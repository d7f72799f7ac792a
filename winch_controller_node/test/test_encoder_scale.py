"""When the encoder is blamed, on either side of each threshold."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from winch_controller_node.estimation.depth_witness import Seen
from winch_controller_node.identification.encoder_scale import (
    AGREED,
    ALIKE,
    ALIKE_SEEN,
    CLEARLY,
    CONTRARY,
    EXPLAINED,
    NEARER,
    NOT_CONTRARY,
    NOT_SUDDEN,
    STRAIGHT,
    SUDDEN,
    TRUE,
    WRONG,
    Scale,
    ScaleJudge,
    Sent,
    encoder_scale,
    is_contrary,
    is_off,
    is_right_way,
    is_sudden,
    is_true,
)

LITTLE = 1e-6
STILL = np.zeros(2)


def sent(share, left=0.01):
    return Sent(share, left, payout=3.0)


def seen(share, sigma=0.01, left=0.01):
    return Seen(share, sigma, left, payout=3.0, unit=STILL)


SHARES = st.floats(-10.0, 10.0)
POSITIVE = st.floats(0.0, 10.0)


# the encoder


@pytest.mark.parametrize("scale", [0.5, 2.0, -1.0, -0.3, 0.7])
def test_an_encoder_that_winch_and_depth_sensor_both_contradict_is_wrong(scale):
    """It reads a scale times what the winch was sent, and the unit shows one over the scale of what it reads."""
    found = encoder_scale([sent(scale)], [seen(1.0 / scale)])
    assert found == Scale(scale, seen(1.0 / scale))


def test_a_winch_with_another_gain_is_not_an_encoder_of_another_scale():
    """The unit moves by what the encoder reads: both have seen the winch do half of what it was sent."""
    assert encoder_scale([sent(0.5)], [seen(1.0)]) is None


@pytest.mark.parametrize(
    ("one", "other"),
    [
        # off by WRONG or by less
        (lambda past: sent(1.0 + WRONG + past), lambda past: seen(1.0 / (1.0 + WRONG))),
        (lambda past: sent(1.0 - WRONG - past), lambda past: seen(1.0 / (1.0 - WRONG))),
        # the depth sensor is CLEARLY of that opinion: 2 is 1 from what is read
        (lambda past: sent(0.5), lambda past: seen(2.0, sigma=1.0 / CLEARLY - past)),
        # the scale explains what the encoder reads
        (lambda past: sent(0.5, left=EXPLAINED - past), lambda past: seen(2.0)),
        # 0.5 * s is within NEARER * (s - 1) of 1 from s = 1.35 / 0.85 on, 0.74 * s up to s = 0.65 / 0.39
        (lambda past: sent(0.5), lambda past: seen((1.0 + NEARER) / (0.5 + NEARER) + past)),
        (lambda past: sent(0.74), lambda past: seen((1.0 - NEARER) / (0.74 - NEARER) - past)),
        # 0.5 * s within ALIKE_SEEN of 1: NEARER of 1.6 is more
        (lambda past: sent(0.5), lambda past: seen((1.0 + ALIKE_SEEN) / 0.5 - past)),
        # -s within ALIKE_SEEN of 1: NEARER of 1.7 is more
        (lambda past: sent(-1.0), lambda past: seen(-1.0 + ALIKE_SEEN - past)),
    ],
    ids=[
        "more",
        "less",
        "clear",
        "explained",
        "little seen",
        "much seen",
        "not alike",
        "turned over, not alike",
    ],
)
def test_each_condition_of_a_wrong_encoder_matters(one, other):
    assert encoder_scale([one(LITTLE)], [other(LITTLE)]) is not None
    assert encoder_scale([one(-LITTLE)], [other(-LITTLE)]) is None


@given(st.lists(st.tuples(SHARES, POSITIVE, POSITIVE), min_size=1, max_size=3), POSITIVE)
def test_an_encoder_that_reads_what_the_winch_was_sent_is_never_blamed(others, left):
    assert encoder_scale([sent(1.0, left)] * len(others), [seen(*other) for other in others]) is None


@given(st.lists(st.tuples(SHARES, POSITIVE), min_size=1, max_size=3), POSITIVE, POSITIVE)
def test_an_encoder_that_reads_what_the_depth_sensor_sees_is_never_blamed(ones, sigma, left):
    assert encoder_scale([sent(*one) for one in ones], [seen(1.0, sigma, left)] * len(ones)) is None


@given(SHARES, POSITIVE, SHARES, POSITIVE)
def test_an_encoder_that_is_blamed_is_what_one_of_them_says_and_the_other_is_near(share, left, depth, sigma):
    found = encoder_scale([sent(share, left)], [seen(depth, sigma)])
    if found is not None:
        assert found.value == share
        assert abs(share * depth - 1.0) < abs(depth - 1.0)
        assert abs(share * depth - 1.0) < ALIKE_SEEN


def test_nothing_is_known_of_a_time_over_which_one_of_them_knows_nothing():
    assert encoder_scale([None, sent(0.5), None], [seen(2.0), None, None]) is None
    assert encoder_scale([sent(0.5), None, None], [None, seen(2.0), seen(2.0)]) is None


def test_the_times_that_are_compared_are_the_same():
    with pytest.raises(ValueError, match="shorter"):
        encoder_scale([sent(0.5), sent(0.5)], [seen(2.0)])


def test_the_surest_of_several_times_is_told_with_the_scale_that_explains_most():
    """A sigma of 0.05 of a share of 4 is less than 0.03 of 2; a time over which the scale has changed explains less."""
    times = [seen(2.0, sigma=0.03), seen(4.0, sigma=0.05), seen(1.8, sigma=0.1)]
    ones = [sent(0.5, left=0.02), sent(0.25, left=0.02), sent(0.55, left=0.01)]
    assert encoder_scale(ones, times) == Scale(0.55, times[1])
    # also one over which the depth sensor is not sure yet
    assert encoder_scale(ones, [*times[:2], seen(1.8, sigma=10.0)]) == Scale(0.55, times[1])


@pytest.mark.parametrize(
    ("shares", "off"),
    [
        ((1.0, 1.0 + WRONG - LITTLE, 1.0 - WRONG + LITTLE), False),
        ((1.0, 1.0 + WRONG + LITTLE, None), True),
        ((None, None, 1.0 - WRONG - LITTLE), True),
        ((-1.0, 1.0, 1.0), True),
        ((None, None, None), False),
        ((), False),
    ],
)
def test_what_is_off_over_any_time_is_looked_at(shares, off):
    assert is_off([None if share is None else sent(share) for share in shares]) is off


@given(st.lists(st.tuples(SHARES, POSITIVE), min_size=1, max_size=3), SHARES, POSITIVE)
def test_an_encoder_that_is_blamed_is_off(ones, depth, sigma):
    """What is seen need not be worked out for one that is not."""
    times = [sent(*one) for one in ones]
    assert is_off(times) or encoder_scale(times, [seen(depth, sigma)] * len(times)) is None


# one judgement after the other


def scale_of(value):
    return Scale(value, seen(1.0 / value))


def test_a_scale_is_sure_once_it_has_been_seen_so_many_times_in_a_row_and_is_then_asked_anew():
    judge = ScaleJudge()
    for _ in range(AGREED - 1):
        assert judge.judge(scale_of(0.5)) is None
        assert judge.doubts
    assert judge.judge(scale_of(0.52)) == scale_of(0.52)
    assert not judge.doubts
    assert judge.judge(scale_of(0.5)) is None
    assert judge.doubts


@pytest.mark.parametrize("last", [0.5, -0.5, 3.0])
def test_scales_that_are_not_alike_are_not_one(last):
    """Alike is nearer than half of the present one."""
    judge = ScaleJudge()
    for value, is_sure in ((last * (1.0 - ALIKE - LITTLE), False), (last, False), (last, False), (last, True)):
        assert (judge.judge(scale_of(value)) is not None) == is_sure


def test_scales_that_are_alike_are_one():
    judge = ScaleJudge()
    found = [judge.judge(scale_of(value)) for value in (0.5 * (1.0 - ALIKE) + LITTLE, 0.5, 0.5)]
    assert found[-1] is not None


def test_an_encoder_turned_over_is_not_like_one_that_is_right_in_size():
    judge = ScaleJudge()
    assert [judge.judge(scale_of(value)) for value in (1.5, -1.5, 1.5, -1.5, 1.5, -1.5)] == [None] * 6


def test_a_judgement_that_finds_nothing_takes_one_back_and_ends_the_doubt():
    judge = ScaleJudge()
    judge.judge(scale_of(0.5))
    judge.judge(scale_of(0.5))
    assert judge.judge(None) is None
    assert not judge.doubts
    assert judge.judge(scale_of(0.5)) is None
    assert judge.judge(scale_of(0.5)) is not None


@given(st.lists(st.sampled_from([None, 0.5, 2.0, -1.0]), max_size=40))
def test_nothing_is_sure_that_was_not_seen_often_enough(values):
    """Each that is told has used up as many alike."""
    judge, told, asked = ScaleJudge(), 0, 0
    for value in values:
        asked += value is not None
        found = judge.judge(None if value is None else scale_of(value))
        told += found is not None
        assert judge.doubts == (value is not None and found is None)
        assert found is None or found.value == value
    assert told * AGREED <= asked


# the other way


@pytest.mark.parametrize(
    ("share", "left", "was", "contrary"),
    [
        (CONTRARY - LITTLE, STRAIGHT - LITTLE, False, True),
        (CONTRARY + LITTLE, STRAIGHT - LITTLE, False, False),
        (CONTRARY - LITTLE, STRAIGHT + LITTLE, False, False),
        (NOT_CONTRARY - LITTLE, math.inf, True, True),
        (NOT_CONTRARY + LITTLE, 0.0, True, False),
        (-1.0, 0.0, False, True),
        (1.0, 0.0, False, False),
        (1.0, 0.0, True, False),
    ],
)
def test_an_encoder_goes_the_other_way_until_it_clearly_goes_the_same(share, left, was, contrary):
    assert is_contrary(sent(share, left), was=was) is contrary


@given(st.floats(-10.0, 10.0), POSITIVE)
def test_an_encoder_that_goes_the_right_way_does_not_go_the_other(share, left):
    one = sent(share, left)
    assert not (is_right_way(one) and is_contrary(one, was=True))


@given(st.floats(CONTRARY, 10.0), POSITIVE)
def test_an_encoder_that_goes_with_the_winch_is_never_set_aside(share, left):
    assert not is_contrary(sent(share, left), was=False)


# all at once


@pytest.mark.parametrize(
    ("share", "left", "was", "sudden"),
    [
        (SUDDEN[0] - LITTLE, STRAIGHT - LITTLE, False, True),
        (SUDDEN[0] + LITTLE, STRAIGHT - LITTLE, False, False),
        (SUDDEN[0] - LITTLE, STRAIGHT + LITTLE, False, False),
        (SUDDEN[1] - LITTLE, 0.0, False, False),
        (SUDDEN[1] + LITTLE, 0.0, False, True),
        (NOT_SUDDEN[0] - LITTLE, math.inf, True, True),
        (NOT_SUDDEN[0] + LITTLE, math.inf, True, False),
        (NOT_SUDDEN[1] + LITTLE, math.inf, True, True),
        (-1.0, 0.0, False, True),
    ],
)
def test_an_encoder_is_off_all_at_once_until_it_is_clearly_near_again(share, left, was, sudden):
    assert is_sudden(sent(share, left), was=was) is sudden


@given(st.floats(-10.0, 10.0), POSITIVE)
def test_an_encoder_that_reads_what_was_sent_is_neither_off_nor_contrary(share, left):
    one = sent(share, left)
    assert is_true(one) == (abs(share - 1.0) < TRUE and left < STRAIGHT)
    for was in (False, True):
        assert not (is_true(one) and (is_sudden(one, was=was) or is_contrary(one, was=was)))
