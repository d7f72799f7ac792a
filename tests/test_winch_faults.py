"""What real winches do wrong, in the whole loop in lockstep on the two-state plant: known outcomes in stated times.

The winch has a supervision of its drive of 1 s. The sea has waves of 10 s: the drum is ordered to move by more than
0.05 m/s for all but 0.5 s about each turn.
"""

from dataclasses import replace

import numpy as np
import pytest
from cable_sim_node.winch.component import VirtualWinch
from cable_sim_node.winch.parameters import WinchParameters
from heave_bringup.closed_loop import ClosedLoop
from heave_node.interface.codes import WinchFault

from tests.loops import TICK, Stepped, quick_parameters, two_state_parameters

SUPERVISED, BEGIN = 1.0, 40.0


class Run(Stepped):
    """A loop that compensates from 15 s on; a fault of the winch begins at BEGIN."""

    def __init__(self, seed=1, supervised=SUPERVISED, **own):
        winch = WinchParameters(supervision_time=supervised)
        parameters = two_state_parameters(sea={"ramp": 10.0}, seed=seed, winch=winch, **own)
        super().__init__(ClosedLoop(parameters))
        self.go(BEGIN)
        assert self.modes[-1] == "compensating"

    def inject(self, kind, magnitude=0.0, duration=0.0):
        self.loop.winch.faults.inject(kind, start=self.time, magnitude=magnitude, duration=duration)

    def reached(self, mode, after=BEGIN):
        """Return when a mode is first taken after a time [s]."""
        start = round(after / TICK) - 1
        return after + TICK * self.modes[start:].index(mode)

    def ratio(self, after):
        """Return the unit's standard deviation over that of the uncompensated one."""
        unit = self.column("unit", after) + self.column("depth_set_point", after)
        return unit.std() / self.column("uncompensated", after).std()


@pytest.mark.parametrize(
    ("kind", "words", "within"),
    [
        # two orders of more than 0.05 m/s: a turn of the wave may lie between fault and trip
        ("reverse", "the drum turns against the command", 2.0 * SUPERVISED + 1.0),
        ("brake_shut", "the brake does not open", SUPERVISED + 3.0 * TICK),
    ],
)
def test_a_drum_that_does_not_follow_is_stopped_by_its_drive_and_the_controller_stops_with_it(kind, words, within):
    """Without the envelope, which would brake a drum that turns the wrong way before its drive does."""
    run = Run(**{"envelope.active": False})
    run.inject(kind)
    run.go(BEGIN + 7.0)
    assert run.reached("stopped") <= BEGIN + within
    assert run.loop.winch.state.fault is WinchFault.DRIVE
    assert run.loop.winch.supervised.startswith(words)
    assert any("winch fault: drive" in str(told) for _, told in run.alarms)
    still = run.column("payout_rate", BEGIN + within + 2.0)
    assert np.abs(still).max() == 0.0, "the brake holds"


@pytest.mark.parametrize(("lasts", "named"), [(0.0, True), (2.0, False)])
def test_a_brake_that_stays_shut_is_named_without_the_drives_supervision_and_one_that_is_slow_to_open_is_not(
    lasts, named
):
    """It was explained by a weak winch, and ended by the swing of the load after ten seconds."""
    run = Run(supervised=0.0)
    run.inject("brake_shut", duration=lasts)
    # a brake may take 3 s to open, and about a turn of the wave 0.5 s prove nothing
    run.go(BEGIN + 4.5)
    assert any(told.name == "DRUM_OR_ENCODER: still" for _, told in run.alarms) is named
    run.go(BEGIN + 9.0)
    assert [told.code == "DRIVE_AT_FAULT" for _, told in run.alarms].count(True) == int(named), "once"


def test_a_drum_that_turns_again_is_no_jump_of_its_encoder():
    """A count that stood while the drum was ordered to turn is off by that way, whichever of the two it was."""
    run = Run(supervised=0.0)
    run.inject("brake_shut", duration=4.5)
    run.go(BEGIN + 9.0)
    names = [told.name for _, told in run.alarms]
    assert "DRUM_OR_ENCODER: still" in names
    assert "SENSOR_LOST, ENCODER: jump" not in names


