"""The verdict on a run: its criteria, the values reached, and whether compensation was in force at all."""

import math
from dataclasses import replace

import numpy as np
import pytest
from heave_bags.analyse.events import Interval
from heave_bags.analyse.run_record import RunRecord
from heave_bags.analyse.verdict import Judged, judge
from heave_bags.signals import RunSignals, Signal
from heave_node.criteria import Criterion

TIME = np.arange(0.0, 100.0, 0.05)
SIGMA = 0.01
"""Standard deviation of a sine of amplitude sqrt(2) SIGMA over whole periods [m]."""


def record(compensates_until: float, *, is_past_transient: bool = True, reason: str = "") -> RunRecord:
    heave = np.sqrt(2.0) * SIGMA * np.sin(2.0 * np.pi * TIME / 10.0)
    signals = RunSignals(unit_heave=Signal(TIME, heave), compensating=Signal(TIME, compensates_until > TIME))
    stopped = Interval(compensates_until, 100.0, "stopped", reason=reason)
    modes = [Interval(0.0, compensates_until, "compensating"), stopped]
    return RunRecord("run", signals, 0.0, 100.0, modes=modes, is_past_transient=is_past_transient)


def test_a_run_that_got_what_was_wanted_says_so_with_its_figures():
    verdict = judge(record(100.0), [Criterion("unit_sigma_m", "<=", 0.02)], moves_winch=True)
    assert verdict.is_good
    assert verdict.lines() == ["verdict: passed", "  met: unit_sigma_m <= 0.02, got 0.01"]


def test_a_missed_criterion_comes_first_and_shouts():
    wanted = [Criterion("unit_sigma_m", "<=", 0.02), Criterion("unit_sigma_m", "<", 0.005)]
    lines = judge(record(100.0), wanted, moves_winch=True, alarms=2).lines()
    assert lines[0] == "verdict: FAILED; 2 errors reported"
    assert lines[1] == "  MISSED: unit_sigma_m < 0.005, got 0.01"


def test_a_criterion_of_scenario_and_command_line_is_told_once():
    same = [Criterion("unit_sigma_m", "<", 0.005)]
    verdict = judge(record(100.0), same, required=same, moves_winch=True)
    assert verdict.failures == ["MISSED: unit_sigma_m < 0.005, got 0.01"]
    assert verdict.missed_requirements == verdict.failures


@pytest.mark.parametrize(("until", "words"), [(0.0, "never in force"), (40.0, "only 40 % of the time in force")])
def test_compensation_that_was_not_in_force_is_no_success(until, words):
    verdict = judge(record(until), moves_winch=True)
    assert not verdict.is_good
    assert words in verdict.lines()[1]
    assert "stopped" in verdict.lines()[1], "it says what the controller did instead"


@pytest.mark.parametrize("until", [0.0, 40.0])
def test_a_stop_that_somebody_has_asked_for_is_no_failure_and_any_other_is(until):
    assert judge(record(until, reason="stop requested"), moves_winch=True).is_good
    for reason in ("mru frozen", "emergency stop requested"):
        assert not judge(record(until, reason=reason), moves_winch=True).is_good


def test_a_law_that_is_off_need_not_compensate():
    assert judge(record(0.0), moves_winch=False).is_good


def test_a_figure_that_is_not_known_is_missed():
    verdict = judge(record(100.0), [Criterion("kappa", "<=", 2.0)], moves_winch=True)
    assert verdict.failures == ["MISSED: kappa <= 2.0, got unknown"]


def test_a_cable_that_would_have_parted_is_no_success():
    good = judge(replace(record(100.0), largest_strain=0.0999), moves_winch=True)
    assert good.is_good
    parted = judge(
        replace(record(100.0), largest_strain=0.2434), [Criterion("unit_sigma_m", "<", 1.0)], moves_winch=True
    )
    assert parted.lines()[:2] == [
        "verdict: FAILED",
        "  MISSED: cable strained by at most 10 %, got 24.3 %: it would part, or its tension law does not hold",
    ]


def test_a_run_that_ended_within_its_transient_is_not_judged_but_held_to_what_is_required():
    short = record(0.0, is_past_transient=False)
    verdict = judge(short, [Criterion("unit_sigma_m", "<", 0.001)], moves_winch=True)
    assert verdict.is_good
    assert "ended within its transient" in verdict.lines()[0]
    required = judge(short, required=[Criterion("unit_sigma_m", "<", 0.001)], moves_winch=True)
    assert required.missed_requirements == ["MISSED: unit_sigma_m < 0.001, got 0.01"]
    met = judge(short, required=[Criterion("unit_sigma_m", "<", 0.1)], moves_winch=True)
    assert met.lines()[0].startswith("verdict: on what --require asks alone, the run ended within its transient")


def test_a_figure_that_a_short_run_cannot_have_says_what_it_needs():
    judged = Judged(Criterion("worst_minute", "<=", 1.05), math.nan)
    assert str(judged) == "MISSED: worst_minute <= 1.05, got unknown: it needs 60 s after the transient"
