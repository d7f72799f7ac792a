"""The boom tip of a crane: places by hand, and rates by differences."""

import math

import numpy as np
import pytest
from heave_node.crane.kinematics import Crane, CraneParameters
from heave_node.numerics.kinematics import height_of, height_rate_of

DEGREE = math.radians(1.0)
KNUCKLE = CraneParameters(boom_length=20.0, jib_length=10.0, offset=2.0, slew=0.0, luff=0.0)
"""In its reference pose a straight boom ahead, 2 + 20 + 10 m from the slew axis."""


@pytest.mark.parametrize(
    ("joints", "place"),
    [
        ((0.0, 0.0, 0.0, 0.0), (32.0, 0.0, 0.0)),
        ((90.0, 0.0, 0.0, 0.0), (0.0, 32.0, 0.0)),  # to port
        ((-90.0, 0.0, 0.0, 0.0), (0.0, -32.0, 0.0)),
        ((0.0, 90.0, 0.0, 0.0), (2.0, 0.0, 30.0)),  # straight up
        ((0.0, 90.0, -90.0, 0.0), (12.0, 0.0, 20.0)),  # the jib level ahead of an upright boom
        ((0.0, 60.0, -120.0, 0.0), (2.0 + 10.0 + 5.0, 0.0, 10.0 * math.sqrt(3.0) - 5.0 * math.sqrt(3.0))),
        ((180.0, 30.0, 0.0, 4.0), (-(2.0 + 17.0 * math.sqrt(3.0)), 0.0, 17.0)),  # 34 m at 30 degrees, astern
    ],
)
def test_places_of_the_tip_by_hand(joints, place):
    slew, luff, knuckle, extension = joints
    tip = Crane(KNUCKLE).tip((slew * DEGREE, luff * DEGREE, knuckle * DEGREE, extension))
    assert np.add(tip.arm, (32.0, 0.0, 0.0)) == pytest.approx(place, abs=1e-12)


def test_in_the_reference_pose_the_tip_is_where_the_arm_says_and_a_slew_by_60_degrees_is_a_chord():
    parameters = CraneParameters(boom_length=25.0, luff=0.6, slew=1.2)
    assert Crane(parameters).tip(parameters.reference).arm == (0.0, 0.0, 0.0)
    moved = Crane(parameters).tip((1.2 + 60.0 * DEGREE, 0.6, 0.0, 0.0)).arm
    assert math.hypot(*moved) == pytest.approx(25.0 * math.cos(0.6)), "the chord of 60 degrees is the radius"
    assert moved[2] == 0.0


def joints_at(t):
    return np.array([1.0 + 0.3 * math.sin(0.5 * t), 0.6 + 0.1 * t, -0.8 + 0.2 * math.sin(t), 3.0 + math.cos(0.7 * t)])


def rates_at(t):
    return np.array([0.15 * math.cos(0.5 * t), 0.1, 0.2 * math.cos(t), -0.7 * math.sin(0.7 * t)])


def accelerations_at(t):
    return np.array([-0.075 * math.sin(0.5 * t), 0.0, -0.2 * math.sin(t), -0.49 * math.cos(0.7 * t)])


def rate_of(function, t, h=1e-5):
    return (function(t + h) - function(t - h)) / (2.0 * h)


@pytest.mark.parametrize("t", [0.0, 1.3, 4.0])
def test_velocity_and_acceleration_are_the_differences_of_the_place(t):
    crane = Crane(KNUCKLE)

    def tip(u):
        return crane.tip(joints_at(u), rates_at(u), accelerations_at(u))

    # central differences over 1e-5 s of numbers of 30 m: rounding 1e-9, truncation 1e-10
    assert tip(t).velocity == pytest.approx(rate_of(lambda u: np.array(tip(u).arm), t), abs=1e-8)
    assert tip(t).acceleration == pytest.approx(rate_of(lambda u: np.array(tip(u).velocity), t), abs=1e-8)


def test_the_rate_of_a_height_is_its_difference():
    arm = (20.0, -8.0, 15.0)

    def height(t):
        return height_of(arm, 0.1 * math.sin(t), 0.05 * math.cos(0.7 * t))

    t = 2.0
    turning = (0.1 * math.cos(t), -0.035 * math.sin(0.7 * t))
    found = height_rate_of(arm, 0.1 * math.sin(t), 0.05 * math.cos(0.7 * t), turning)
    assert found == pytest.approx(rate_of(height, t), abs=1e-8)
