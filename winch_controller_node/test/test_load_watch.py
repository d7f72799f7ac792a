"""Alarms of the load and of the winch: what is said, and how often."""

import math

import pytest
from winch_controller_node.parameters.laws import AlarmParameters
from winch_controller_node.supervision.watch.load_watch import LoadWatch

DT = 0.05
STATIC = 200e3


def watched(*spells, **thresholds):
    """Return the alarms, with their times [s], of spells of (duration, tension over the static one, at a limit)."""
    watch = LoadWatch(AlarmParameters(**thresholds), tick_period=DT)
    ticks = [spell[1:] for spell in spells for _ in range(round(spell[0] / DT))]
    return [
        (round(number * DT, 2), words)
        for number, (share, is_at_limit) in enumerate(ticks)
        for words in watch.update(share * STATIC, STATIC, is_at_limit=is_at_limit)
    ]


def test_a_slack_cable_is_told_with_its_tension():
    alarms = watched((5.0, 0.06, False), (5.0, 0.04, False))
    assert alarms == [
        (
            5.0,
            "cable slack: tension 8.0 kN, 4 % of the static one: a snap may follow; wait for a lower sea, or lower "
            "more slowly",
        )
    ]
    assert watched((5.0, 0.0, False), slack_ratio=0.0) == []


def test_too_much_tension_is_told_with_what_is_allowed_and_what_to_do():
    alarms = watched((5.0, 1.49, False), (5.0, 1.6, False))
    assert alarms == [
        (
            5.0,
            "tension too high: 320.0 kN, 1.60 times the static one; at most 1.5 is allowed: look whether the unit is "
            "held fast; one that swings below a braked winch is damped by compensation; else wait for a lower sea, or "
            "raise alarms.tension_ratio where cable and winch bear more",
        )
    ]
    assert watched((5.0, 9.0, False), tension_ratio=0.0) == []


def test_no_reading_of_the_load_cell_is_neither_slack_nor_too_high():
    assert watched((5.0, math.nan, False)) == []


def test_an_alarm_comes_again_only_after_a_quiet_minute():
    """Groups of a swell that take the tension away once in each 50 s are one alarm, and those of 62 s one each."""
    quick = watched(*[(1.0, 0.01, False), (49.0, 1.0, False)] * 10)
    slow = watched(*[(1.0, 0.01, False), (61.0, 1.0, False)] * 10)
    assert len(quick) == 1
    assert [time for time, _ in slow] == pytest.approx([62.0 * number for number in range(10)])


def test_slack_and_too_much_tension_are_episodes_of_their_own():
    alarms = watched((1.0, 0.01, False), (1.0, 2.0, False), (1.0, 0.01, False))
    assert [words.split(":")[0] for _, words in alarms] == ["cable slack", "tension too high"]


def test_a_winch_at_its_limits_for_a_quarter_of_the_time_is_saturated():
    """1 - exp(-t/60 s) passes a quarter at 60 ln(4/3) s."""
    ((time, words),) = watched((30.0, 1.0, True))
    assert time == pytest.approx(60.0 * math.log(4.0 / 3.0), abs=0.1)
    assert words == (
        "winch saturated: at its limits for 25 % of the last 60 s: the unit moves more than it would below a stronger "
        "winch; wait for a lower sea, or compensate a smaller factor"
    )
    assert watched(*[(0.2, 1.0, True), (0.8, 1.0, False)] * 300) == []
