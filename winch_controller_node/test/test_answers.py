"""Answers of the adviser: active at their tick, refused when late, counted, and said."""

import pytest
from winch_controller_node.advice.watch import STEADY, AdviserWatch
from winch_controller_node.beliefs.beliefs import LATENCY, latency_ticks

DT = 0.05


@pytest.mark.parametrize(("period", "ticks"), [(0.05, 20), (0.01, 100), (0.025, 40), (0.5, 2), (1.0, 2)])
def test_an_answer_is_in_force_a_second_after_its_observations_and_two_ticks_at_least(period, ticks):
    assert LATENCY == 1.0
    assert latency_ticks(period) == ticks


def alarms_of(watch, first, last):
    return [alarm for tick in range(first, last) for alarm in watch.step(tick)]


def test_an_adviser_that_answers_in_time_is_well_and_nothing_is_said():
    watch = AdviserWatch(DT)
    for second in range(1, 10):
        watch.asked(20 * second)
        assert alarms_of(watch, 20 * second, 20 * second + 20) == []
        watch.took(number=1)
    assert watch.is_well
    assert watch.words == "in time; values active: identified, set 1"
    assert watch.values == {"answered": "9", "late": "0", "malformed": "0"}


def test_silence_is_said_once_and_so_is_its_end():
    watch = AdviserWatch(DT)
    watch.asked(20)
    alarms = alarms_of(watch, 21, 400)
    (alarm,) = alarms
    assert alarm.name == "ADVISER_LOST: silent"
    assert alarm.values == {"time": pytest.approx(3.05), "which": "nominal"}
    assert not watch.is_well
    watch.took(number=2)
    assert [alarm.name for alarm in watch.step(400)] == ["ADVISER_RESTORED"]
    assert watch.is_well


def test_lateness_is_said_when_it_begins_and_forgotten_after_ten_answers_in_time():
    watch = AdviserWatch(DT)
    for _ in range(3):
        watch.refused_late()
    assert [alarm.name for alarm in watch.step(100)] == ["ADVISER_LOST: late"]
    for _ in range(STEADY - 1):
        watch.took(1)
    assert not watch.is_well
    watch.took(1)
    assert watch.is_well
    watch.refused_late()
    assert len(watch.step(101)) == 1
    assert watch.values["late"] == "4"


def test_an_answer_that_makes_no_sense_is_said_with_its_fault_the_first_time():
    watch = AdviserWatch(DT)
    watch.refused("design: gain must have shape (17,)")
    watch.refused("design: gain must have shape (17,)")
    (alarm,) = watch.step(1)
    assert alarm.name == "ADVISER_LOST: rejected"
    assert "gain must have shape (17,)" in alarm.values["fault"]
    assert watch.values["malformed"] == "2"
    assert not watch.is_well


def test_a_question_has_one_answer_and_what_was_not_asked_has_none():
    """A controller that was restarted hears answers to the one before it, and says nothing."""
    watch = AdviserWatch(DT)
    watch.asked(20)
    assert not watch.is_question(400)
    watch.refused_stale()
    assert watch.step(21) == []
    assert watch.is_question(20)
    assert not watch.is_question(20)
    assert watch.values["late"] == "1"
