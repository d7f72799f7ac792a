"""Commands that the winch takes later than modelled."""

import pytest
from cable_sim_node.winch.component import VirtualWinch, WinchCommand
from cable_sim_node.winch.parameters import WinchParameters
from heave_node.interface.faults import FaultParameters

from tests.core_parts import LateCommands

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
