"""A lift whose crane slews by 60 degrees while it compensates, with the pose of the crane and without it."""

from pathlib import Path

import numpy as np
import pytest
from domain_coordinator import domain_id
from heave_bags.mcap.reader import Bag
from heave_bringup.closed_loop import ClosedLoop, LoopRecord, loop_parameters
from heave_bringup.scenarios import load_scenario

from tests.crane_encoders import LASTING, SLEW, START, TURN
from tests.loop_runs import HAS_RUN, adapting, beside, give
from tests.loops import heave_of, loop_of
from tests.plc import free_port
from tests.test_one_loop import compare

SLEWED = 180.0
"""Time at which the slew is over [s]: it begins at 120 s and takes 1.875 * 1.047 rad / 0.035 rad/s = 56 s."""


def heaves(record: LoopRecord, start: float, end: float) -> tuple[float, float, float]:
    """Return standard deviations of the unit's heave, and of that without compensation, and the ratio."""
    time = record.column("time")
    within = (time >= start) & (time < end)
    unit = float(np.std(heave_of(record)[within]))
    free = float(np.std(record.column("uncompensated")[within]))
    return unit, free, unit / free


RAISED = ("wave_vessel.ramp=10", "wave_vessel.crane.move_times=[40.0]", "wave_vessel.crane.move_slew=[]")
"""Settings of the lift above whose boom is raised from 40 s on instead of slewed."""


def raised_lift(*settings: str) -> tuple[LoopRecord, np.ndarray]:
    """Return the record of a lift whose boom is raised, law lqg, and payout and rate as they left the controller."""
    short = ("all.duration=75", "all.transient=30", "winch_controller.law=lqg", "cable_sim.segments=6")
    scenario = load_scenario("crane_slew", settings=[*short, *RAISED, *settings])
    loop = ClosedLoop(loop_parameters(scenario), has_adviser=False)  # as it was designed, and quick
    orders = []
    record = loop.run(lambda _, outputs: orders.append((outputs.order.payout, outputs.order.payout_rate)))
    return record, np.array(orders)


STARTED = ["CRANE_POSE_USED", "MODE_CHANGED"]


def codes(record: LoopRecord) -> list[str]:
    return [alarm.name for _, alarm in record.alarms]


def test_a_boom_that_is_raised_leaves_the_unit_where_it_is_and_compensation_as_it_was():
    """By 4.4 m in 33 s, at up to 0.22 m/s: the boom's motion is no wave, and the sea's model holds."""
    record, _ = raised_lift("wave_vessel.crane.move_luff=[1.1]", "wave_vessel.crane.turn_rate=0.012")
    assert codes(record) == STARTED
    assert set(record.column("authority", after=40.0)) == {1.0}
    assert heaves(record, 40.0, 75.0)[2] < 0.05
    # what the cable stretches more by 4.4 m of 1,500 m: 3 cm at a tension of 150 kN over 34.5 MN
    lost = record.column("unit", after=70.0).mean() - record.column("unit")[record.column("time") < 40.0][-200:].mean()
    assert abs(lost) < 0.05


@pytest.mark.parametrize("luff", [1.3, pytest.param(0.5, marks=pytest.mark.long)])
def test_lift_and_sea_together_keep_the_speed_limit(luff):
    """The winch itself could do 5 m/s: the governor alone keeps the drum below. The crane lifts by 0.75 m/s at most."""
    speed = 0.9
    free = ("virtual_winch.speed_limit=5", f"winch_controller.winch.speed_limit={speed}")
    record, orders = raised_lift(f"wave_vessel.crane.move_luff=[{luff}]", *free, "all.duration=95")
    assert np.abs(orders[:, 1]).max() <= speed + 1e-9
    assert np.abs(record.column("payout_rate")).max() <= speed + 1e-6
    assert [code for code in codes(record) if code != "SEA_ABOVE_WINCH"] == [*STARTED, "CRANE_TOO_FAST"]
    assert set(record.column("authority", after=40.0)) == {1.0}, "compensation goes on"
    assert heaves(record, 90.0, 95.0)[0] < 0.1, "the winch has caught up"


