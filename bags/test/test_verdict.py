"""The verdict on a run: its criteria, the values reached, and whether compensation was active at all."""

import math
from dataclasses import replace

import numpy as np
import pytest
from heave_bags.analyse.events import Interval
from heave_bags.analyse.run_record import RunRecord
from heave_bags.analyse.run_warnings import warnings
from heave_bags.analyse.verdict import FAILED, NO_VERDICT, PASSED, Judged, judge
from heave_bags.signals import RunSignals, Signal
from heave_node.criteria import Criterion
from heave_node.loads.strength import strengths

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
    assert (verdict.is_good, verdict.state) == (True, PASSED)
    assert verdict.to_json()["criteria"] == [
        {
            "kpi": "unit_sigma_m",
            "wanted": "<= 0.02",
            "got": pytest.approx(0.01),
            "met": True,
            "words": "Load heave, standard deviation 1.00 cm (required at most 2 cm): met",
        }
    ]
    assert "1.00 cm" in verdict.lines()[1], "in the unit of the tables"
    assert "2 cm" in verdict.lines()[1]


def test_a_missed_criterion_comes_first_and_shouts():
    wanted = [Criterion("unit_sigma_m", "<=", 0.02), Criterion("unit_sigma_m", "<", 0.005)]
    verdict = judge(record(100.0), wanted, moves_winch=True, alarms=2)
    assert verdict.state == FAILED
    assert [judged.is_met for judged in verdict.criteria] == [True, False]
    assert "0.5 cm" in verdict.lines()[1]
    assert len(verdict.lines()) == 5
    assert verdict.lines()[-1] == "  Rope strength not stated: not judged (system.cable.breaking_force)"


def test_a_criterion_of_scenario_and_command_line_is_told_once():
    same = [Criterion("unit_sigma_m", "<", 0.005)]
    verdict = judge(record(100.0), same, required=same, moves_winch=True)
    assert (len(verdict.criteria), len(verdict.failures), verdict.state) == (1, 1, FAILED)


@pytest.mark.parametrize("until", [0.0, 40.0])
def test_compensation_that_was_not_in_force_is_no_success(until):
    verdict = judge(record(until), moves_winch=True)
    assert verdict.state == FAILED
    (breach,) = verdict.breaches
    assert f"{until:.0f} %" in breach
    assert "stopped" in breach, "it says what the controller did instead"


@pytest.mark.parametrize("until", [0.0, 40.0])
def test_a_stop_that_somebody_has_asked_for_is_no_failure_and_any_other_is(until):
    assert judge(record(until, reason="stop requested"), moves_winch=True).is_good
    for reason in ("mru frozen", "emergency stop requested"):
        assert not judge(record(until, reason=reason), moves_winch=True).is_good


def test_a_law_that_is_off_need_not_compensate():
    assert judge(record(0.0), moves_winch=False).is_good


def test_a_figure_that_is_not_known_is_missed():
    verdict = judge(record(100.0), [Criterion("kappa", "<=", 2.0)], moves_winch=True)
    assert verdict.state == FAILED
    assert math.isnan(verdict.criteria[0].value)


def test_a_cable_that_would_have_parted_is_no_success():
    good = judge(replace(record(100.0), largest_strain=0.0999), moves_winch=True)
    assert good.is_good
    parted = judge(
        replace(record(100.0), largest_strain=0.2434), [Criterion("unit_sigma_m", "<", 1.0)], moves_winch=True
    )
    assert parted.state == FAILED
    (breach,) = parted.breaches
    assert "24.3 %" in breach


def test_a_run_that_ended_within_its_transient_is_not_judged_but_held_to_what_is_required():
    short = record(0.0, is_past_transient=False)
    verdict = judge(short, [Criterion("unit_sigma_m", "<", 0.001)], moves_winch=True)
    assert (verdict.is_good, verdict.state) == (True, NO_VERDICT)
    required = judge(short, required=[Criterion("unit_sigma_m", "<", 0.001)], moves_winch=True)
    assert required.state == FAILED
    met = judge(short, required=[Criterion("unit_sigma_m", "<", 0.1)], moves_winch=True)
    assert met.state == NO_VERDICT


@pytest.mark.parametrize("window, state", [(4.0, NO_VERDICT), (59.0, NO_VERDICT), (60.0, PASSED)])
def test_a_verdict_needs_a_minute_after_the_transient(window, state):
    short = replace(record(100.0), start=40.0, end=40.0 + window)
    verdict = judge(short, [Criterion("unit_sigma_m", "<", 0.1)], moves_winch=True)
    assert (verdict.state, verdict.why_not_judged == "") == (state, state == PASSED)
    assert judge(short, required=[Criterion("unit_sigma_m", "<", 0.001)], moves_winch=True).state == FAILED


