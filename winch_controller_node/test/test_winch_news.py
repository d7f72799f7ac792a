"""One finding for each change of the winch, however often its model is corrected on the way."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from winch_controller_node.parameters.model import WinchModelParameters
from winch_controller_node.supervision.watch.winch_news import LONGEST, SETTLED, WinchNews

DT = 0.05
WINCH = WinchModelParameters()


def told(models, *, seconds=60.0, is_learning=True):
    """Show each of the models for `seconds`; return what was told with its time."""
    news, words = WinchNews(WINCH, tick_period=DT), []
    for k, winch in enumerate(models):
        for i in range(round(seconds / DT)):
            now = news.update(winch, is_power_limited=False, is_learning=is_learning)
            words += [(k * seconds + i * DT, one) for one in now]
    return words


def test_a_weaker_winch_is_told_once_with_what_it_settled_at():
    limits = [1.2, 0.9, 0.85, 0.8]
    hunting = [replace(WINCH, acceleration_limit=value) for value in limits]
    (when, words), *others = told([*hunting, *hunting[-1:] * 60], seconds=2.0)
    assert not others
    assert words == "winch model updated: acceleration limit 0.800 m/s^2 (was 1.500)"
    assert SETTLED <= when < 2.0 * len(limits) + SETTLED + DT


def test_a_limit_that_was_reached_in_one_direction_alone_is_told_with_it():
    news = WinchNews(WINCH, tick_period=DT)
    weak = replace(WINCH, speed_limit=0.4, acceleration_limit=0.8)
    directions = {"speed_limit": "hauling in"}
    (words,) = news.update(weak, directions=lambda: directions, is_power_limited=False, is_learning=False)
    assert words == (
        "winch model updated: speed limit 0.400 m/s (was 2.000), reached hauling in, "
        "acceleration limit 0.800 m/s^2 (was 1.500)"
    )


def test_a_model_that_never_rests_is_told_of_all_the_same():
    hunting = [replace(WINCH, time_constant=0.15 + 0.1 * (k % 2 + 1)) for k in range(100)]
    words = told(hunting, seconds=2.0)
    assert 0 < len(words) <= 2.0 * len(hunting) / LONGEST


def test_a_winch_that_changes_after_it_was_known_is_told_once_the_record_holds_it_alone():
    """A gain of 0.85, fitted to a record of 20 s that still holds the gain of 1, rests elsewhere for a while."""
    mixed, alone = (replace(WINCH, speed_gain=gain) for gain in (1.023, 0.85))
    ((when, words),) = told([*[WINCH] * 7, mixed, *[alone] * 8], seconds=15.0)
    assert words == "winch model updated: gain by the encoder 0.850 (was 1.000)"
    assert when == pytest.approx(8 * 15.0 + SETTLED, abs=2.0 * DT)


def test_what_is_no_longer_learnt_is_told_at_once():
    ((when, _),) = told([replace(WINCH, speed_gain=0.8)], is_learning=False)
    assert when == 0.0


def test_a_limit_that_recovers_is_no_news_and_one_that_falls_again_is():
    weak = replace(WINCH, speed_limit=0.5)
    let_up = [replace(WINCH, speed_limit=value) for value in (0.55, 0.7, 1.0, 1.5, 2.0)]
    assert len(told([weak, *let_up])) == 1
    assert len(told([weak, *let_up, weak])) == 2


@given(st.lists(st.floats(-0.019, 0.019), min_size=1, max_size=30))
def test_small_corrections_are_never_told(changes):
    models = [replace(WINCH, time_constant=WINCH.time_constant + change) for change in np.array(changes)]
    assert not told(models, seconds=1.0)


def test_lags_that_exchange_a_little_with_each_other_are_no_news_and_much_of_it_is():
    """A drum shows their sum: 0.311 s and 0.313 s here are the same winch."""
    found = replace(WINCH, time_constant=0.181, command_delay=0.130)
    again = replace(WINCH, time_constant=0.144, command_delay=0.169)
    assert len(told([found, again])) == 1
    assert len(told([found, replace(WINCH, time_constant=0.121, command_delay=0.190)])) == 2


def test_a_servo_that_was_not_told_apart_from_the_delay_is_told_with_it():
    """0.326 s together was taken for a delay of 0.176 s, and told so, where the servo was at 0.107 s."""
    ((_, words),) = told([replace(WINCH, command_delay=0.176)])
    assert words == "winch model updated: time constant and command delay together 0.326 s (was 0.350)"
    ((_, words),) = told([replace(WINCH, time_constant=0.151, command_delay=0.3)])
    assert words == "winch model updated: command delay 0.300 s (was 0.200)"


@pytest.mark.parametrize(("gain", "is_news"), [(1.04, False), (0.96, False), (1.08, True)])
def test_a_gain_by_an_encoder_whose_scale_was_found_is_known_no_better_than_that(gain, is_news):
    news = WinchNews(WINCH, tick_period=DT)
    other = replace(WINCH, speed_gain=gain)
    assert bool(news.update(other, is_power_limited=False, is_learning=False, is_rescaled=True)) is is_news


def test_directions_that_differ_by_what_half_a_record_tells_are_no_news():
    assert not told([replace(WINCH, hauling_gain=0.966)])
    ((_, words),) = told([replace(WINCH, hauling_gain=0.9)])
    assert words == "winch model updated: gain of hauling in over that 0.900 (was 1.000)"
