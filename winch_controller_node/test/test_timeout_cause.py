"""A command timeout is reported with its cause: who was silent."""

import pytest
from winch_controller_node.interface.readings import Lateness
from winch_controller_node.supervision.watch.timeout_cause import TimeoutCause

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


def test_a_silence_of_long_ago_is_no_cause():
    cause = after_good_ticks(silent=17)
    for _ in range(80):
        cause.update(has_state=True, untaken=0.0)
    assert cause.words(Lateness()) == ""


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
