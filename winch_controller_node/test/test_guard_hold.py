"""How long compensation stays off: a hold time that grows, causes that become known, a sea that asks too much."""

import re

from winch_controller_node.core.supervision.guard_hold import MOST_TRIES, HarmHold
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.parameters.laws import GuardParameters

DT = 1.0 / 16.0  # a sum of which is exact
HOLD, LONGEST = 30.0, 300.0
GROWN = 4.0 * HOLD
"""The second hold time: four times the first [s]."""
CAUSE_TIME, KNOWN_HOLD = 20.0, 5.0
"""Harm whose cause is known within the first time keeps compensation off for the second only [s]."""
PARAMETERS = GuardParameters(hold_time=HOLD, hold_time_limit=LONGEST, demand_ratio=1.5)
HARM = ALARMS.alarm("UNIT_SWING_HIGH", swing=1.0)
DISAGREEMENT = ALARMS.alarm("DEPTH_MRU_DISAGREE", error=0.5)
CUT = ALARMS.alarm("COMMANDS_CUT", time=0.5)


def wait(hold, most=3000.0, authority=0.0, demand=1.0):
    """Wait until compensation may be tried again; return after how long [s], or `most`."""
    for tick in range(1, round(most / DT) + 1):
        if hold.ends(authority, demand):
            return tick * DT
    return most


def test_nothing_is_held_before_there_is_a_reason():
    hold = HarmHold(PARAMETERS, DT)
    assert (hold.inhibits, hold.alarm, hold.prospect(1.0)) == (False, None, "")


def test_each_time_it_is_held_longer_up_to_the_longest_and_after_a_long_good_time_as_at_first():
    hold, held = HarmHold(PARAMETERS, DT), []
    for _ in range(4):
        hold.begin(HARM)
        held.append(wait(hold))
        assert (hold.inhibits, hold.alarm) == (False, None)
    assert held == [HOLD, GROWN, LONGEST, LONGEST]
    hold.is_kept_after(4.0 * LONGEST)
    hold.begin(HARM)
    assert wait(hold) == LONGEST, "not yet for four times as long as it was held"
    hold.is_kept_after(4.0 * LONGEST + 1.0)
    hold.begin(HARM)
    assert wait(hold) == HOLD


def test_the_time_counts_only_while_compensation_is_off_and_the_sea_can_be_followed():
    hold = HarmHold(PARAMETERS, DT)
    hold.begin(HARM)
    assert wait(hold, 100.0, authority=0.01) == 100.0
    assert wait(hold, 100.0, demand=1.6) == 100.0
    assert wait(hold, 100.0, demand=1.5) == DT


def test_it_says_how_long_is_left_and_afterwards_what_the_sea_still_asks_for():
    hold = HarmHold(PARAMETERS, DT)
    hold.begin(HARM)
    wait(hold, 10.0)
    assert re.findall(r"[\d.]+", hold.prospect(1.0)) == ["30", "20"]
    wait(hold, 20.0, demand=2.2)
    assert re.findall(r"\d\.?\d?", hold.prospect(2.2)) == ["1.5", "2.2"]


def test_a_hold_time_of_its_own_goes_before_and_does_not_make_the_next_one_longer():
    hold = HarmHold(PARAMETERS, DT)
    hold.begin(CUT, 7.0)
    assert wait(hold) == 7.0
    hold.begin(HARM)
    assert wait(hold) == HOLD


def test_a_reason_that_lasts_holds_for_the_time_after_it_and_the_first_one_stays_the_named_one():
    hold = HarmHold(PARAMETERS, DT)
    hold.begin(HARM)
    wait(hold, 20.0)
    hold.certain(CUT, 7.0)
    assert hold.alarm is HARM
    assert wait(hold) == HOLD


def test_a_certain_reason_takes_the_place_of_a_disagreement_and_not_the_other_way_round():
    hold = HarmHold(PARAMETERS, DT)
    hold.unexplained(DISAGREEMENT)
    hold.certain(CUT)
    assert hold.alarm is CUT
    hold.unexplained(DISAGREEMENT)
    assert hold.alarm is CUT
    hold.explain("mru")
    assert hold.alarm is CUT, "what is certain is not explained by a belief"


def test_a_disagreement_that_goes_on_keeps_it_off():
    hold = HarmHold(PARAMETERS, DT)
    hold.unexplained(DISAGREEMENT)
    wait(hold, 20.0)
    hold.unexplained(DISAGREEMENT)
    assert wait(hold) == HOLD


def test_a_cause_that_is_known_soon_holds_for_seconds_and_does_not_make_the_next_hold_longer():
    hold = HarmHold(PARAMETERS, DT)
    hold.unexplained(DISAGREEMENT)
    hold.explain("mru")
    assert (hold.alarm.code, hold.alarm.values) == ("DEPTH_MRU_EXPLAINED", {"part": "mru"})
    assert wait(hold) == KNOWN_HOLD
    hold.begin(HARM)
    assert wait(hold) == HOLD


def test_how_soon_a_cause_becomes_known_counts_from_the_begin_of_each_hold():
    hold = HarmHold(PARAMETERS, DT)
    hold.begin(HARM)
    wait(hold)
    hold.begin(HARM)
    wait(hold, CAUSE_TIME - DT)
    hold.explain("winch")
    assert wait(hold) == DT, "held for longer than the time after a known cause"
    hold.begin(HARM)
    assert wait(hold) == GROWN, "the one that was explained does not count"


def test_a_cause_that_becomes_known_late_is_named_and_shortens_nothing():
    hold = HarmHold(PARAMETERS, DT)
    hold.unexplained(DISAGREEMENT)
    wait(hold, CAUSE_TIME)
    hold.explain("mru")
    assert hold.alarm.code == "DEPTH_MRU_EXPLAINED"
    assert wait(hold) == HOLD - CAUSE_TIME


def test_a_cause_does_not_make_a_hold_time_of_its_own_another_one():
    hold = HarmHold(PARAMETERS, DT)
    hold.begin(CUT, 12.0)
    hold.explain("winch")
    assert hold.alarm is CUT
    assert wait(hold) == 12.0


def test_what_becomes_known_while_nothing_is_held_shortens_no_later_hold():
    hold = HarmHold(PARAMETERS, DT)
    hold.explain("winch")
    assert hold.alarm is None
    hold.begin(HARM)
    assert wait(hold) == HOLD


def test_harm_after_a_disagreement_that_is_over_is_not_explained_by_it():
    hold = HarmHold(PARAMETERS, DT)
    hold.unexplained(DISAGREEMENT)
    wait(hold)
    hold.begin(HARM)
    hold.explain("mru")
    assert hold.alarm is HARM


def test_harm_that_comes_back_is_tried_again_so_many_times_and_then_an_operator_has_to_ask():
    """It was tried for ever, at last every sixteen minutes."""
    hold, waits = HarmHold(PARAMETERS, DT), []
    for _ in range(MOST_TRIES):
        hold.begin(HARM)
        waits.append(next(count for count in range(100_000) if hold.ends(0.0, 0.0)))
    assert waits == sorted(waits)
    hold.begin(HARM)
    assert not any(hold.ends(0.0, 0.0) for _ in range(round(10.0 * LONGEST / DT)))
    assert hold.awaits_operator
    assert "request compensation" in hold.prospect(0.0)
    hold.release()
    assert not hold.inhibits
    hold.begin(HARM)
    assert not hold.awaits_operator
