"""What failed attempts say of the next: less authority each time, causes that become known, and at last an operator."""

import math

import pytest
from winch_controller_node.core.supervision.attempts import Attempts
from winch_controller_node.interface.alarms import ALARMS

LARGEST = 0.9
HARM = ALARMS.alarm("UNIT_SWING_HIGH", swing=1.0)
DISAGREEMENT = ALARMS.alarm("DEPTH_MRU_DISAGREE", error=0.5)
CUT = ALARMS.alarm("COMMANDS_CUT", time=0.5)


def over(attempts, ticks=3, is_off=True, residual=0.5):
    """Tell whether compensation may be tried again within so many ticks."""
    return any(attempts.ends(residual, is_off=is_off) for _ in range(ticks))


def test_nothing_is_held_before_there_is_a_reason():
    attempts = Attempts(LARGEST)
    assert (attempts.inhibits, attempts.alarm, attempts.prospect(1.0), attempts.doubt) == (False, None, "", 0.0)


def test_each_failure_leaves_as_much_again_until_no_authority_gains_a_tenth_and_an_operator_has_to_ask():
    """By hand: V / (1 + V) is above 0.9^2 from V = 0.81 / 0.19 = 4.26 on, at the fifth failure."""
    attempts, doubts = Attempts(LARGEST), []
    for _ in range(4):
        attempts.fail(HARM)
        doubts.append(attempts.doubt)
        assert not attempts.awaits_operator
        assert over(attempts)
        assert attempts.alarm is None
    assert doubts == [1.0, 2.0, 3.0, 4.0]
    attempts.fail(HARM)
    assert attempts.awaits_operator
    assert not over(attempts, 100)
    assert "request compensation" in attempts.prospect(0.0)
    attempts.release()
    assert (attempts.inhibits, attempts.doubt) == (False, 0.0)


def test_it_is_tried_again_once_it_is_off_and_predicted_to_help():
    attempts = Attempts(LARGEST)
    attempts.fail(HARM)
    assert not over(attempts, is_off=False)
    assert not over(attempts, residual=0.91)
    assert "91 %" in attempts.prospect(0.91) and "90 %" in attempts.prospect(0.91)
    assert over(attempts, residual=0.89)


def test_a_reason_that_lasts_holds_while_it_lasts_and_the_first_one_stays_the_named_one():
    attempts = Attempts(LARGEST)
    attempts.fail(HARM)
    for _ in range(10):
        attempts.certain(CUT)
        assert not attempts.ends(0.0, is_off=True)
    assert attempts.alarm is HARM
    assert attempts.ends(0.0, is_off=True)


def test_what_no_attempt_has_brought_about_is_no_failure():
    attempts = Attempts(LARGEST)
    attempts.certain(CUT)
    assert (attempts.alarm, attempts.doubt) == (CUT, 0.0)
    assert attempts.prospect(0.0)


def test_three_interruptions_are_followed_by_an_attempt_and_waves_that_go_well_take_them_back():
    """A quarter of the motion each: 0.9 - 3/4 = 0.15 and 0.9 - 1 < 0. After five time constants 0.7 % is left."""
    attempts, bars = Attempts(LARGEST), []
    for _ in range(4):
        attempts.interrupt()
        bars.append(attempts.bar)
    assert bars == pytest.approx([0.65, 0.4, 0.15, -0.1])
    assert attempts.doubt == 0.0
    for _ in range(500):
        attempts.learn(0.0, 0.01)
    assert attempts.bar == pytest.approx(LARGEST, abs=0.01)


def test_a_certain_reason_takes_the_place_of_a_disagreement_and_not_the_other_way_round():
    attempts = Attempts(LARGEST)
    attempts.unexplained(DISAGREEMENT)
    attempts.certain(CUT)
    assert attempts.alarm is CUT
    attempts.unexplained(DISAGREEMENT)
    attempts.explain("mru")
    assert attempts.alarm is CUT, "what is certain is not explained by a belief"


def test_a_disagreement_that_goes_on_is_one_failure_and_keeps_it_off():
    attempts = Attempts(LARGEST)
    for _ in range(10):
        attempts.unexplained(DISAGREEMENT)
        assert not attempts.ends(0.0, is_off=True)
    assert attempts.doubt == 1.0
    assert attempts.ends(0.0, is_off=True)


def test_a_cause_that_becomes_known_takes_the_last_failure_back_and_no_other():
    attempts = Attempts(LARGEST)
    attempts.fail(HARM)
    assert over(attempts)
    attempts.unexplained(DISAGREEMENT)
    attempts.explain("mru")
    assert (attempts.alarm.code, attempts.alarm.values) == ("DEPTH_MRU_EXPLAINED", {"part": "mru"})
    assert attempts.doubt == 1.0
    attempts.explain("winch")
    assert attempts.doubt == 1.0


def test_harm_after_a_disagreement_that_is_over_is_not_explained_by_it():
    attempts = Attempts(LARGEST)
    attempts.unexplained(DISAGREEMENT)
    assert over(attempts)
    attempts.fail(HARM)
    attempts.explain("mru")
    assert attempts.alarm is HARM


def test_waves_in_which_it_goes_well_take_doubt_back_and_those_in_which_it_does_not_add_none():
    """A relaxation of 1 % a tick: exp(-1) is left after 100 of them."""
    attempts = Attempts(LARGEST)
    attempts.fail(HARM)
    for _ in range(100):
        attempts.learn(2.0, 0.01)
    assert attempts.doubt == 1.0
    for _ in range(100):
        attempts.learn(0.0, 0.01)
    assert attempts.doubt == pytest.approx(math.exp(-1.0), rel=0.01)
    attempts.explain("winch")
    assert attempts.doubt == pytest.approx(0.0, abs=1e-12)
