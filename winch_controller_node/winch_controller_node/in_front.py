"""What may stand in front of the controller: it makes the MRU of the boom tip of what was delivered, by entry point."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple, Protocol

from heave_node.crane.pose import CranePose
from heave_node.extras import extra_parts, load_part
from heave_node.interface.alarm import AlarmTable

from winch_controller_node.core.component import WinchController
from winch_controller_node.interface.readings import Measurements, Outputs
from winch_controller_node.node_parameters import CRANE, MOTION_SOURCES


class MotionSource(Protocol):
    """A controller with something in front of it."""

    def step(self, tick: int, measurements: Measurements, poses: Sequence[CranePose] = ()) -> Outputs:
        """Do tick k of the controller with the `measurements` delivered at it, and `poses` of the crane."""

    def health(self) -> Mapping[str, tuple[bool, str]]:
        """Return whether what it reads is well, and how it is, by name."""


class MotionSourceEntry(NamedTuple):
    """What an extra brings."""

    make: Callable[[WinchController, float], MotionSource]  # puts it in front of a controller with a tick period [s]
    alarms: AlarmTable  # that it raises


class NothingInFront:
    """A controller by itself; poses of a crane are not looked at.

    `controller` : it is
    """

    def __init__(self, controller: WinchController) -> None:
        self._controller = controller

    def step(self, tick: int, measurements: Measurements, poses: Sequence[CranePose] = ()) -> Outputs:
        """See MotionSource."""
        del poses
        return self._controller.step(tick, measurements)

    def health(self) -> Mapping[str, tuple[bool, str]]:
        """See MotionSource."""
        return {}


def motion_source(controller: WinchController, tick_period: float) -> MotionSource:
    """Return the `controller` with what stands in front of it, for a `tick_period` [s].

    Raises MissingExtraError where its parameters have a crane that moves and nothing that reads its pose is installed.
    """
    if not controller.parameters.crane.is_fitted and CRANE not in extra_parts(MOTION_SOURCES):
        return NothingInFront(controller)
    entry: MotionSourceEntry = load_part(MOTION_SOURCES, CRANE, "system.crane")
    return entry.make(controller, tick_period)
