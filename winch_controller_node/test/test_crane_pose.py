"""Which poses of a crane are used, and where its joints are without a usable one."""

import math

import pytest
from heave_node.crane.pose import CranePose
from winch_controller_node.crane.pose_watch import CONFIRMED_AFTER, WELL_AFTER, PoseWatch
from winch_controller_node.parameters.crane import CraneModelParameters

CRANE = CraneModelParameters(boom_length=20.0, slew=1.5, luff=0.6)
NAN = (math.nan,) * 4
RATE = 0.03


def slewing(t):
    return (1.5 + RATE * t, 0.6, 0.0, 0.0)


def watch_until(end, pose=slewing, step=0.1, rates=NAN, parameters=CRANE):
    watch, n = PoseWatch(parameters), 0
    while n * step <= end + 1e-9:
        watch.take(n * step, CranePose(n * step, pose(n * step), rates))
        watch.tick(n * step)
        n += 1
    return watch


def codes(watch):
    return [alarm.code for alarm in watch.news()]


def test_joints_between_poses_go_on_at_rates_that_are_stated_or_taken_of_the_poses():
    for rates in (NAN, (RATE, 0.0, 0.0, 0.0)):
        watch = watch_until(3.0, rates=rates)
        joints, found = watch.at(3.05)
        assert joints == pytest.approx(slewing(3.05))
        assert found == pytest.approx((RATE, 0.0, 0.0, 0.0))
        assert codes(watch) == ["CRANE_POSE_USED"]


def test_a_stale_pose_is_held_and_told_once():
    watch = watch_until(3.0)
    watch.news()
    for n in range(1, 60):
        watch.tick(3.0 + 0.05 * n)
    (alarm,) = watch.news()
    assert alarm.code == "CRANE_POSE_STALE"
    assert alarm.values["age"] == pytest.approx(1.05, abs=0.051)
    # the last rate goes on until it is stale, after 1 s
    assert watch.at(60.0)[0] == pytest.approx(slewing(4.05), abs=0.06 * RATE)
    assert watch.at(60.0)[1] == (0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("pose", "code"),
    [
        (lambda t: CranePose(t, (math.nan, 0.6, 0.0, 0.0)), "CRANE_POSE_INVALID"),
        (lambda t: CranePose(t + 5.0, slewing(t)), "CRANE_POSE_INVALID"),
        (lambda t: CranePose(1.0, slewing(t)), "CRANE_POSE_INVALID"),
        (lambda t: CranePose(t, (slewing(t)[0] + 0.5, 0.6, 0.0, 0.0)), "CRANE_POSE_JUMP"),
    ],
)
def test_what_cannot_be_is_rejected_told_once_held_and_well_again_after_a_second(pose, code):
    watch = watch_until(3.0)
    watch.news()
    for n in range(1, 31):
        now = 3.0 + 0.1 * n
        watch.take(now, pose(now))
        watch.tick(now)
    assert codes(watch) == [code]
    assert watch.fault == code
    assert watch.at(6.0)[0] == pytest.approx(slewing(4.05), abs=0.11 * RATE)
    held = watch.at(6.0)[0]
    for n in range(31, 45):
        watch.take(3.0 + 0.1 * n, CranePose(3.0 + 0.1 * n, held))
    assert codes(watch) == ["CRANE_POSE_RESTORED"]
    assert watch.fault == ""
    assert WELL_AFTER == 1.0


def test_a_jump_says_which_joint_and_by_how_much():
    watch = watch_until(3.0, pose=lambda t: (1.5, 0.6, 0.0, 0.0))
    watch.news()
    watch.take(3.1, CranePose(3.1, (1.5, 0.6, 0.0, 4.0)))
    (alarm,) = watch.news()
    assert (alarm.values["joint"], alarm.values["jump"], alarm.values["unit"]) == ("extension", 4.0, "m")


def test_a_pose_elsewhere_that_goes_on_is_used_after_its_time_and_garbage_never():
    def use_after(later):
        watch = watch_until(3.0)
        for n in range(1, 200):
            watch.take(3.0 + 0.1 * n, CranePose(3.0 + 0.1 * n, later(n)))
            watch.tick(3.0 + 0.1 * n)
            if watch.breaks:
                return 0.1 * n
        return math.inf

    assert use_after(lambda n: (2.5, 0.6, 0.0, 0.0)) == pytest.approx(CONFIRMED_AFTER + 0.1)
    assert use_after(lambda n: (1.5 + 0.4 * ((7 * n) % 5 + 1), 0.6, 0.0, 0.0)) == math.inf


def test_an_encoder_that_begins_again_after_a_turn_has_not_jumped():
    watch = watch_until(20.0, pose=lambda t: (math.remainder(2.9 + 0.05 * t, math.tau), 0.6, 0.0, 0.0))
    assert codes(watch) == ["CRANE_POSE_USED"]
    assert watch.at(20.0)[0][0] == pytest.approx(3.9)


def test_a_joint_that_is_not_measured_keeps_the_reference_pose():
    parameters = CraneModelParameters(boom_length=20.0, slew=1.5, luff=0.6, joints=("slew",))
    watch = watch_until(1.0, pose=lambda t: (slewing(t)[0], math.nan, math.nan, math.nan), parameters=parameters)
    assert watch.at(1.0)[0] == pytest.approx(slewing(1.0))
    assert watch.fault == ""
