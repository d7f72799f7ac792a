"""What failed attempts say of the next: less authority each time, causes that become known, and at last an operator."""

import math

import pytest
from heave_core.look_table import Harm
from winch_controller_node.core.supervision.guard import prospect
from winch_controller_node.core.supervision.guard_checks import GuardedLoop
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.laws.parts.winch_limits import WinchLimits
from winch_controller_node.parameters.laws import GuardParameters

from tests.supervised import Judge, Seen

DT = 0.05
LARGEST = 0.9
CUT = ALARMS.alarm("COMMANDS_CUT", time=0.5)
KNOWN = 1e6


class Attempts(Judge):
    """The guard of a still sea, in which a test decides what is found."""

    def __init__(self):
        limits = WinchLimits(2.0, 1.5, -50.0, 50.0)
        super().__init__(
            GuardParameters(window=20.0, floor=0.02, harm_ratio=LARGEST), GuardedLoop(limits), tick_period=DT
        )

    def find(self, check=None, *, authority=0.0, unknown=0.0, certain=None):
        """Do a tick in which so much is found of a `check` of the guard."""
        state = self.core.state
        for name in ("swing", "mismatch"):
            state[name]["square"], state[name]["count"] = (KNOWN if name == check else 0.0), KNOWN
        if check == "swing":
            authority = 1.0
        self.update(Seen(unknown=unknown), authority, certain=certain)

    def fail(self):
        self.find("swing")

    def disagree(self):
        self.find("mismatch")

    def over(self, ticks=3, **given):
        """Tell whether compensation may be tried again within so many ticks."""
        for _ in range(ticks):
            self.find(**given)
            if not self.inhibits:
                return True
        return False

    @property
    def doubt(self):
        return float(self.core.attempts["doubt"][0])


def test_nothing_is_held_before_there_is_a_reason():
    attempts = Attempts()
    attempts.find()
    assert (attempts.inhibits, attempts.alarm, attempts.prospect, attempts.doubt) == (False, None, "", 0.0)


def test_each_failure_leaves_as_much_again_until_no_authority_gains_a_tenth_and_an_operator_has_to_ask():
    """By hand: V / (1 + V) is above 0.9^2 from V = 0.81 / 0.19 = 4.26 on, at the fifth failure."""
    attempts, doubts = Attempts(), []
    for _ in range(4):
        attempts.fail()
        assert attempts.alarm.name == "WORSE_THAN_OFF: swing"
        assert "The next attempt is automatic" in attempts.alarm.text
        doubts.append(attempts.doubt)
        assert not attempts.awaits_operator
        assert attempts.over()
        assert attempts.alarm is None
    assert doubts == [1.0, 2.0, 3.0, 4.0]
    attempts.fail()
    assert attempts.awaits_operator
    assert "Every attempt has failed: request compensation" in attempts.alarm.text
    assert "next attempt" not in attempts.alarm.text
    assert not attempts.over(100)
    assert "request compensation" in attempts.prospect
    attempts.release()
    assert (attempts.inhibits, attempts.doubt) == (False, 0.0)


def test_it_is_tried_again_once_it_is_off_and_predicted_to_help():
    """After one failure, what is not known of V leaves sqrt((V + 1) / (V + 2)): 0.894 of 3, 0.913 of 4."""
    attempts = Attempts()
    attempts.fail()
    assert not attempts.over(authority=0.5)
    assert not attempts.over(unknown=4.0)
    assert "91 %" in attempts.prospect and "90 %" in attempts.prospect
    assert attempts.over(unknown=3.0)
    assert prospect(0.5, 0.9, awaits_operator=False).startswith("next attempt once")


def test_a_reason_that_lasts_holds_while_it_lasts_and_the_first_one_stays_the_named_one():
    attempts = Attempts()
    attempts.fail()
    harm = attempts.alarm
    for _ in range(10):
        attempts.find(certain=CUT)
        assert attempts.inhibits
    assert attempts.alarm is harm
    assert attempts.over(1)


def test_what_no_attempt_has_brought_about_is_no_failure():
    attempts = Attempts()
    attempts.find(certain=CUT)
    assert (attempts.alarm, attempts.doubt) == (CUT, 0.0)
    assert attempts.prospect


def test_three_interruptions_are_followed_by_an_attempt():
    """A quarter of the motion each: 0.9 - 3/4 = 0.15 and 0.9 - 1 < 0."""
    attempts, bars = Attempts(), []
    for _ in range(4):
        attempts.interrupt()
        bars.append(attempts.largest_residual)
    assert bars == pytest.approx([0.65, 0.4, 0.15, -0.1])
    assert attempts.doubt == 0.0


def test_a_certain_reason_takes_the_place_of_a_disagreement_and_not_the_other_way_round():
    attempts = Attempts()
    attempts.disagree()
    assert attempts.alarm.name == "DEPTH_MRU_DISAGREE"
    attempts.find(certain=CUT)
    assert attempts.alarm is CUT
    attempts.disagree()
    attempts.allow_correction("mru")
    assert attempts.alarm is CUT, "what is certain is not explained by a belief"


def test_a_disagreement_that_goes_on_is_one_failure_and_keeps_it_off():
    attempts = Attempts()
    for _ in range(10):
        attempts.disagree()
        assert attempts.inhibits and not attempts.trusts_estimate
    assert attempts.doubt == 1.0
    assert attempts.over(1)
    assert attempts.trusts_estimate


def test_a_cause_that_becomes_known_takes_the_last_failure_back_and_no_other():
    attempts = Attempts()
    attempts.fail()
    assert attempts.over()
    attempts.disagree()
    attempts.allow_correction("mru")
    assert (attempts.alarm.name, attempts.alarm.values) == ("DEPTH_MRU_EXPLAINED", {"part": "mru"})
    assert attempts.doubt == 1.0
    attempts.allow_correction("winch")
    assert attempts.doubt == 1.0


def test_harm_after_a_disagreement_that_is_over_is_not_explained_by_it():
    attempts = Attempts()
    attempts.disagree()
    assert attempts.over()
    attempts.fail()
    attempts.allow_correction("mru")
    assert attempts.alarm.name == "WORSE_THAN_OFF: swing"
    assert Harm(int(attempts.core.attempts["harm"][0])) == Harm.SWING_HIGH


def test_waves_in_which_it_goes_well_take_failures_and_interruptions_back():
    """A window of 20 s: exp(-1) of a failure is left after it, and after five of them 0.7 % of an interruption."""
    attempts = Attempts()
    attempts.fail()
    attempts.over()
    attempts.interrupt()

    def go_well(seconds):
        for tick in range(round(seconds / DT)):
            wave = math.sin(0.7 * tick * DT)
            attempts.core.state["swing"]["square"] = attempts.core.state["drum"]["square"] = 0.0
            attempts.update(Seen(unit=1e-6 * wave, free=0.5 * wave), 1.0)

    go_well(10.0)
    before = attempts.doubt
    go_well(20.0)
    assert attempts.doubt == pytest.approx(before * math.exp(-1.0), rel=0.01)
    go_well(80.0)
    assert attempts.largest_residual == pytest.approx(LARGEST, abs=0.01)
