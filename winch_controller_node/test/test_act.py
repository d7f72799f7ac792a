"""The acting half of a tick in the core: what leaves is what was commanded, and nothing is allocated for it."""

import numpy as np
import pytest
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.scenarios import load_scenario
from heave_core.law_table import ACT_DONE, COMMAND, GIVEN, NOTED, Stage
from scipy.signal import lsim
from winch_controller_node.core.component import ACTED
from winch_controller_node.core.loop_command import LEAK, REACH
from winch_controller_node.interface.observations import TICK_COLUMNS

from tests.allocation import allocates
from tests.core_parts import Place

TICK = 0.05


def settled(*changes):
    """Return a loop of 300 m that compensates, after 50 s."""
    given = ["all.duration=200", "all.seed=1", *changes]
    loop = ClosedLoop(loop_parameters(load_scenario("b2_calm_300", settings=given)))
    for _ in range(round(50.0 / TICK)):
        loop.step()
    return loop


def numbers_of(structure, array):
    return dict(zip((row.name for row in structure.rows), array.tolist(), strict=True))


@pytest.mark.parametrize("gain", [0.0, 0.5])
def test_a_drive_makes_the_commanded_speed_of_the_order_wherever_its_payout_is(gain):
    """v = rate + k (payout - u) with u as it is predicted: by both set-points of the tick, and by the mean payout's."""
    loop = settled(f"system.winch.position_gain={gain}")
    command = loop.controller._command
    for _ in range(40):
        outputs, _ = loop.step()
        done, made = numbers_of(ACT_DONE, loop.controller._control.done[ACTED:]), numbers_of(COMMAND, command._numbers)
        order, encoder = outputs.order, loop.controller.observer.encoder
        ahead = encoder.scale * (made["payout"] + encoder.offset)
        assert not done["is_replaced"]
        wanted = made["sent"] - made["standing"]
        assert order.payout_rate + gain * (order.payout - ahead) == pytest.approx(wanted, abs=1e-9)
        assert done["own_rate"] + gain * (done["own_payout"] - made["payout"]) == pytest.approx(wanted, abs=1e-9)
        assert made["value"] == made["compensating"] + made["mean"]


def test_nothing_is_allocated_from_the_readings_to_the_order_that_leaves():
    control = settled().controller._control
    number = [row.name for row in GIVEN.rows].index("number")

    def go():
        control.given[number] += 1.0
        stage = control.go_on(Stage.BEGIN)
        while stage:
            stage = control.go_on(stage)

    go()
    assert not allocates(go)


def test_the_core_notes_for_the_adviser_what_the_columns_of_an_observation_say():
    assert tuple(row.name for row in NOTED.rows) == TICK_COLUMNS


# the place that belongs to a commanded speed


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
