"""The place that belongs to a commanded speed: a drum that follows it moves as one that follows the speed."""

import numpy as np
import pytest
from scipy.signal import lsim
from winch_controller_node.core.loop_command import LEAK, REACH

from tests.core_parts import Place

DT = 0.05


@pytest.mark.parametrize("lag", [0.2, 0.5, 1.0])
def test_a_position_loop_follows_it_as_a_speed_loop_of_the_same_lag_follows_the_speed(lag):
    """Both by `scipy.signal.lsim`, from a sea of four sines; what differs is the leak of a minute."""
    times = DT * np.arange(2400)
    rates = 0.2 * sum(np.sin(2.0 * np.pi * times / period + period) for period in (5.0, 7.0, 9.0, 13.0))
    _, speeds, _ = lsim(([1.0], [lag, 1.0]), rates, times, interp=False)
    by_speed = np.concatenate([[0.0], np.cumsum(DT * speeds)[:-1]])
    place, drum, by_place = Place(LEAK, REACH), 0.0, []
    for rate in rates:
        by_place.append(drum)
        end = place.at_end(DT, float(rate), drum, is_braked=False)
        start = end - DT * float(rate)
        # the exact way of a first-order loop whose set-point runs from the place before to this one within the tick
        decay = np.exp(-DT / lag)
        drum = drum * decay + start * (1.0 - decay) + float(rate) * (DT - lag * (1.0 - decay))
    difference = np.array(by_place) - by_speed
    assert np.std(difference[400:] - np.mean(difference[400:])) < 0.05 * np.std(by_speed[400:])


def test_it_begins_where_the_drum_is_and_stays_there_under_the_brake():
    place = Place(LEAK, REACH)
    assert place.at_end(DT, 0.4, 12.0, is_braked=True) == 12.0
    assert place.at_end(DT, 0.4, 12.0, is_braked=False) == pytest.approx(12.02)
    assert place.at_end(DT, 0.0, 7.0, is_braked=True) == 7.0
    assert place.at_end(DT, -0.2, 7.0, is_braked=False) == pytest.approx(6.99)


def test_it_never_leads_a_drum_that_does_not_follow_by_more_than_its_reach():
    place = Place(LEAK, REACH)
    places = [place.at_end(DT, 1.0, 5.0, is_braked=False) for _ in range(400)]
    assert max(places) == 5.0 + REACH
