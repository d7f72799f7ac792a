"""A controller that is behind in real time: it jumps to the newest tick, predicted over those that it leaves out."""

import numpy as np
import pytest
from heave_bringup.closed_loop import ClosedLoop, LoopRecord

from tests.campaigns.fault_matrix.faults import Fault
from tests.campaigns.fault_matrix.wires import Wires
from tests.loops import quick_parameters

TICK, STALLED = 0.05, 35.0
"""Tick period, and time at which the controller stands still [s]; its readings come to it afterwards, together."""


def run(ticks: int, duration: float) -> LoopRecord:
    loop = ClosedLoop(quick_parameters({"winch_controller.law": "lqg"}, duration), has_adviser=False)
    wires = Wires(loop, TICK)

    def stall(tick: int, _: object) -> None:
        if ticks and loop.tick == round(STALLED / TICK):
            wires.begin(Fault("node stalled", 0.0, ticks * TICK))

    return loop.run(stall)


@pytest.mark.parametrize("ticks", [8, pytest.param(9, marks=pytest.mark.long)])
def test_compensation_goes_on_after_a_stall_that_the_winch_bears(ticks):
    """Of up to 0.45 s: its own watchdog stops a winch after 0.5 s. The drum keeps its rate meanwhile, and where the
    unit is stays known: it is held again as without a stall as soon as the winch has caught up, in 2 s."""
    smooth, stalled = run(0, 48.0), run(ticks, 48.0)
    (left_out,) = [alarm for _, alarm in stalled.alarms if alarm.name != "MODE_CHANGED"]
    assert (left_out.code, left_out.values["count"]) == ("TICKS_LEFT_OUT", ticks)
    assert left_out.values["time"] == pytest.approx(ticks * TICK)
    again = STALLED + ticks * TICK
    assert set(np.array(stalled.modes)[stalled.column("time") > 20.0]) == {"compensating"}
    assert stalled.unit_sigma(again + 2.0) < 1.2 * smooth.unit_sigma(again + 2.0)


@pytest.mark.long
def test_after_a_longer_stall_the_winch_has_stopped_and_compensation_comes_back_by_itself():
    """`modes.resume_time` of 15 s after the winch is seen braked, 3 s for its fault, 5 s for the depth to settle."""
    record = run(40, 75.0)
    assert "TICKS_LEFT_OUT" in [alarm.name for _, alarm in record.alarms]
    modes = np.array(record.modes)
    assert "stopped" in set(modes[record.column("time") > STALLED])
    assert set(modes[record.column("time") > STALLED + 2.0 + 25.0]) == {"compensating"}
