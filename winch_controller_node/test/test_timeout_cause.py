"""A command timeout is reported with its cause: who was silent."""

import pytest
from winch_controller_node.core.supervision.late_commands import TimeoutCause
from winch_controller_node.interface.readings import Lateness

DT = 0.05


def after_good_ticks(untaken=0.0, silent=0):
    cause = TimeoutCause(DT)
    for tick in range(200):
        cause.update(has_state=True, untaken=untaken if tick > 180 else 0.0)
    for tick in range(silent):
        cause.update(has_state=tick == silent - 1, untaken=0.0)
    return cause


@pytest.mark.parametrize(
    ("lateness", "silent", "untaken", "culprit", "delay"),
    [
        (Lateness(0.03, 0.75), 1, 0.6, "controller was delayed", "0.75 s"),
        (Lateness(0.80, 0.10), 1, 0.6, "clock master", "0.80 s"),
        (Lateness(0.03, 0.04), 17, 0.0, "from the winch", "0.80 s"),
        (Lateness(0.03, 0.04), 1, 0.55, "winch took none", "0.55 s"),
    ],
    ids=["controller", "machine", "winch", "transport"],
)
def test_who_was_silent_is_told_and_for_how_long(lateness, silent, untaken, culprit, delay):
    words = after_good_ticks(untaken, silent if silent > 1 else 0).words(lateness)
    assert culprit in words
    assert delay in words


def test_of_an_unknown_cause_nothing_is_said():
    assert after_good_ticks(0.0, 0).words(Lateness()) == ""


def test_nothing_is_the_cause_before_the_first_tick():
    assert TimeoutCause(DT).words(Lateness()) == ""


def test_a_silence_is_known_for_seconds_and_the_longest_of_them_is_told():
    """0.5 s without a state, then 0.8 s, then 0.3 s: the longest, until it is 3 s ago."""
    cause = after_good_ticks()
    for silent in (10, 16, 6):
        for tick in range(silent):
            cause.update(has_state=tick == silent - 1, untaken=0.0)
    assert "0.75 s" in cause.words(Lateness())
    for _ in range(round(2.5 / DT)):
        cause.update(has_state=True, untaken=0.0)
    assert "0.75 s" in cause.words(Lateness())
    for _ in range(round(1.0 / DT)):
        cause.update(has_state=True, untaken=0.0)
    assert cause.words(Lateness()) == ""


def test_what_was_not_taken_is_the_cause_only_where_nobody_was_silent():
    words = after_good_ticks(untaken=0.55, silent=17)
    assert "from the winch" in words.words(Lateness())


@pytest.mark.parametrize(("delay", "is_reported"), [(0.21, True), (0.2, False), (0.19, False)])
def test_a_delay_of_more_than_a_fifth_of_a_second_may_be_a_cause(delay, is_reported):
    assert bool(TimeoutCause(DT).words(Lateness(delay, 0.0))) is is_reported
    assert bool(TimeoutCause(DT).words(Lateness(0.0, delay))) is is_reported
    assert bool(after_good_ticks(untaken=delay).words(Lateness())) is is_reported


def test_a_winch_that_has_said_nothing_since_the_start_was_silent_since_then():
    """Ten ticks without a state: the one that is just due may still come."""
    cause = TimeoutCause(DT)
    for _ in range(10):
        cause.update(has_state=False, untaken=9.0)
    assert cause.words(Lateness()) == "no data from the winch for 0.45 s"


def test_a_silence_is_a_cause_for_three_seconds():
    """60 ticks: in the 60th after it, it still is, in the next it is not."""
    cause = after_good_ticks(silent=17)
    for _ in range(59):
        cause.update(has_state=True, untaken=0.0)
    assert "0.80 s" in cause.words(Lateness())
    for _ in range(2):
        cause.update(has_state=True, untaken=0.0)
    assert cause.words(Lateness()) == ""


def test_a_silence_as_long_as_the_last_one_counts_from_its_own_end():
    """Two of 0.8 s, two seconds apart: 3 s after the first one the second is still known."""
    cause = after_good_ticks(silent=17)
    for _ in range(2):
        for _ in range(round(2.0 / DT)):
            cause.update(has_state=True, untaken=0.0)
        for tick in range(17):
            cause.update(has_state=tick == 16, untaken=0.0)
    for _ in range(round(2.0 / DT)):
        cause.update(has_state=True, untaken=0.0)
    assert "0.80 s" in cause.words(Lateness())


def test_what_was_not_taken_is_known_until_the_winch_says_otherwise():
    cause = after_good_ticks(untaken=0.55)
    cause.update(has_state=False, untaken=0.0)
    assert cause.words(Lateness()) == "commands were sent in time, and the winch took none for 0.55 s"
    cause.update(has_state=True, untaken=0.0)
    assert cause.words(Lateness()) == ""
