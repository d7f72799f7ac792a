"""Samples of a crane's encoders put together to what the suite calls `crane/pose`: one for each that holds a joint."""

from __future__ import annotations

from heave_node.crane.kinematics import JOINTS
from heave_node.crane.pose import POSE_FIELDS

from heave_devices.live.taker import Recent, Taken


class CraneMaker:
    """Makes poses; a joint or rate that the map does not have, or that is invalid or old, is NaN.

    Parameters
    ----------
    timeout : age above which a quantity is old [s]
    """

    def __init__(self, timeout: float) -> None:
        self._recent = Recent(POSE_FIELDS, timeout)

    def take(self, taken: Taken) -> tuple[float, ...] | None:
        """Return the numbers of POSE_FIELDS that a sample, `taken`, completes; None where it holds no joint."""
        pose = self._recent.take(taken)
        if not any(joint in taken.values or joint in taken.invalid for joint in JOINTS):
            return None
        return tuple(pose.values())
