"""A move of millimetres: what a drum with a lag, a reversed one and one of another scale show."""

import argparse
from types import SimpleNamespace

import numpy as np
import pytest
from heave_bringup.errors import ExitStatus, VerdictError
from heave_devices.bench.wiggle import DURATION, LEAST, is_too_far, judge, move_at, other_verdicts
from heave_devices.bench.winch import Sample
from heave_devices.commands import adapt

DISTANCE, STEP = 0.02, 0.02


def drum(gain=1.0, rate_gain=1.0, lag=0.15, count_gain=1.0):
    """Return the readings of a drum that follows the commanded rate with a first-order lag."""
    payout = rate = 0.0
    readings = []
    for time in np.arange(0.0, DURATION, STEP):
        rate += (gain * move_at(time, DISTANCE)[1] - rate) * STEP / lag
        payout += rate * STEP
        readings.append(Sample(time + STEP, count_gain * payout, rate_gain * rate, brake=0.0, fault=0.0))
    return readings


def test_the_commanded_rate_is_that_of_the_commanded_place():
    times = np.arange(0.0, DURATION, 1e-3)
    places, rates = np.array([move_at(time, DISTANCE) for time in times]).T
    assert np.gradient(places, times) == pytest.approx(rates, abs=1e-4 * DISTANCE)
    assert (places.max(), places[-1]) == (pytest.approx(DISTANCE), pytest.approx(0.0, abs=1e-12))


@pytest.mark.parametrize(
    ("given", "wrong", "words"),
    [
        ({}, [], ""),
        ({"gain": 0.9}, [], ""),
        ({"gain": -1.0}, ["payout, out", "payout, back", "payout rate, out"], "reversed. Check positive"),
        ({"rate_gain": -1.0}, ["payout rate, out"], "reversed"),
        ({"rate_gain": 60.0}, ["payout rate, out"], "60 times. Check unit and scale"),
        ({"count_gain": 0.01}, ["payout, out", "payout, back"], "while the speed is as ordered. Check unit, scale"),
        ({"count_gain": -1.0}, ["payout, out", "payout, back"], "Check unit, scale and sign of payout"),
        ({"gain": 2.0}, ["payout, out", "payout, back", "payout rate, out"], "2 times"),
        ({"gain": 0.0}, ["payout, out", "payout, back", "payout rate, out"], "it hardly moved. Check enable"),
    ],
)
def test_what_is_wrong_is_named(given, wrong, words):
    verdicts = judge(drum(**given), DISTANCE)
    assert [verdict.what for verdict in verdicts if not verdict.is_good] == wrong
    assert all(words in verdict.words for verdict in verdicts if not verdict.is_good)


def test_a_silent_winch_is_named():
    (verdict,) = judge([], DISTANCE)
    assert not verdict.is_good


def test_a_drum_that_runs_away_is_seen_within_millimetres():
    assert not is_too_far(1.2 * LEAST, 0.0, LEAST)
    assert is_too_far(0.0081, 0.0, LEAST)


@pytest.mark.parametrize(
    ("was_tripped", "seen", "untried"),
    [
        (False, [], "direction, fault, reset"),
        (True, [], "direction"),
        (False, ["direction", "fault"], "reset"),
        (True, ["direction"], ""),
    ],
)
def test_what_a_move_cannot_show_is_no_pass_until_somebody_has_seen_it(was_tripped, seen, untried, capsys):
    """Both signs reversed, a fault bit that never sets and a reset that resets nothing move as a right winch does."""
    verdicts = judge(drum(), DISTANCE) + other_verdicts(("fault", "reset"), {}, was_tripped=was_tripped)
    session = SimpleNamespace(alone=lambda _: verdicts)
    options = argparse.Namespace(json=None, wiggle=20.0, seen=seen)
    if untried:
        with pytest.raises(adapt.IncompleteError, match=f"verdict INCOMPLETE: {untried}: no move shows it") as ended:
            adapt._wiggle(options, session)
        assert ended.value.status == ExitStatus.VERDICT_FAILED
    else:
        adapt._wiggle(options, session)
    shown = capsys.readouterr()
    assert ("verdict: passed" in shown.err) is (not untried)
    assert shown.out.count("not tried") == len(untried.split())


def test_what_is_wrong_beside_the_move_is_a_verdict_that_has_failed():
    wrong = {"brake": "input:4.2 must read engaged", "device_time": ""}
    verdicts = judge(drum(), DISTANCE) + other_verdicts((), wrong, was_tripped=False)
    session = SimpleNamespace(alone=lambda _: verdicts)
    with pytest.raises(VerdictError, match="brake: not as the map says") as found:
        adapt._wiggle(argparse.Namespace(json=None, wiggle=20.0, seen=["direction"]), session)
    assert "device_time" not in str(found.value)


def test_a_wrong_map_is_a_verdict_that_has_failed():
    session = SimpleNamespace(alone=lambda _: judge(drum(gain=-1.0), DISTANCE))
    with pytest.raises(VerdictError, match="payout, out: not as the map says"):
        adapt._wiggle(argparse.Namespace(json=None, wiggle=20.0, seen=[]), session)
