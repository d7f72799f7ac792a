"""Which poses of a crane are used, and where its joints are without a usable one."""

import math

import numpy as np
import pytest
from heave_devices.crane.pose_watch import ALARMS, WELL_AFTER, PoseWatch
from heave_devices.crane.tip_carry import TipCarry
from heave_node.crane.pose import CranePose
from heave_node.interface.faults import FaultParameters
from heave_node.interface.sensors import MruReading
from wave_vessel_node.parameters import CraneMotionParameters, PoseSensorParameters
from wave_vessel_node.vessel.crane_motion import CraneMotion, PoseSensor
from winch_controller_node.interface.readings import Measurements
from winch_controller_node.interface.sensors import MruModelParameters
from winch_controller_node.parameters.model import CONFIRMED_AFTER, CraneModelParameters

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
    return [alarm.name for alarm in watch.news()]


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
    assert alarm.name == "CRANE_POSE_STALE"
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


@pytest.mark.parametrize(
    ("pose", "rate"),
    [(lambda t: slewing(min(t, 3.0)), RATE), (slewing, -RATE), (slewing, math.degrees(RATE))],
    ids=["frozen", "rate of the wrong sign", "rate in degrees"],
)
def test_a_joint_that_does_not_move_by_its_stated_rate_is_told_within_a_second_and_goes_by_its_poses(pose, rate):
    watch, found = PoseWatch(CRANE), {}
    for n in range(1, 121):
        now = 0.05 * n
        stated = rate if now > 3.0 else RATE
        watch.take(now, CranePose(now, pose(now), (stated, 0.0, 0.0, 0.0)))
        watch.tick(now)
        found |= {alarm.name: (now, alarm.values) for alarm in watch.news()}
    assert set(found) == {"CRANE_POSE_USED", "CRANE_RATES_DISAGREE"}
    when, values = found["CRANE_RATES_DISAGREE"]
    assert 3.0 < when < 4.0
    assert (values["joint"], values["unit"]) == ("slew", "rad")
    joints, rates = watch.at(6.0)
    assert joints == pytest.approx(pose(6.0), abs=1e-9)
    assert rates[0] == pytest.approx(0.0 if pose(6.0) == pose(5.0) else RATE, abs=1e-9)
    for n in range(121, 400):
        watch.take(0.05 * n, CranePose(0.05 * n, pose(6.0), (0.0,) * 4))
    assert codes(watch) == ["CRANE_POSE_RESTORED"]


@pytest.mark.parametrize(
    ("kind", "magnitude", "code", "within"),
    [
        ("gap", 0.0, "CRANE_POSE_STALE", 1.1),
        ("nan", 0.0, "CRANE_POSE_INVALID", 0.05),
        ("spike", 0.5, "CRANE_POSE_JUMP", 0.05),
        ("jump", 0.5, "CRANE_POSE_JUMP", 0.05),
        ("scale", -1.0, "CRANE_POSE_JUMP", 0.05),
        ("scale", 1.1, "CRANE_POSE_JUMP", 0.05),
        ("freeze", 0.0, "CRANE_RATES_DISAGREE", 1.0),
        ("rate", 0.5, "CRANE_POSE_STALE", 3.1),
        ("delay", 2.0, "CRANE_POSE_STALE", 1.1),
    ],
)
def test_each_fault_of_the_encoders_raises_its_alarm_in_time_and_moves_nothing(kind, magnitude, code, within):
    """Of encoders as they are simulated, of a boom that slews and luffs when the fault begins, at 6 s."""
    begins, sensor = 6.0, PoseSensorParameters(faults=FaultParameters((kind,), (6.0,), (0.0,), (magnitude,)))
    moves = {"move_times": (2.0,), "move_slew": (2.0,), "move_luff": (0.8,), "turn_rate": 0.08}
    crane = CraneMotionParameters(boom_length=20.0, slew=1.5, luff=0.6, pose=sensor, **moves)
    encoders = PoseSensor(CraneMotion(crane, np.zeros(3), 0.0), sensor, seed=1, tick_period=0.05)
    carry = TipCarry(CRANE, MruModelParameters())
    told, lifted = {}, []
    for tick in range(1, 400):
        carry.carried(0.05 * tick, Measurements(mru=(MruReading(0.05 * tick, 0.0, 0.0),)), encoders.step(tick))
        for alarm in carry.pose.news():
            told.setdefault(alarm.name, 0.05 * tick)
        lifted.append(carry.lift(0.05 * tick)[0])
    first = next(name for name, when in told.items() if when >= begins - 1e-9)
    assert (first, told[first] - begins) == (code, pytest.approx(0.5 * within, abs=0.5 * within + 1e-6))
    # no step: the boom lifts its tip by 0.08 rad/s times 20 m at most
    assert np.abs(np.diff(lifted)).max() < 0.08 * 20.0 * 0.05 * 1.05


def test_rates_that_are_noisy_and_poses_in_steps_agree():
    """An encoder of 12 bits, 1.5 mrad a step, and rates off by a tenth, at four poses a second."""
    step, random = math.tau / 4096, random_rates()
    watch = watch_until(0.0)
    for n in range(1, 400):
        t = 0.25 * n
        joint = 1.5 + 0.5 * math.sin(0.1 * t)
        rate = 0.05 * math.cos(0.1 * t) + 0.005 * next(random)
        watch.take(t, CranePose(t, (step * round(joint / step), 0.6, 0.0, 0.0), (rate, 0.0, 0.0, 0.0)))
        watch.tick(t)
    assert codes(watch) == ["CRANE_POSE_USED"]


def random_rates():
    generator = np.random.default_rng(1)
    while True:
        yield float(generator.standard_normal())


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


def test_the_time_in_the_words_is_that_of_the_code():
    assert f"after {CONFIRMED_AFTER:g} s" in ALARMS["CRANE_POSE_JUMP"].consequence
