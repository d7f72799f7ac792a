"""A preview of the boom tip is used while it proves right, and is not used, with a reason, where it does not."""

import math

import numpy as np
import pytest
from heave_node.interface.preview import HeavePreview
from heave_node.interface.sensors import MruReading
from winch_controller_node.core.component import WinchController
from winch_controller_node.core.estimation.preview_watch import PROOF_TIME, PreviewWatch
from winch_controller_node.interface.readings import Measurements
from winch_controller_node.laws.mpc import MpcParameters
from winch_controller_node.laws.parts.preview import PreviewUse
from winch_controller_node.node_parameters import WinchControllerParameters

DT, TICK = 0.05, 50_000_000
AHEAD = DT * np.arange(1, 121)
USE = PreviewUse(first=0.25, last=4.0, noise=0.05)
TICKS = round((PROOF_TIME + 3.0) / DT)


def heave(time):
    return np.sin(0.8 * np.asarray(time))


def true_preview(tick):
    return HeavePreview(AHEAD, heave(tick * DT + AHEAD), tick * TICK)


def watch_for(preview_of, ticks=TICKS, use=USE):
    """Give previews for some ticks; return the watch and what the last tick gave."""
    watch, used = PreviewWatch(use, tick_period=DT), None
    for tick in range(1, ticks + 1):
        used = watch.step(tick * TICK, preview_of(tick), float(heave(tick * DT)))
    return watch, used


def test_a_preview_is_used_once_it_has_come_true_for_ten_seconds():
    watch, used = watch_for(true_preview, round(PROOF_TIME / DT))
    assert used is None
    assert "10 s before it is used" in watch.fault
    watch, used = watch_for(true_preview)
    assert watch.words == "used"
    np.testing.assert_allclose(used.heave, true_preview(TICKS).heave)


def test_a_preview_that_comes_once_a_second_is_counted_from_now():
    """Radars are slow: what lies behind is no longer ahead, and times are those after the tick."""
    _, used = watch_for(lambda tick: true_preview(tick) if tick % 20 == 1 else None, TICKS - TICKS % 20)
    now = (TICKS - TICKS % 20) * DT
    assert used.ahead[0] == pytest.approx(DT - 0.95)
    np.testing.assert_allclose(used.heave, heave(now + used.ahead), atol=1e-9)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (lambda p: HeavePreview(p.ahead, -p.heave, p.stamp), "error 1."),
        (lambda p: HeavePreview(p.ahead, p.heave + 1.0, p.stamp), "error 1.00 m rms"),
        (lambda p: HeavePreview(p.ahead + 2.0, p.heave, p.stamp), "2.05 to 8 s ahead"),
        (lambda p: HeavePreview(p.ahead[:60], p.heave[:60], p.stamp), "0.25 to 4 s"),
        (lambda p: HeavePreview(p.ahead, p.heave[:60], p.stamp), "120 times and 60 heaves"),
        (lambda p: HeavePreview(p.ahead[:0], p.heave[:0], p.stamp), "0 times and 0 heaves"),
        (lambda p: HeavePreview(p.ahead, np.where(p.ahead > 5.0, math.nan, p.heave), p.stamp), "not finite"),
        (lambda p: HeavePreview(p.ahead[::-1], p.heave, p.stamp), "do not increase"),
        (lambda p: HeavePreview(p.ahead, p.heave, p.stamp + 10 * TICK), "0.5 s ahead of the clock"),
    ],
)
def test_one_that_is_wrong_is_left_out_and_the_reason_said(wrong, words):
    watch, used = watch_for(lambda tick: wrong(true_preview(tick)))
    assert used is None
    assert words in watch.fault


def test_one_that_has_fallen_silent_is_used_as_far_as_it_reaches_and_no_longer_than_five_seconds():
    last = TICKS

    def until_then(tick):
        return true_preview(tick) if tick <= last else None

    assert watch_for(until_then, last + 39)[1] is not None, "6 s reach 4 s ahead for 2 s more"
    watch, used = watch_for(until_then, last + 45)
    assert used is None
    assert "to 3.75 s ahead" in watch.fault
    watch, _ = watch_for(until_then, last + 120)
    assert "no data for more than 5 s" in watch.fault


def test_where_nobody_publishes_one_or_the_law_wants_none_nothing_is_said():
    watch, used = watch_for(lambda _: None)
    assert (used, watch.fault, watch.has_come) == (None, "", False)
    watch, used = watch_for(true_preview, use=None)
    assert (used, watch.fault, watch.has_come) == (None, "", True)
    assert "mpc.preview_time" in watch.words


def test_a_preview_counts_for_nothing_while_the_motion_reference_unit_is_lost():
    watch = PreviewWatch(USE, tick_period=DT)
    assert all(watch.step(tick * TICK, true_preview(tick), None) is None for tick in range(1, TICKS))


def test_the_controller_says_when_it_uses_a_preview_and_when_no_more():
    parameters = WinchControllerParameters(mpc=MpcParameters(preview_time=4.0))
    controller, said = WinchController(parameters, tick_period=DT), []
    for tick in range(1, TICKS + 140):
        preview = true_preview(tick) if tick <= TICKS else None
        mru = (MruReading(tick * DT, float(heave(tick * DT)), 0.8 * math.cos(0.8 * tick * DT), sequence=tick),)
        alarms = controller.step(tick, Measurements(mru, preview=preview)).alarms
        said += [alarm.name for alarm in alarms if alarm.row.part == "preview"]
    assert said == ["PREVIEW_USED", "PREVIEW_REJECTED"]