def test_a_winch_that_begins_anew_within_a_second_is_moved_only_when_an_operator_asks():
    """Its drive started again with the brake on and a count of 0: it was released within 0.2 s, and ran at 0.4 m/s."""
    run = Run()
    deliver = run.loop._deliver
    run.loop._deliver = lambda *given: replace(deliver(*given), winch=None)
    run.go(BEGIN + 0.8)
    assert run.modes[-1] == "compensating"
    run.loop._deliver = deliver
    run.loop.winch = VirtualWinch(run.loop._parameters.winch, tick_period=TICK, seed=1)
    run.go(BEGIN + 30.0)
    assert run.reached("stopped") <= BEGIN + 0.8 + 2.0 * TICK
    assert set(run.modes[round((BEGIN + 1.0) / TICK) :]) == {"stopped"}
    assert any("winch fault: drive: it was restarted; request a mode" in str(told) for _, told in run.alarms)
    assert np.abs(run.column("payout", BEGIN + 1.0)).max() == 0.0


def test_a_count_that_freezes_while_the_winch_is_driven_slowly_by_hand_is_named_and_the_winch_stops():
    """It went on for 75 s and 5.7 m, and the depth sensor was blamed."""
    run = Stepped(ClosedLoop(quick_parameters({}, 60.0))).go(5.0)
    run.loop.controller.set_mode("manual")
    run.loop.winch.encoder.faults.inject("freeze", start=12.0)
    while run.time < 20.0:
        if run.loop.controller.mode.value == "manual":
            run.loop.controller.operate(0.076)
        run.go(run.time + TICK)
    codes = [alarm.name for time, alarm in run.alarms if 12.0 < time < 13.5]
    assert "DRUM_OR_ENCODER: still" in codes
    assert run.modes[-1] == "stopped"


@pytest.mark.parametrize("kind", ["brake_slip", "brake_open"])
def test_a_brake_that_does_not_hold_is_reported_within_two_seconds_of_the_standstill(kind):
    """Without the envelope, which has the drive hold the drum before the drive finds it."""
    run = Run(**{"envelope.active": False})
    run.inject(kind, 0.05)
    run.loop.controller.set_mode("standby")
    # a fade-out may settle for 30 s
    run.go(BEGIN + 45.0)
    at_rest = run.reached("standby")
    assert run.reached("stopped", at_rest) <= at_rest + 2.0
    assert "the brake does not" in run.loop.winch.supervised


@pytest.mark.parametrize(("mode", "holds"), [("stopped", True), ("emergency_stop", False)])
def test_a_drum_that_its_brake_does_not_hold_is_held_by_a_drive_without_supervision_not_after_an_emergency_stop(
    mode, holds
):
    """It went on at 0.1 m/s until somebody asked for a mode."""
    run = Run(supervised=0.0)
    run.inject("brake_slip", 0.1)
    run.loop.controller.set_mode(mode)
    run.go(BEGIN + 60.0)
    names = [told.name for at, told in run.alarms if at > BEGIN]
    assert "DRUM_NOT_HELD: count" in names
    assert ("DRUM_HELD_BY_DRIVE" in names) is holds
    assert ("DRUM_NOT_HELD: turns" in names) is not holds
    assert np.abs(run.column("payout_rate", BEGIN + 50.0)).max() == pytest.approx(0.0 if holds else 0.1)


@pytest.mark.long
def test_a_drum_that_creeps_under_load_is_compensated():
    run = Run()
    run.inject("creep", 0.05)
    run.go(BEGIN + 60.0)
    assert set(run.modes[round(BEGIN / TICK) :]) == {"compensating"}
    assert run.ratio(BEGIN + 20.0) < 0.3
    # 0.05 m/s for 60 s are 3 m if nothing is done
    assert np.abs(run.column("payout", BEGIN + 50.0).mean() - run.column("payout", BEGIN - 10.0)[:200].mean()) < 0.5


@pytest.mark.long
@pytest.mark.parametrize(("size", "lasting"), [(0.05, 20.0), (0.15, 60.0)])
def test_pressure_that_falls_and_comes_back_costs_compensation_for_a_while_and_no_more(size, lasting):
    """In 60 s a limit is identified, below which the controller then keeps: it must be found that it is gone."""
    run = Run()
    run.inject("low_pressure", size, duration=lasting)
    run.go(BEGIN + lasting + 160.0)
    assert run.modes[-1] == "compensating"
    assert run.ratio(BEGIN + lasting + 120.0) < 0.3
