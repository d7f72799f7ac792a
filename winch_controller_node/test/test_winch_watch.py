"""Whether the winch does what is predicted of it, and takes commands in time."""

import re
from dataclasses import replace

import numpy as np
import pytest
from cable_sim_node.winch.component import VirtualWinch, WinchCommand
from cable_sim_node.winch.parameters import WinchParameters
from heave_node.interface.codes import WinchFault, WinchLimit
from winch_controller_node.design.design import design_controller
from winch_controller_node.interface.readings import Measurements, WinchOrder, WinchReading
from winch_controller_node.node_parameters import WinchControllerParameters

from tests.core_parts import WinchWatch, drum_error, drum_ordered

DT = 0.05
PARAMETERS = WinchControllerParameters()


@pytest.fixture(scope="module")
def design():
    return design_controller(PARAMETERS, tick_period=DT)


def errors(design, winch, seconds=20.0, *, assumed=None, says=None, slips_at=None):
    """Return the drum's error [m] in each tick of a sea of 0.8 m/s and 9 s, and the watch; the cable slips by 0.1 m."""
    watch, drum = WinchWatch(design), VirtualWinch(winch, tick_period=DT)
    watch.take(assumed or {})
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
        found.append(abs(watch.drum_error))
    return np.array(found), watch


def test_a_winch_that_is_believed_as_it_is_has_no_error(design):
    found, _ = errors(design, WinchParameters(speed_gain=0.7), assumed={"winch.speed_gain": 0.7})
    assert np.max(found) < 3e-3


def test_a_slip_is_an_error_until_the_predicted_second_begins_after_it(design):
    """A cable that slips by 0.1 m on its drum at 8 s: a second is predicted, and begins after the slip from 9 s on."""
    found, _ = errors(design, WinchParameters(), slips_at=160)
    off = np.flatnonzero(found > 0.04)
    assert off[0] == pytest.approx(160, abs=2)
    assert off[-1] == pytest.approx(180, abs=6)


def test_a_drum_at_the_end_of_its_payout_is_not_compared(design):
    found, watch = errors(design, WinchParameters(speed_gain=0.5), says=WinchLimit.PAYOUT)
    assert set(found) == {0.0}
    assert drum_error(watch.drum) == 0.0


class Link:
    """A winch that takes each command after `late` ticks, and does what it is sent."""

    def __init__(self, design, late=4, parameters=PARAMETERS):
        self.watch, self.late, self.tick = WinchWatch(design), late, 0
        self.parameters = parameters
        self.last_taken = 1_000_000

    def run(self, ticks, *, fault=0, has_state=True, brake=False, rate=0.0, limits=0):
        """Return the reports of so many ticks."""
        reports = []
        for _ in range(ticks):
            self.tick += 1
            reading = WinchReading(
                self.tick * DT,
                0.0,
                0.0,
                brake=brake,
                command_sequence=min(max(self.tick - self.late, 0), self.last_taken),
                limits_hit=limits,
                fault=fault,
            )
            reports.append(self.watch.watch(reading if has_state else None, 0.0, np.nan, self.parameters))
            self.watch.give(WinchOrder(self.tick + 1, 0.0, rate, brake=brake))
        return reports


def test_commands_that_are_taken_in_time_are_no_news_and_ones_that_are_not_inhibit(design):
    """A delay of 0.2 s is nominal: 4 ticks and the one on its way."""
    assert not any(report.alarm or report.inhibition for report in Link(design).run(200))
    link = Link(design)
    link.run(100)
    link.last_taken = link.tick - link.late
    found = [report.inhibition.name for report in link.run(40) if report.inhibition]
    assert set(found) == {"COMMANDS_CUT"}
    slow = Link(design)
    slow.run(100)
    slow.late = 4 + round((PARAMETERS.lag.largest + 0.5) / DT)
    reports = slow.run(400)
    assert reports[-1].inhibition.name == "COMMANDS_TOO_LATE"
    assert reports[-1].inhibition.values["delay"] == pytest.approx(PARAMETERS.lag.largest + 0.5, abs=2.0 * DT)


@pytest.mark.parametrize(("more", "is_tolerated"), [(3, True), (4, False)])
def test_where_the_winch_is_not_identified_half_its_lag_and_delay_more_is_tolerated(design, more, is_tolerated):
    """A delay of 0.2 s and a lag of 0.15 s: 0.175 s more."""
    assert (PARAMETERS.winch.command_delay, PARAMETERS.winch.time_constant) == (0.2, 0.15)
    fixed = replace(PARAMETERS, lag=replace(PARAMETERS.lag, adaptation=False))
    link = Link(design, parameters=fixed)
    link.run(100)
    link.late += more
    report = link.run(100)[-1]
    assert (report.inhibition is None) is is_tolerated
    assert is_tolerated or report.inhibition.values == {"delay": pytest.approx(0.2), "limit": pytest.approx(0.175)}


