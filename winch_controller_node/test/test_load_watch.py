"""Alarms of the load and of the winch: what is said, and how often."""

import math
from dataclasses import replace

import pytest
from heave_core.watch_table import LoadNews
from heave_node.interface.alarm import Severity
from heave_node.loads.strength import SAFETY_FACTOR, Strength
from winch_controller_node.core.supervision.modes import Mode
from winch_controller_node.core.supervision.watch.load_watch import LoadWatch, rope_strength
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.laws import AlarmParameters

DT = 0.05
STATIC = 200e3


def watched(*spells, rope=None, **thresholds):
    """Return the alarms, with their times [s], of spells of (duration, tension over the static one, at a limit)."""
    watch = LoadWatch(AlarmParameters(**thresholds), tick_period=DT, rope=rope)
    ticks = [spell[1:] for spell in spells for _ in range(round(spell[0] / DT))]
    return [
        (round(number * DT, 2), alarm)
        for number, (share, is_at_limit) in enumerate(ticks)
        for alarm in watch.update(share * STATIC, STATIC, is_at_limit=is_at_limit)
    ]


def test_a_slack_cable_is_told_with_its_tension():
    alarms = watched((5.0, 0.06, False), (5.0, 0.04, False))
    ((time, alarm),) = alarms
    assert (time, alarm.name) == (5.0, "CABLE_SLACK")
    assert alarm.text == "tension 8.0 kN, 4 % of static. A snap load may follow. Compensate, or wait for calmer seas."
    assert watched((5.0, 0.0, False), slack_ratio=0.0) == []


@pytest.mark.parametrize(
    ("rate", "mode", "remedy"),
    [
        (0.3, Mode.COMPENSATING, "Lower more slowly"),
        (0.3, Mode.MANUAL, "Lower more slowly"),
        (0.0, Mode.COMPENSATING, "Check the load"),
        (0.0, Mode.CONSTANT_TENSION, "Check the load"),
        (-0.3, Mode.STANDBY, "Compensate"),
    ],
)
def test_what_to_do_about_a_slack_cable_goes_by_what_the_winch_does(rate, mode, remedy):
    watch = LoadWatch(AlarmParameters(), tick_period=DT)
    (alarm,) = watch.alarms(int(LoadNews.SLACK), 8e3, STATIC, rate, mode)
    assert alarm.text.endswith(f"A snap load may follow. {remedy}, or wait for calmer seas.")


def test_too_much_tension_is_told_with_what_is_allowed_and_what_to_do():
    alarms = watched((5.0, 1.49, False), (5.0, 1.6, False))
    ((time, alarm),) = alarms
    assert (time, alarm.name) == (5.0, "TENSION_HIGH")
    assert alarm.values == pytest.approx({"tension": 320.0, "ratio": 1.6, "limit": 1.5})
    assert watched((5.0, 9.0, False), tension_ratio=0.0) == []


def test_no_reading_of_the_load_cell_is_neither_slack_nor_too_high():
    assert watched((5.0, math.nan, False)) == []


@pytest.mark.parametrize(("quiet", "count"), [(59.5, 1), (60.5, 2)])
def test_the_quiet_minute_counts_from_the_last_tick_of_its_cause(quiet, count):
    assert len(watched((5.0, 0.01, False), (quiet, 1.0, False), (5.0, 0.01, False))) == count


def test_of_a_unit_that_weighs_nothing_no_tension_is_slack_or_too_high():
    watch = LoadWatch(AlarmParameters(), tick_period=DT)
    assert watch.update(1e3, 0.0, is_at_limit=False) == watch.update(1e3, -1.0, is_at_limit=False) == ()


def test_a_load_cell_that_is_pushed_is_at_fault_itself():
    """An eighth of the static tension, the other way; a slack cable carries nothing."""
    ((_, alarm),) = watched((1.0, -0.125, False))
    assert (alarm.name, alarm.values) == ("SENSOR_DOUBTFUL, LOAD_CELL: negative", {"tension": -25.0})


def test_a_rope_that_carries_more_than_it_should_and_more_than_it_can_is_told_with_its_safety_factor():
    """A wire of 494 kN that has to have a factor of 2.535 and one of 1: 200 kN leave 2.47, 500 kN leave 0.988."""
    rope = Strength("rope_safety_factor", "rope", "breaking force", 494e3, SAFETY_FACTOR)
    alarms = watched((1.0, 0.97, False), (1.0, 1.0, False), (1.0, 2.5, False), rope=rope, tension_ratio=0.0)
    assert [(time, alarm.name) for time, alarm in alarms] == [(1.0, "ROPE_SAFETY_LOW"), (2.0, "ROPE_OVERLOADED")]
    (_, short), (_, over) = alarms
    assert short.values == pytest.approx({"tension": 200.0, "capacity": 494.0, "factor": 2.47, "required": 2.535})
    assert over.values == pytest.approx({"tension": 500.0, "capacity": 494.0, "factor": 0.988})
    assert over.severity is Severity.CRITICAL


def test_a_rope_whose_strength_is_not_stated_raises_no_alarm():
    parameters = WinchControllerParameters()
    cable = replace(parameters.cable, breaking_force=494e3, safety_factor=3.0)
    stated = rope_strength(replace(parameters, cable=cable))
    assert (stated.capacity, stated.required) == (494e3, 3.0)
    assert rope_strength(replace(parameters, cable=replace(cable, breaking_force=0.0))) is None


def test_a_winch_at_its_limits_for_a_quarter_of_the_time_is_saturated():
    """1 - exp(-t/60 s) passes a quarter at 60 ln(4/3) s."""
    ((time, alarm),) = watched((30.0, 1.0, True))
    assert time == pytest.approx(60.0 * math.log(4.0 / 3.0), abs=0.1)
    assert alarm.name == "WINCH_SATURATED"
    assert alarm.values == {"percent": pytest.approx(25.0, abs=0.1), "time": 60.0}
    assert watched(*[(0.2, 1.0, True), (0.8, 1.0, False)] * 300) == []
