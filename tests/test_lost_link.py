"""A link to the winch that is down for ten seconds: compensation comes back by itself, at whatever moment it went."""

from dataclasses import replace

import numpy as np
import pytest
from heave_bringup.closed_loop import ClosedLoop, LoopRecord

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
