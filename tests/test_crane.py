"""A lift whose crane slews by 60 degrees while it compensates, with the pose of the crane and without it."""

import numpy as np
import pytest
from heave_bringup.closed_loop import ClosedLoop, LoopRecord, loop_parameters
from heave_bringup.scenarios import load_scenario

SLEWED = 180.0
"""Time at which the slew is over [s]: it begins at 120 s and takes 1.875 * 1.047 rad / 0.035 rad/s = 56 s."""


def slewed_lift(*settings: str) -> LoopRecord:
    return ClosedLoop(loop_parameters(load_scenario("crane_slew", settings=list(settings)))).run()


def heaves(record: LoopRecord, start: float, end: float) -> tuple[float, float, float]:
    """Return standard deviations of the unit's heave, and of that without compensation, and the ratio."""
    time = record.column("time")
    within = (time >= start) & (time < end)
    unit = float(np.std((record.column("unit") + record.column("depth_set_point"))[within]))
    free = float(np.std(record.column("uncompensated")[within]))
    return unit, free, unit / free


@pytest.mark.slow
@pytest.mark.long
def test_with_the_pose_a_slewed_lift_is_held_and_without_it_is_not():
    """A chord of 24.7 m times pitch and roll is missing without the pose: as much as the heave itself."""
    with_pose, without = slewed_lift(), slewed_lift("wave_vessel.crane.publishes_pose=false")
    assert [alarm.code for _, alarm in with_pose.alarms if alarm.code.startswith("CRANE")] == ["CRANE_POSE_USED"]
    assert not [alarm for _, alarm in without.alarms if alarm.code.startswith("CRANE")]
    for record in (with_pose, without):
        assert heaves(record, 60.0, 120.0)[2] < 0.03, "before the slew both hold the unit"
    for start, end in ((120.0, SLEWED), (SLEWED, 300.0)):
        assert heaves(with_pose, start, end)[2] < 0.1
        assert heaves(without, start, end)[0] > 4.0 * heaves(with_pose, start, end)[0]
