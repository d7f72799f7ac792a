"""What stands beside the figures of an answer: their bands, against sums by hand, and what the record lacks for it."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from heave_bringup.errors import CommandError
from heave_node.interface.codes import WinchLimit
from heave_studies.whatif import fitness
from heave_studies.whatif.answer import Answer, Figures, Spread, lost, with_bands
from heave_studies.whatif.identify import USUAL, CableFit

LIMITS_HIT = np.array([WinchLimit.FLOW, 0, WinchLimit.SPEED, WinchLimit.SPEED | WinchLimit.POWER | WinchLimit.PAYOUT])
"""Of four ticks, the first before the window, and the ends of the cable no limit that counts."""

SHOWN = {"cable and unit": True, "winch": True, "winch limits": True}


@pytest.mark.parametrize(
    ("law", "shown", "limit", "band", "words"),
    [
        ("mpc", {}, 0.0, (0.95, 0.99), ""),
        ("mpc", {"winch limits": False}, 0.0, (0.95, 0.99), ""),
        ("off", {"winch": False, "winch limits": False}, 0.0, (0.0, 0.0), ""),
        ("industrial", {}, 0.0, (0.62, 0.82), "its efficiency is anywhere from 62 to 82 %"),
        ("mpc", {"winch": False}, 0.0, (0.95, 0.99), "how the winch answers is assumed (winch)"),
        ("mpc", {}, 12.0, (0.95, 0.99), ""),
        (
            "mpc",
            {"winch limits": False},
            12.0,
            (0.95, 0.99),
            "it is at the winch's limits (speed and power) for 12.0 % of the time, and they are assumed",
        ),
        (
            "lqg",
            {"cable and unit": False, "winch": False},
            0.0,
            (0.95, 0.99),
            "cable and unit are not known from it (cable and unit); how the winch answers is assumed (winch)",
        ),
    ],
)
def test_what_the_record_lacks_for_an_answer_is_said_and_no_more(monkeypatch, law, shown, limit, band, words):
    monkeypatch.setattr(fitness, "reported", lambda known: [(of, yes, of) for of, yes in (SHOWN | shown).items()])
    known = SimpleNamespace(fit=SimpleNamespace(chi2=1.0), window=slice(1, 4))
    values = {"time_at_limit_percent": limit, "unit_efficiency": sum(band) / 2.0}
    figures = SimpleNamespace(values=values, bands={"unit_efficiency": band})
    asked = SimpleNamespace(law=law)
    done = SimpleNamespace(limits_hit=LIMITS_HIT)
    answer = SimpleNamespace(asked=asked, figures=figures, lost=0, done=done, is_refused=False)
    lines = fitness.warnings(known, [answer])
    assert lines == ([f"{law}: this record does not show all that the answer stands on: {words}"] if words else [])


def test_an_efficiency_at_one_end_of_its_band_is_no_better_known(monkeypatch):
    monkeypatch.setattr(fitness, "reported", lambda known: [(of, True, of) for of in SHOWN])
    values = {"time_at_limit_percent": 0.0, "unit_efficiency": 0.98}
    figures = SimpleNamespace(values=values, bands={"unit_efficiency": (0.91, 1.0)})
    answer = SimpleNamespace(asked=SimpleNamespace(law="lqg"), figures=figures)
    assert fitness.lacks(SimpleNamespace(), answer) == ["its efficiency is anywhere from 91 to 100 %"]


def test_a_value_far_from_what_was_known_before_is_refused_with_what_to_check(monkeypatch):
    # a load cell in kN that is read as tf: 9.8 times the tension of a cable whose stiffness is known to 10 %
    fit = CableFit({"cable.stiffness_factor": 2.5, "mru.delay": -0.08}, np.eye(2), USUAL, 1.0)
    monkeypatch.setattr(fitness, "off_sigma", lambda known: 1.0)
    record, plant = SimpleNamespace(time=np.zeros(1)), SimpleNamespace(least_tension=np.ones(1))
    past = SimpleNamespace(record=record, plant=plant)
    known = SimpleNamespace(fit=fit, left=0.0, past=past, evidence=SimpleNamespace(start=0.0))
    with pytest.raises(CommandError) as refused:
        fitness.check_known(known, "bag")
    assert str(refused.value) == (
        "bag: cable.stiffness_factor is identified as 2.5, 9 standard deviations from what was known before: "
        f"{fitness.CHECK}"
    )


@pytest.mark.parametrize(
    ("lost_at", "lost", "is_refused"),
    [(144.2, 1, True), (math.inf, 4, True), (math.inf, 3, False), (math.inf, 0, False)],
)
def test_figures_of_a_law_that_gives_up_are_withheld(lost_at, lost, is_refused):
    """Of seven plants; the chance of it and its alarm are the answer then."""
    values = dict.fromkeys(fitness.BRIEF, 0.5)
    figures = Figures(values, {"unit_efficiency": (0.4, 0.6)}, lost_at, "LITTLE_GAIN")
    asked = SimpleNamespace(law="industrial")
    answer = Answer(asked, figures, None, 7, lost, "LITTLE_GAIN" if lost else "")
    result = fitness.Result((), (), None, figures, [answer])
    assert answer.is_refused is is_refused
    (_, row) = fitness.ANSWERS.cells(result.rows)
    assert row[:2] == ["industrial", f"{lost} of 7"]
    assert (set(row[2:]) == {"-"}) is is_refused
    known = SimpleNamespace(fit=SimpleNamespace(chi2=1.0))
    if is_refused:
        (line,) = fitness.warnings(known, [answer])
        assert f"gives up compensation on {lost} of 7 plants that the record allows" in line
        assert line.endswith("LITTLE_GAIN; when it does hangs on thresholds, so its figures are withheld")


def test_a_law_that_never_began_has_given_up_at_its_first_alarm():
    alarm = SimpleNamespace(code="COMMANDS_TOO_LATE", brief="commands come too late")
    time = np.arange(3.0)
    for modes, lost_at, cause in (
        (("standby",) * 3, 2.0, "it never began: commands come too late"),
        (("standby", "compensating", "compensating"), math.inf, ""),
        (("off",) * 3, math.inf, ""),  # asked for
        (("",) * 3, math.inf, ""),  # a record that does not say
    ):
        assert lost(SimpleNamespace(time=time, modes=modes, alarms=((2.0, alarm),))) == (lost_at, cause)
    assert lost(SimpleNamespace(time=time, modes=("standby",) * 3, alarms=())) == (0.0, "it never began")


def test_motion_by_an_unknown_boom_tip_may_be_none() -> None:
    # 5 mm, 3 mm of them added for what is not known of the tip: sqrt(25 - 9) = 4 mm without; 1 mm of 100 is 1 point
    base = Figures({"unit_sigma_m": 0.005, "unit_efficiency": 0.95})
    certain = Spread(loops=[], added=0.0, locked=0.0, model=0.0)
    bands = with_bands(base, certain, 0.1, by_tip=0.003).bands
    assert bands["unit_sigma_m"] == pytest.approx((0.004, 0.005))
    assert bands["unit_efficiency"] == pytest.approx((0.95, 0.96))


def test_what_cannot_be_below_zero_is_not_in_a_band() -> None:
    # 0.3 m/s off in the one draw: half a band of 1.645 x 2.5 x 0.3 = 1.23 m/s
    base = Figures({"unit_sigma_m": 0.1, "unit_efficiency": 0.5, "winch_speed_max_mps": 0.6})
    loops = [{"unit_sigma_m": 0.0, "unit_efficiency": 0.0, "winch_speed_max_mps": 0.3}]
    bands = with_bands(base, Spread(loops=loops, added=0.0, locked=0.0, model=0.0), 0.2).bands
    assert bands["winch_speed_max_mps"] == pytest.approx((0.0, 0.6 + 1.23375))
