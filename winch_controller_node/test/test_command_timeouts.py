"""A hiccup between controller and winch: compensation resumes automatically, unless it comes again and again."""

import pytest
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.scenarios import load_scenario
from heave_node.interface.alarm import Alarm
from heave_node.interface.codes import WinchFault
from winch_controller_node.core.supervision.command_timeouts import WAIT, Advice, CommandTimeouts
from winch_controller_node.core.supervision.late_commands import CUT_TIME, LATE_WINDOW, LateCommands

DT = 0.05


def test_a_transport_that_stays_slow_is_told_by_its_median():
    """One command in a tick: sequence k is given in tick k, and taken with so many ticks of delay."""
    late = LateCommands(DT)
    window = round(LATE_WINDOW / DT)
    for tick in range(100, 100 + window // 2):
        late.update(tick, tick - 11, 0.2)
    assert late.overdue == 0.0, "a second of late commands is no slow transport"
    for tick in range(200, 200 + window // 2 + 1):
        late.update(tick, tick - 11, 0.2)
    # of a command that is due after 0.2 s, 4 ticks, at most tick - 4 is taken; 7 ticks more are 0.35 s
    assert abs(late.overdue - 0.35) < 1e-9 + DT


def test_a_link_that_is_cut_for_seconds_is_not_a_slow_one():
    """Nothing is taken for 3 s, and from then on each command in time: how late one was is known of none."""
    late, told, cut = LateCommands(DT), [], []
    for tick in range(100, 1300):
        is_gap = 500 <= tick < 560
        told.append(late.update(tick, 499 - 4 if is_gap else tick - 4, 0.2))
        cut += [tick] if late.is_cut else []
        assert late.overdue == 0.0
    assert set(told) == {None}
    assert cut == list(range(499 + round(CUT_TIME / DT), 560))


def test_of_a_link_that_is_cut_for_seconds_it_is_told_once_that_the_winch_takes_no_command():
    """It is in order again after 8 s, and compensation goes on from then on, not while the link is cut.

    Besides, the controller reports the swing in which the stop has left the load.
    """
    fault = {"kind": "gap", "start": 30.0, "duration": 8.0, "magnitude": 0.0}
    settings = [f"virtual_winch.faults.{name}=[{value}]" for name, value in fault.items()]
    scenario = load_scenario("b4_limit_900_tp8", settings=["all.seed=57", "all.duration=45", *settings])
    told = [(time, alarm) for time, alarm in ClosedLoop(loop_parameters(scenario)).run().alarms if time > 30.0]
    beside = ("COMMANDS_CUT", "LOAD_SWINGS")
    (_, stopped), (resumed, resumes) = [one for one in told if one[1].code not in beside][:2]
    assert (stopped.code, stopped.values["mode"]) == ("COMPENSATION_LOST", "stopped")
    assert "winch took none for 0.50 s" in stopped.values["reason"]
    assert resumes.code == Advice.RESUME.alarm.code
    assert resumed > 30.0 + 8.0 + WAIT
    assert not {alarm.code for _, alarm in told} & {"COMMANDS_LATE", "COMMANDS_OFTEN_LATE"}
    modes = [alarm.values["mode"] for _, alarm in told if "mode" in alarm.values]
    assert modes[-1] == "compensating"


def late_in_bursts(burst: int, every: int, ticks: int) -> tuple[LateCommands, list[Alarm]]:
    """Return what becomes of `burst` commands in a row that are late in each `every` ticks."""
    late = LateCommands(DT)
    told = [late.update(tick, tick - (5 if tick % every < burst else 4), 0.2) for tick in range(100, 100 + ticks)]
    return late, [alarm for alarm in told if alarm]


def test_hiccups_are_counted_and_not_told():
    """2 commands late in each 100: two in a row, as of one tick that a machine was late."""
    late, told = late_in_bursts(2, 100, 12_000)
    assert told == []
    assert (late.late, late.known) == (240, 12_000)
    assert abs(late.largest - DT) < 1e-9


def test_a_machine_that_is_late_too_often_is_told_once_with_its_share():
    """3 commands late in each 20: never most of two seconds, but 15 % of a minute."""
    late, told = late_in_bursts(3, 20, 12_000)
    (alarm,) = told
    assert alarm.code == "COMMANDS_OFTEN_LATE"
    # reported with the first share above 10 % of 1,200 commands
    assert alarm.values == {"percent": pytest.approx(10.0, abs=0.1), "window": 60.0, "largest": pytest.approx(DT)}
    assert late.is_reported


def feed(timeouts: CommandTimeouts, seconds: float, fault: WinchFault, **situation: bool) -> list[Advice]:
    given = {"wants_compensation": False, "is_stopped": True, "is_well": True} | situation
    found = [timeouts.update(int(fault), **given) for _ in range(round(seconds / DT))]
    return [advice for advice in found if advice]


def watching(most: int = 3, *, dt: float = DT, resumes: bool = True) -> CommandTimeouts:
    """Return a watch whose `most` failures are followed by an attempt: from the next on an operator has to ask."""
    failures: list[int] = []

    def count() -> bool:
        failures.append(1)
        return len(failures) > most

    return CommandTimeouts(dt, resumes=resumes, count=count)


def time_out(timeouts: CommandTimeouts) -> list[Advice]:
    """Let a compensating winch time out, wait, and release it."""
    told = [timeouts.update(int(WinchFault.COMMAND_TIMEOUT), wants_compensation=True, is_stopped=False, is_well=True)]
    told += feed(timeouts, 2.0 * WAIT, WinchFault.COMMAND_TIMEOUT)
    feed(timeouts, 1.0, WinchFault.NONE)
    return [advice for advice in told if advice]


def test_timeouts_that_come_again_and_again_wait_for_an_operator():
    timeouts = watching(4)
    for _ in range(4):
        assert time_out(timeouts) == [Advice.RESUME]
    assert time_out(timeouts) == [Advice.GIVE_UP]


def test_nothing_goes_on_while_a_sensor_is_lost_or_after_an_operator_has_spoken():
    timeouts = watching()
    timeouts.update(int(WinchFault.COMMAND_TIMEOUT), wants_compensation=True, is_stopped=False, is_well=True)
    assert feed(timeouts, 3.0 * WAIT, WinchFault.COMMAND_TIMEOUT, is_well=False) == []
    timeouts.cancel()
    assert feed(timeouts, 3.0 * WAIT, WinchFault.COMMAND_TIMEOUT) == []


def test_a_winch_that_keeps_its_fault_when_it_is_released_is_tried_again_but_not_for_ever():
    """It is released, and two seconds later the mode is stopped again, for the same fault."""
    timeouts = watching()
    timeouts.update(int(WinchFault.COMMAND_TIMEOUT), wants_compensation=True, is_stopped=False, is_well=True)
    told = []
    for _ in range(6):
        told += feed(timeouts, WAIT + DT, WinchFault.COMMAND_TIMEOUT)
        told += feed(timeouts, 2.0, WinchFault.COMMAND_TIMEOUT, is_stopped=False)
    assert told == [Advice.RESUME] * 3 + [Advice.GIVE_UP]


def test_a_winch_that_did_not_compensate_or_must_not_resume_stays_where_it_is():
    for resumes, compensated in ((True, False), (False, True)):
        timeouts = watching(resumes=resumes)
        timeouts.update(int(WinchFault.COMMAND_TIMEOUT), wants_compensation=compensated, is_stopped=False, is_well=True)
        assert feed(timeouts, 3.0 * WAIT, WinchFault.COMMAND_TIMEOUT) == []


def test_what_is_done_about_a_timeout_is_reported_by_its_code():
    assert Advice.RESUME.alarm.code == "COMMANDS_RESTORED"
    assert Advice.GIVE_UP.alarm.code == "COMMAND_TIMEOUTS"


def test_a_winch_waits_for_as_long_as_it_takes_before_it_is_tried_again_from_the_last_trouble_on():
    timeouts = watching()
    timeouts.update(int(WinchFault.COMMAND_TIMEOUT), wants_compensation=True, is_stopped=False, is_well=True)
    assert feed(timeouts, WAIT - 2.0 * DT, WinchFault.COMMAND_TIMEOUT) == []
    assert feed(timeouts, DT, WinchFault.COMMAND_TIMEOUT, is_well=False) == []
    assert feed(timeouts, WAIT - 2.0 * DT, WinchFault.COMMAND_TIMEOUT) == []
    assert feed(timeouts, 4.0 * DT, WinchFault.COMMAND_TIMEOUT) == [Advice.RESUME]


def test_a_fault_that_somebody_has_released_is_not_pending():
    timeouts = watching()
    timeouts.update(int(WinchFault.COMMAND_TIMEOUT), wants_compensation=True, is_stopped=False, is_well=True)
    assert feed(timeouts, 1.0, WinchFault.NONE) == []
    assert feed(timeouts, 3.0 * WAIT, WinchFault.DRIVE) == []


def test_a_timeout_is_pending_until_it_is_cancelled_and_is_tried_again_after_three_seconds():
    """Ticks of a quarter of a second: twelve of them."""
    timeouts = watching(dt=0.25)
    assert not timeouts.is_pending
    timeouts.update(int(WinchFault.COMMAND_TIMEOUT), wants_compensation=True, is_stopped=False, is_well=True)
    assert timeouts.is_pending
    given = {"wants_compensation": False, "is_stopped": True, "is_well": True}
    told = [timeouts.update(int(WinchFault.COMMAND_TIMEOUT), **given) for _ in range(12)]
    assert told == [None] * 11 + [Advice.RESUME]
    timeouts.cancel()
    assert not timeouts.is_pending
