"""Samples of a crane's encoders put together to what the suite calls `crane/pose`: one for each that holds a joint."""

from __future__ import annotations

import math

from heave_node.crane.kinematics import JOINTS
from heave_node.crane.pose import POSE_FIELDS
from heave_node.devices.live.taker import Taken


class CraneMaker:
    """Makes poses; a joint or rate that the map does not have, or that is invalid or old, is NaN.

    Parameters
    ----------
    timeout : age above which a quantity is old [s]
    """

    def __init__(self, timeout: float) -> None:
        self._timeout = timeout
        self._newest: dict[str, tuple[float, float]] = {}

    def take(self, taken: Taken) -> tuple[float, ...] | None:
        """Return the numbers of POSE_FIELDS that a sample, `taken`, completes; None where it holds no joint."""
        for name in POSE_FIELDS:
            if name in taken.values:
                self._newest[name] = (taken.time, taken.values[name])
            elif name in taken.invalid:
                self._newest.pop(name, None)
        if not any(joint in taken.values or joint in taken.invalid for joint in JOINTS):
            return None
        return tuple(self._recent(name, taken.time) for name in POSE_FIELDS)

    def _recent(self, name: str, time: float) -> float:
        at, value = self._newest.get(name, (-math.inf, math.nan))
        return value if time - at <= self._timeout else math.nan
