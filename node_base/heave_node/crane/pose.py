"""The pose of a crane as it travels: joints, their rates, a stamp. See heave_msgs/CranePose for units and signs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

from heave_node.cdr.packer import Packer
from heave_node.crane.kinematics import JOINTS
from heave_node.interface import topics
from heave_node.interface.sensors import WireReading

RATES = tuple(f"{joint}_rate" for joint in JOINTS)
"""Time derivatives of the joints [rad/s], [m/s]."""
POSE_FIELDS = (*JOINTS, *RATES)
"""Fields of heave_msgs/CranePose, in this order."""
LARGEST = (("slew", 7.0), ("luff", 3.2), ("knuckle", 3.2), ("extension", 100.0))
"""Joints with the largest magnitude that is plausible, for who checks a publisher."""


class CranePose(NamedTuple):
    """Where the joints of a crane are."""

    time: float  # of the measurement [s]
    joints: tuple[float, ...]  # slew, luff, knuckle [rad], extension [m]; NaN: not measured
    rates: tuple[float, ...] = (math.nan,) * len(JOINTS)  # their time derivatives [rad/s], [m/s]; NaN: not measured


def pose_to_wire(pose: CranePose) -> WireReading:
    """Return a `pose` as it travels."""
    return WireReading(round(pose.time * 1e9), (*pose.joints, *pose.rates))


def pose_of(reading: WireReading) -> CranePose:
    """Return the pose that a `reading` of POSE_FIELDS carried."""
    return pose_of_numbers(reading.time, reading.numbers)


def pose_of_numbers(time: float, numbers: Sequence[float]) -> CranePose:
    """Return the pose of a `time` [s] whose POSE_FIELDS are the `numbers`."""
    return CranePose(time, tuple(numbers[: len(JOINTS)]), tuple(numbers[len(JOINTS) :]))


def moved(joints: Sequence[float], rates: Sequence[float], elapsed: float) -> tuple[float, ...]:
    """Return where joints are an `elapsed` time later [s] at constant rates.

    Parameters
    ----------
    joints : [rad], [m]
    rates : [rad/s], [m/s]
    elapsed : [s]; may be negative
    """
    return tuple(joint + rate * elapsed for joint, rate in zip(joints, rates, strict=True))


@cache
def _packer() -> Packer:
    return Packer(topics.CRANE_POSE.type, ("header.stamp", *POSE_FIELDS), {"header.frame_id": "vessel"})


def pose_message(reading: WireReading) -> bytes:
    """Return the message heave_msgs/CranePose that carries a `reading` of POSE_FIELDS."""
    return _packer().pack(reading.stamp, *reading.numbers)
