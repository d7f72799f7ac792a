"""A lift whose crane slews by 60 degrees while it compensates, with the pose of the crane and without it."""

import numpy as np
import pytest
from domain_coordinator import domain_id
from heave_bags.mcap.reader import Bag
from heave_bringup.closed_loop import ClosedLoop, LoopRecord, loop_parameters
from heave_bringup.scenarios import load_scenario

from tests.loop_runs import HAS_RUN, give
from tests.test_one_loop import compare

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


@pytest.mark.slow
@pytest.mark.long
def test_over_ros_it_is_the_same_to_the_last_bit_and_the_pose_is_in_the_bag(tmp_path):
    settings = ["all.transient=5", "wave_vessel.ramp=3", "wave_vessel.crane.move_times=[2.0]"]
    options = [part for setting in settings for part in ("--set", setting)]
    with domain_id() as domain:
        options += ["--no-report", "--bag", str(tmp_path / "run")]
        run = give(domain, "run", "crane_slew", "--duration", "12", "--composed", *options)
    assert run.returncode in HAS_RUN, run.stderr
    bag = tmp_path / "run" / "bag"
    poses = [message for _, message in Bag(bag).decoded(["crane/pose"])]
    assert len(poses) == 12.0 / 0.05
    assert poses[-1].slew > poses[0].slew == 1.5708
    compare(bag)