@pytest.mark.parametrize(("limits", "is_limited"), [(0, False), (WinchLimit.SPEED, True)])
def test_a_limit_that_the_winch_reports_is_on_record(design, limits, is_limited):
    assert drum_ordered(errors(design, WinchParameters(), says=limits)[1].drum).is_limited is is_limited


def test_a_winch_that_gets_no_order_keeps_the_last_one_which_is_counted_and_put_on_record(design):
    """Four ticks of 0.8 m/s: had they not been on record, the drum would be 0.16 m ahead of its prediction."""
    watch, drum = WinchWatch(design), VirtualWinch(WinchParameters(), tick_period=DT)
    watch.keep(watch.given)
    assert (watch.given, watch.kept) == (None, 1)
    drum.step(0, WinchCommand(1))
    for tick in range(1, 300):
        is_kept = 200 <= tick < 204
        command = WinchCommand(200 if is_kept else tick + 1, 0.0, 0.8)
        if is_kept:
            watch.keep(watch.given)
        else:
            watch.give(WinchOrder(command.sequence, 0.0, 0.8, brake=False))
        state = drum.step(tick, command)
        assert watch.kept == (tick - 199 if is_kept else 0)
        if not is_kept:
            reading = WinchReading(tick * DT, state.encoder_payout, 0.0, brake=False, command_sequence=tick)
            watch.watch(reading, state.encoder_payout, np.nan, PARAMETERS)
        assert abs(drum_error(watch.drum)) < 4e-3, tick


def test_a_fault_stays_known_while_no_state_comes_and_its_cause_is_told(design):
    link = Link(design)
    link.run(100)
    link.late += 12
    link.run(12, fault=WinchFault.COMMAND_TIMEOUT)
    said = link.watch.fault_cause(link.watch.fault, Measurements())
    assert said.startswith("commands were sent in time, and the winch took none for")
    assert float(re.findall(r"\d+\.\d+", said)[0]) == pytest.approx(12 * DT), "beyond its delay"
    link.run(3, has_state=False)
    assert link.watch.fault == WinchFault.COMMAND_TIMEOUT
    silent = Link(design)
    silent.run(100)
    silent.run(20, has_state=False)
    silent.run(1, fault=WinchFault.COMMAND_TIMEOUT)
    assert "no data from the winch for 1.00 s" in silent.watch.fault_cause(silent.watch.fault, Measurements())
    silent.run(1, fault=WinchFault.DRIVE)
    said = silent.watch.fault_cause(silent.watch.fault, Measurements())
    assert said == "", "of another fault the winch alone knows the cause"


@pytest.mark.parametrize(
    ("fault", "reported", "words"),
    [
        (WinchFault.DRIVE, WinchFault.NONE, "it was restarted"),
        (WinchFault.DRIVE, WinchFault.DRIVE, ""),
        (WinchFault.NONE, WinchFault.NONE, ""),
    ],
)
def test_only_a_fault_that_the_winch_does_not_report_is_one_of_a_restart(design, fault, reported, words):
    seen = Measurements(winch=WinchReading(1.0, 0.0, 0.0, True, int(reported), 0, 0))
    assert Link(design).watch.fault_cause(fault, seen) == words


def test_a_braked_drum_is_not_compared_and_begins_where_it_stands(design):
    link = Link(design)
    link.run(200, rate=0.5)  # ordered to move, and the encoder stands
    assert abs(link.watch.drum_error) > 0.04
    link.run(200, brake=True)
    assert link.watch.drum_error == drum_error(link.watch.drum) == 0.0
    assert link.watch.given.brake


def test_before_the_first_order_nothing_is_compared(design):
    watch = WinchWatch(design)
    report = watch.watch(None, None, np.nan, PARAMETERS)
    assert (report.alarm, report.inhibition, watch.given, watch.drum_error) == (None, None, None, 0.0)


def test_what_was_ordered_at_the_end_of_the_payout_still_counts_for_what_the_drum_does_from_there(design):
    """1 m/s up to the end, 4 s of 0 m/s there, then -0.5 m/s: for its delay the drum does what was ordered at the end.

    The readings restart where the winch leaves the end; the drum is as predicted from then on.
    """
    watch, drum = WinchWatch(design), VirtualWinch(WinchParameters(), tick_period=DT)
    drum.step(0, WinchCommand(1))
    for tick in range(1, 240):
        rate = 1.0 if tick < 80 else 0.0 if tick < 160 else -0.5
        watch.give(WinchOrder(tick + 1, 0.0, rate, brake=False))
        state = drum.step(tick, WinchCommand(tick + 1, 0.0, rate))
        limits = int(WinchLimit.PAYOUT) if 80 <= tick < 160 else 0
        reading = WinchReading(
            tick * DT, state.encoder_payout, 0.0, brake=False, command_sequence=tick, limits_hit=limits
        )
        watch.watch(reading, state.encoder_payout, np.nan, PARAMETERS)
        assert abs(drum_error(watch.drum)) < 4e-3, tick
