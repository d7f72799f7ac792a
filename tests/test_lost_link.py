"""A link to the winch that is down for ten seconds: compensation comes back by itself, at whatever moment it went."""

from dataclasses import replace

import numpy as np
import pytest
from heave_bringup.closed_loop import ClosedLoop, LoopRecord

from tests.campaigns.fault_matrix.faults import Fault
from tests.campaigns.fault_matrix.wires import Wires
from tests.loops import quick_parameters

DOWN = 10.0


class CutLoop(ClosedLoop):
    """The loop with the winch on another host: from `start` on, for DOWN, nothing passes between it and the others.

    The winch stops by its watchdog, the controller gets no encoder, and the plant coasts with the drum's last motion.
    """

    start = 0.0

    @property
    def is_down(self) -> bool:
        return self.start <= self.tick * self._dt < self.start + DOWN

    def step(self):
        step, advance = self.winch.step, self.plant.advance
        if self.is_down:
            self.winch.step = lambda tick, _, tension: step(tick, None, tension)
            self.plant.advance = lambda tick, tip, _, programme: advance(tick, tip, None, programme)
        try:
            return super().step()
        finally:
            self.winch.step, self.plant.advance = step, advance

    def _deliver(self, readings, vessel):
        delivered = super()._deliver(readings, vessel)
        return replace(delivered, winch=None) if self.is_down else delivered


def cut_run(start: float, after: float) -> LoopRecord:
    loop = CutLoop(quick_parameters({}, start + DOWN + after), has_adviser=False)
    loop.start = start
    return loop.run()


BEGAN = [27.0, *(pytest.param(float(start), marks=pytest.mark.long) for start in range(46, 53))]
"""Phases of the sea at which the link goes; the swell's period is 8 s."""


@pytest.mark.parametrize("start", BEGAN)
def test_compensation_returns_by_itself_after_the_link_was_down(start):
    """`modes.resume_time` of 15 s after the encoder is back, 3 s for the command timeout, and what the depth takes to
    settle, 5 s at most: the drum was unknown, so the depth sensor is not held against the estimate."""
    record = cut_run(start, 26.0)
    modes = np.array(record.modes)
    time = record.column("time")
    assert modes[np.searchsorted(time, start - 1.0)] == "compensating"
    down = (time > start + 5.0) & (time < start + DOWN + 15.0)
    assert set(modes[down]) == {"stopped"}
    assert set(modes[time > start + DOWN + 23.5]) == {"compensating"}
    assert "DEPTH_MRU_DISAGREE" not in [alarm.name for _, alarm in record.alarms]


# ticks that are left out


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
    assert "up to its watchdog timeout" in left_out.text, "which stops a winch after a longer one"
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
