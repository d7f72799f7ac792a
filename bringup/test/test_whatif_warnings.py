"""What stands beside the figures of an answer: what the record lacks for it."""

from types import SimpleNamespace

import numpy as np
import pytest
from heave_bringup.whatif import fitness
from heave_bringup.whatif.identify.cable import CableFit
from heave_bringup.whatif.identify.prior import Prior

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
            "it is at the winch's limits for 12.0 % of the time, and they are assumed",
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
    known = SimpleNamespace(fit=SimpleNamespace(chi2=1.0, values={}), snapped=np.zeros(3), again=again, past=past)
    figures = SimpleNamespace(values={"time_at_limit_percent": limit}, bands={"unit_efficiency": band})
    asked = SimpleNamespace(name="first", controller=SimpleNamespace(law=law))
    answer = SimpleNamespace(asked=asked, figures=figures, done=SimpleNamespace(refused=()))
    lines = fitness.warnings(known, [answer])
    assert lines == ([f"first: the record does not suffice: {words}"] if words else [])


def test_a_value_far_from_what_was_known_before_is_said():
    # a load cell in kN that is read as tf: 9.8 times the tension of a cable whose stiffness is known to 10 %
    sigma = {"cable.stiffness_factor": 0.1, "mru.delay": 0.04}
    prior = Prior(sigma, dict.fromkeys(sigma, 0.0))
    values = {"cable.stiffness_factor": 2.5, "mru.delay": -0.08}
    fit = CableFit(values, np.eye(2), prior, None, 0.0, 1.0, 100.0)
    past = SimpleNamespace(record=SimpleNamespace(has_orders=True, is_own=True))
    again = SimpleNamespace(is_same=True)
    (line,) = fitness.warnings(SimpleNamespace(fit=fit, snapped=np.zeros(3), again=again, past=past), [])
    assert line.startswith("cable.stiffness_factor is identified as 2.5, 9 standard deviations from what was assumed")