def test_a_lift_towards_the_end_of_the_range_stops_there_and_compensation_goes_on():
    """The range that is used ends at 2 m: the boom rises by 4.4 m, and the unit goes with it from there."""
    settings = ("wave_vessel.crane.move_luff=[1.1]", "wave_vessel.crane.turn_rate=0.012")
    record, _ = raised_lift(*settings, "winch_controller.winch.payout_maximum=3")
    assert record.column("payout").max() <= 2.0
    assert codes(record) == [*STARTED, "CRANE_BEYOND_RANGE"]
    assert set(record.column("authority", after=40.0)) == {1.0}
    assert heaves(record, 72.0, 75.0)[0] < 0.1


@pytest.mark.slow
@pytest.mark.long
def test_with_the_pose_a_slewed_lift_is_held_and_without_it_is_not():
    """A chord of 24.7 m times pitch and roll is missing without the pose: as much as the heave itself."""
    with_pose, without = (
        loop_of("crane_slew", {"wave_vessel.crane.pose.fitted": fitted}).run() for fitted in ("true", "false")
    )
    assert [alarm.name for _, alarm in with_pose.alarms if alarm.name.startswith("CRANE")] == ["CRANE_POSE_USED"]
    assert not [alarm for _, alarm in without.alarms if alarm.name.startswith("CRANE")]
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


PENCR_MAP = """
source: {{udp: {port}}}
format: nmea
slew: {{field: PENCR.angle_1, positive: anticlockwise}}
luff: {{field: PENCR.angle_2, positive: up}}
knuckle: {{field: PENCR.angle_3, positive: up}}
"""
JOINT_MAP = """
clock: own
slew: {topic: /crane/joint_states, type: sensor_msgs/msg/JointState, field: 'position[name=slew]'}
luff: {topic: /crane/joint_states, type: sensor_msgs/msg/JointState, field: 'position[name=luff]', positive: up}
knuckle: {topic: /crane/joint_states, type: sensor_msgs/msg/JointState, field: 'position[name=knuckle]', positive: up}
"""


@pytest.mark.slow
@pytest.mark.parametrize("way", ["pencr", pytest.param("joint_states", marks=pytest.mark.long)])
def test_encoders_behind_an_adapter_take_the_place_of_the_simulated_ones_while_the_crane_slews(way, tmp_path):
    """Five processes and two programs in real time: without the pose half of the motion is left after the slew."""
    port = free_port("udp")
    crane = tmp_path / "crane.yaml"
    crane.write_text(PENCR_MAP.format(port=port) if way == "pencr" else JOINT_MAP)
    moves = ("move_times=[14.0]", "move_slew=[2.618]", f"turn_rate={1.875 * TURN / LASTING}")
    settings = [f"wave_vessel.crane.{move}" for move in moves]
    settings += ["wave_vessel.ramp=5.0", "winch_controller.law=lqg", "cable_sim.segments=6", "all.transient=10"]
    settings += ["winch_controller.modes.settling_time=5.0", "winch_controller.crane.joints=[slew, luff, knuckle]"]
    options = ["--pacing", "realtime", "--duration", "50", "--no-report", "--replace", "crane/pose=external"]
    options += [part for setting in settings for part in ("--set", setting)]
    program = str(Path(__file__).with_name("crane_encoders.py"))
    with domain_id() as domain, beside(domain, program, way, str(port)), adapting(domain, str(crane)) as ended:
        run = give(domain, "run", "crane_slew", "--bag", str(tmp_path / "run"), *options, timeout=300.0)
    assert run.returncode in HAS_RUN, run.stdout + run.stderr + ended[0].err
    bag = Bag(tmp_path / "run" / "bag")
    columns = bag.columns(
        {
            "/crane/pose": ["slew"],
            "/unit/odometry": ["pose.pose.position.z"],
            "/unit_uncompensated": ["position.z"],
        }
    )
    slew = columns["/crane/pose"]["slew"]
    # five a second; an encoder of 16 bits
    assert len(slew) > 150
    assert (slew[0], slew[-1]) == pytest.approx((SLEW, SLEW + TURN), abs=1e-4)
    tail = {topic: columns[topic] for topic in ("/unit/odometry", "/unit_uncompensated")}
    heave = {topic: next(v for k, v in column.items() if "position" in k)[-300:] for topic, column in tail.items()}
    assert START + LASTING < 50.0 - 15.0
    assert np.std(heave["/unit/odometry"]) < 0.2 * np.std(heave["/unit_uncompensated"])
    said = " ".join(status.message for _, message in bag.decoded(["diagnostics"]) for status in message.status)
    assert "CRANE_POSE_USED" in said
    assert "CRANE_RATES_DISAGREE" not in said
