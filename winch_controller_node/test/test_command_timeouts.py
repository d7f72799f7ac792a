"""A hiccup between controller and winch: compensation resumes automatically, unless it comes again and again."""

import pytest
from cable_sim_node.winch.component import VirtualWinch, WinchCommand
from cable_sim_node.winch.parameters import WinchParameters
from heave_node.interface.alarm import Alarm
from heave_node.interface.codes import WinchFault
from heave_node.interface.faults import FaultParameters
from winch_controller_node.core.supervision.late_commands import CUT_TIME, LateCommands
from winch_controller_node.core.supervision.modes import WAIT, Mode

from tests.supervised import Supervised

DT = 0.05


def test_a_transport_that_becomes_slower_is_noticed_within_three_ticks_and_told_once_when_it_stays_so():
    """0.2 s more from tick 100 on: the virtual winch says which command it has taken."""
    slower = FaultParameters(kind=("delay",), start=(100 * DT,), duration=(10.0,), magnitude=(0.2,))
    winch = VirtualWinch(WinchParameters(faults=slower), tick_period=DT)
    watch, noticed, alarms = LateCommands(DT), [], {}
    winch.step(0, WinchCommand(1))
    for tick in range(1, 160):
        state = winch.step(tick, WinchCommand(tick + 1, 0.0, 0.1))
        alarm = watch.update(tick + 1, state.command_sequence, 0.2)
        noticed += [tick] if watch.has_begun else []
        if alarm:
            alarms[tick] = alarm
    # a command of tick 100 was due at the end of tick 103: nothing can be seen before
    assert noticed == [pytest.approx(105, abs=1)]
    # half of two seconds later most commands of these two seconds were late
    assert list(alarms) == [pytest.approx(104 + 20, abs=1)]


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
    assert alarm.name == "COMMANDS_LATE: often"
    # reported with the first share above 10 % of 1,200 commands
    assert alarm.values == {"percent": pytest.approx(10.0, abs=0.1), "window": 60.0, "largest": pytest.approx(DT)}
    assert late.is_reported


class Link(Supervised):
    """A winch that compensates, or stands for want of commands."""

    def __init__(self, *, resumes=True, wants=True):
        super().__init__(wants=wants)
        self.supervisor.modes.design["resumes"] = resumes
        self.step()

    def feed(self, seconds, fault=WinchFault.COMMAND_TIMEOUT, *, mode=Mode.STOPPED, **given):
        """Let the winch report a `fault` for some time; return what is reported of it."""
        found = []
        for _ in range(round(seconds / DT)):
            if self.supervisor.modes.mode is not mode:
                self.enter(mode, wants=False)
            found += [one.code for one in self.step(winch={"fault": int(fault)}, **given).alarms if one.code in TOLD]
        return found

    def time_out(self):
        """Let a compensating winch time out."""
        self.enter(Mode.COMPENSATING)
        codes = [one.code for one in self.step(winch={"fault": int(WinchFault.COMMAND_TIMEOUT)}).alarms]
        assert self.supervisor.modes.mode is Mode.STOPPED
        return [code for code in codes if code in TOLD]

    @property
    def is_pending(self):
        return bool(self.supervisor._state["is_pending"][0])


TOLD = RESUMED, GIVEN_UP = "COMMANDS_RESTORED", "COMMAND_TIMEOUTS"


def test_timeouts_that_come_again_and_again_wait_for_an_operator():
    """A quarter of the motion each: after three there is an attempt, after four none."""
    link = Link()
    for _ in range(3):
        assert link.time_out() == []
        assert link.feed(2.0 * WAIT) == [RESUMED]
        link.feed(1.0, WinchFault.NONE)
    assert link.time_out() == [GIVEN_UP]


def test_nothing_goes_on_while_a_sensor_is_lost_or_after_an_operator_has_spoken():
    link = Link()
    link.time_out()
    assert link.feed(3.0 * WAIT, lost=("mru",)) == []
    link.supervisor.cancel_timeout()
    assert link.feed(3.0 * WAIT) == []


def test_a_winch_that_keeps_its_fault_when_it_is_released_is_tried_again_but_not_for_ever():
    """It is released, and two seconds later the mode is stopped again, for the same fault."""
    link = Link()
    link.time_out()
    told = []
    for _ in range(6):
        told += link.feed(WAIT + DT)
        told += link.feed(2.0, mode=Mode.MANUAL)
    assert told == [RESUMED] * 3 + [GIVEN_UP]


def test_a_winch_that_did_not_compensate_or_must_not_resume_stays_where_it_is():
    link = Link(resumes=False)
    link.time_out()
    assert link.feed(3.0 * WAIT) == []
    link = Link(wants=False)
    assert link.feed(3.0 * WAIT) == []


def test_a_winch_waits_for_as_long_as_it_takes_before_it_is_tried_again_from_the_last_trouble_on():
    link = Link()
    link.time_out()
    assert link.feed(WAIT - 2.0 * DT) == []
    assert link.feed(DT, lost=("mru",)) == []
    assert link.feed(WAIT - 2.0 * DT) == []
    assert link.feed(4.0 * DT) == [RESUMED]


def test_a_fault_that_somebody_has_released_is_not_pending():
    link = Link()
    link.time_out()
    assert link.is_pending
    assert link.feed(1.0, WinchFault.NONE) == []
    assert not link.is_pending
    assert link.feed(3.0 * WAIT, WinchFault.DRIVE) == []
