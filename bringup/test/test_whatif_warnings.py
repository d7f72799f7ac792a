"""What stands beside the figures of an answer: what the record lacks for it."""

from types import SimpleNamespace

import numpy as np
import pytest
from heave_bringup.errors import CommandError
from heave_bringup.whatif import fitness
from heave_bringup.whatif.identify.cable import CableFit
from heave_bringup.whatif.identify.prior import Prior
from heave_node.interface.codes import WinchLimit

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
    again = SimpleNamespace(is_same=True, refused=())
    past = SimpleNamespace(record=SimpleNamespace(has_orders=True, is_own=True))
    fit = SimpleNamespace(chi2=1.0, values={})
    known = SimpleNamespace(fit=fit, snapped=np.zeros(3), again=again, past=past, window=slice(1, 4))
    values = {"time_at_limit_percent": limit, "unit_efficiency": sum(band) / 2.0}
    figures = SimpleNamespace(values=values, bands={"unit_efficiency": band})
    asked = SimpleNamespace(name="first", controller=SimpleNamespace(law=law))
    answer = SimpleNamespace(asked=asked, figures=figures, done=SimpleNamespace(refused=(), limits_hit=LIMITS_HIT))
    lines = fitness.warnings(known, [answer])
    assert lines == ([f"first: this record does not show all that the answer stands on: {words}"] if words else [])


def test_an_efficiency_at_one_end_of_its_band_is_no_better_known(monkeypatch):
    monkeypatch.setattr(fitness, "reported", lambda known: [(of, True, of) for of in SHOWN])
    values = {"time_at_limit_percent": 0.0, "unit_efficiency": 0.98}
    figures = SimpleNamespace(values=values, bands={"unit_efficiency": (0.91, 1.0)})
    answer = SimpleNamespace(asked=SimpleNamespace(controller=SimpleNamespace(law="lqg")), figures=figures)
    assert fitness.lacks(SimpleNamespace(), answer) == ["its efficiency is anywhere from 91 to 100 %"]


def test_a_value_far_from_what_was_known_before_is_refused():
    # a load cell in kN that is read as tf: 9.8 times the tension of a cable whose stiffness is known to 10 %
    sigma = {"cable.stiffness_factor": 0.1, "mru.delay": 0.04}
    prior = Prior(sigma, dict.fromkeys(sigma, 0.0))
    values = {"cable.stiffness_factor": 2.5, "mru.delay": -0.08}
    fit = CableFit(values, np.eye(2), prior, None, 0.0, 1.0, 100.0)
    evidence = SimpleNamespace(shares=(0.0, 1.0))
    known = SimpleNamespace(fit=fit, evidence=evidence, left=0.0)
    with pytest.raises(CommandError) as refused:
        fitness.check_fit(known, 1.0, "bag")
    assert str(refused.value) == (
        "bag: cable.stiffness_factor is identified as 2.5, 9 standard deviations from what was assumed: of the boom "
        "tip's heave the drum takes out 0.00 and the unit shows 1.00, which should add up to 1: check units, signs and "
        "columns of MRU, encoder, depth sensor and load cell; if it is so, give --know cable.stiffness_factor=2.5+-5%"
    )
