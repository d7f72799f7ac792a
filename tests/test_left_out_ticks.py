"""A controller that is behind in real time: it jumps to the newest tick, predicted over those that it leaves out."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from heave_bringup.closed_loop import ClosedLoop, LoopRecord, loop_parameters
from heave_bringup.scenarios import load_scenario
from winch_controller_node.interface.readings import Measurements, Outputs

STALLED = 35.0
"""Time at which the controller stands still [s]."""


class StalledLoop(ClosedLoop):
    """The loop whose controller stands still for `ticks`; the readings of that time come to it afterwards, together."""

    ticks = 0
    last: Outputs
    _held: tuple[Measurements, ...] = ()

    @property
    def is_stalled(self) -> bool:
        return 0 <= self.tick - round(STALLED / self._dt) < self.ticks

    def step(self):
        if not self.is_stalled:
            return super().step()
        stepped, winch = self.controller.step, self.winch.step
        last = self.last
        self.controller.step = lambda tick, _: self.controller.leave_out(tick) or last
        self.winch.step = lambda tick, _, tension: winch(tick, None, tension)
        try:
            return super().step()
        finally:
            self.controller.step, self.winch.step = stepped, winch

    def _deliver(self, readings, vessel):
        new = super()._deliver(readings, vessel)
        held, self._held = self._held, ()
        for one in reversed(held):
            scalar = {name: (*one.of(name), *new.of(name)) for name in {*one.scalar, *new.scalar}}
            new = replace(new, mru=(*one.mru, *new.mru), scalar=scalar)
        if self.is_stalled:
            self._held = (*held, super()._deliver(readings, vessel))
        return new


def run(ticks: int, duration: float) -> LoopRecord:
    settings = ["winch_controller.modes.settling_time=5", "wave_vessel.ramp=5", "all.transient=20"]
    settings += ["cable_sim.segments=6", "winch_controller.law=lqg", f"all.duration={duration}"]
    loop = StalledLoop(loop_parameters(load_scenario("b2_calm_300", settings=settings)))
    loop.ticks = ticks
    # no adviser: the test is quick
    loop.adviser = SimpleNamespace(advise=lambda observations: None)
    loop.controller.take = lambda beliefs: True

    def keep(_: int, outputs: Outputs) -> None:
        loop.last = outputs._replace(alarms=())

    return loop.run(keep)


@pytest.mark.parametrize("ticks", [8, pytest.param(9, marks=pytest.mark.long)])
def test_compensation_goes_on_after_a_stall_that_the_winch_bears(ticks):
    """Of up to 0.45 s: its own watchdog stops a winch after 0.5 s. The drum keeps its rate meanwhile, and where the
    unit is stays known: it is held again as without a stall as soon as the winch has caught up, in 2 s."""
    smooth, stalled = run(0, 48.0), run(ticks, 48.0)
    (left_out,) = [alarm for _, alarm in stalled.alarms if alarm.name != "MODE_CHANGED"]
    assert (left_out.code, left_out.values["count"]) == ("TICKS_LEFT_OUT", ticks)
    assert left_out.values["time"] == pytest.approx(ticks * 0.05)
    again = STALLED + ticks * 0.05
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