def test_a_verdict_says_that_compensation_was_active_and_in_which_sea():
    played = replace(record(100.0), run={"seed": "7", "replaced": "wave_vessel=bag"})
    played.sea = "jonswap, Hs 2 m, Tp 9 s, seed 3"
    lines = judge(played, [Criterion("unit_sigma_m", "<", 0.1)], moves_winch=True).lines()
    assert lines[0] == "verdict: passed for one sea, from a bag: jonswap, Hs 2 m, Tp 9 s, seed 3"
    assert "  Compensation active 100 % of the time (required at least 90 %): met" in lines
    simulated = replace(played, run={"seed": "7"})
    assert judge(simulated, [], required=[], moves_winch=True).sea == "seed 7"


@pytest.mark.parametrize("played", ["cable_sim", "virtual_winch"])
def test_a_run_whose_winch_or_load_no_command_moves_is_not_judged_but_held_to_what_is_required(played):
    open_loop = replace(record(0.0), run={"replaced": f"wave_vessel=bag {played}=bag"}, largest_strain=0.5)
    missed = [Criterion("unit_sigma_m", "<", 0.001)]
    verdict = judge(open_loop, missed, moves_winch=True, alarms=2)
    assert (verdict.is_good, verdict.state) == (True, NO_VERDICT)
    assert verdict.lines()[0] == (
        f"no verdict: open loop: the figures are those of the recorded {played}, which no command moved; "
        "2 errors reported"
    )
    assert judge(open_loop, required=missed, moves_winch=True).state == FAILED


@pytest.mark.parametrize("replaced", ["wave_vessel=bag", "virtual_winch", "winch_controller=bag", ""])
def test_a_run_whose_winch_obeys_is_judged(replaced):
    closed_loop = replace(record(100.0), run={"replaced": replaced})
    assert judge(closed_loop, [Criterion("unit_sigma_m", "<=", 0.02)], moves_winch=True).state == PASSED


def test_a_figure_that_a_short_run_cannot_have_says_what_it_needs():
    judged = Judged(Criterion("worst_minute", "<=", 1.05), math.nan)
    assert not judged.is_met
    assert "60 s after the transient" in str(judged)


@pytest.mark.parametrize(
    ("key", "relation", "bound", "value", "words"),
    [
        ("significant_residual_m", "<=", 0.05, 0.02526, "Significant residual 2.53 cm (required at most 5 cm): met"),
        ("unit_efficiency", ">=", 0.95, 0.9, "Efficiency at the load 90.0 % (required at least 95 %): FAILED"),
        ("tension_max_n", "<", 5e5, 53e4, "Top tension, largest 530.0 kN (required below 500 kN): FAILED"),
        ("snaps", "<", 1.0, 0.0, "Snaps 0 (required below 1): met"),
    ],
)
def test_a_criterion_reads_as_a_sentence_in_the_unit_of_the_tables(key, relation, bound, value, words):
    assert str(Judged(Criterion(key, relation, bound), value)) == words


def test_a_value_that_misses_by_less_than_the_table_shows_is_told_from_its_bound():
    """5.0004 cm would read 5.00 cm, which is at most 5 cm."""
    missed = Judged(Criterion("significant_residual_m", "<=", 0.05), 0.050004)
    assert "5.0004 cm" in str(missed)


def under_load(tension: float, *, until: float = 100.0, capacity: float = 494e3) -> RunRecord:
    """Return a run whose top tension is 300 kN but for a peak of `tension` [N] at 3 s, before its window begins."""
    run = record(until)
    run.start = 10.0
    pull = np.full(TIME.size, 300e3)
    pull[60] = tension
    run.signals.tension = Signal(TIME, pull)
    run.signals.strengths = strengths({"cable.breaking_force": capacity}, {})
    return run


def test_a_rope_that_carried_more_than_its_breaking_force_is_no_success_at_any_time_of_the_run():
    verdict = judge(under_load(530e3), [Criterion("unit_sigma_m", "<=", 0.02)], moves_winch=True)
    assert verdict.state == FAILED
    (check,) = verdict.loads
    assert check.factor == pytest.approx(494.0 / 530.0)
    assert len(verdict.breaches) == 1
    run = under_load(530e3)
    assert len(warnings(run, run.kpis())) == 1, "heave kpi, which gives no verdict, reports it too"
    assert verdict.to_json()["loads"] == [check.to_json()]


@pytest.mark.parametrize(("capacity", "state"), [(760e3, "FAILED"), (761e3, "met")])
def test_a_rope_with_less_than_the_factor_of_lifting_practice_fails(capacity, state):
    """1.3 x 1.3 x 1.5 times the 300 kN are 760.5 kN."""
    run = under_load(300e3, capacity=capacity)
    verdict = judge(run, moves_winch=True)
    assert verdict.is_good is (state == "met")
    assert [check.state for check in verdict.loads] == [state]
    assert len(warnings(run, run.kpis())) == (state == "FAILED")


def test_a_load_that_is_not_known_and_a_strength_that_is_not_stated_break_nothing():
    run = record(100.0)
    run.signals.strengths = strengths({"cable.breaking_force": 494e3, "unit.attachment_breaking_force": 0.0}, {})
    verdict = judge(run, moves_winch=True)
    assert verdict.is_good
    assert [check.state for check in verdict.loads] == ["unknown"]
    assert verdict.remarks == []
