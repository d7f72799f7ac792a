"""Whether the winch does what is predicted of it: authority is reduced while the difference is unexplained."""

import numpy as np
import pytest
from cable_sim_node.winch.component import VirtualWinch, WinchCommand
from cable_sim_node.winch.parameters import WinchParameters
from heave_node.interface.codes import WinchLimit
from winch_controller_node.design.design import design_controller
from winch_controller_node.interface.readings import WinchOrder, WinchReading
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.supervision.watch.winch_watch import CAUTIOUS_SHARE, CAUTIOUS_TIME, WinchWatch

DT = 0.05
PARAMETERS = WinchControllerParameters()


@pytest.fixture(scope="module")
def design():
    return design_controller(PARAMETERS, tick_period=DT)


def shares(design, winch, seconds=20.0, *, believed=None, says=None, slips_at=None):
    """Return the share in each tick of a sea of 0.8 m/s and 9 s, and the watch; the cable slips by 0.1 m at a tick."""
    watch, drum = WinchWatch(design), VirtualWinch(winch, tick_period=DT)
    watch.take(believed or {})
    drum.step(0, WinchCommand(1))
    found = []
    for tick in range(1, round(seconds / DT)):
        rate = 0.8 * np.sin(0.7 * tick * DT)
        watch.give(WinchOrder(tick + 1, 0.0, rate, brake=False))
        state = drum.step(tick, WinchCommand(tick + 1, 0.0, rate))
        limits = int(state.limits_hit) if says is None else int(says)
        payout = state.encoder_payout + (0.1 if slips_at is not None and tick >= slips_at else 0.0)
        reading = WinchReading(
            tick * DT,
            payout,
            0.0,
            brake=False,
            command_sequence=state.command_sequence,
            limits_hit=limits,
        )
        watch.watch(reading, payout, np.nan, PARAMETERS)
        found.append(watch.share)
    return np.array(found), watch


def test_a_winch_that_does_what_is_foreseen_may_do_all(design):
    found, watch = shares(design, WinchParameters())
    assert set(found) == {1.0}
    assert abs(watch.drum.error()) < 2e-3


@pytest.mark.parametrize(
    "winch",
    [
        {"speed_gain": 0.7},
        {"speed_limit": 0.4},
        {"acceleration_limit": 0.3, "stop_deceleration": 0.3},
        {"time_constant": 0.6},
    ],
    ids=str,
)
def test_a_weaker_winch_is_noticed_within_three_seconds_and_may_do_less(design, winch):
    """A drum of 0.4 m/s that is sent 0.8 m/s is 4 cm off after 0.1 s of that."""
    found, _ = shares(design, WinchParameters(**winch))
    assert np.argmax(found == CAUTIOUS_SHARE) * DT < 3.0 + 2.0 * np.pi / 0.7 / 4.0


def test_the_share_comes_back_once_the_winch_is_believed_as_it_is(design):
    found, watch = shares(design, WinchParameters(speed_gain=0.7), believed={"winch.speed_gain": 0.7})
    assert set(found) == {1.0}
    assert abs(watch.drum.error()) < 3e-3


def test_it_comes_back_some_seconds_after_the_drum_was_last_off(design):
    """A cable that slips by 0.1 m on its drum at 8 s."""
    found, _ = shares(design, WinchParameters(), slips_at=160)
    cut = np.flatnonzero(found == CAUTIOUS_SHARE)
    assert cut[0] == pytest.approx(160, abs=2)
    # the two seconds of readings that are compared hold the slip
    assert (cut[-1] - 160) * DT <= 2.0 + CAUTIOUS_TIME + DT
    assert found[-1] == 1.0


def test_a_drum_at_the_end_of_its_payout_is_not_compared(design):
    found, watch = shares(design, WinchParameters(speed_gain=0.5), says=WinchLimit.PAYOUT)
    assert set(found) == {1.0}
    assert watch.drum.error() == 0.0
