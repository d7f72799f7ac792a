"""The parameters of the simulated crane: its lengths, its programme of moves, the sensor of its pose."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from heave_node.crane.kinematics import JOINTS, CraneParameters
from heave_node.parameters import group, parameter
from heave_node.sensing.view import SensorParameters, View

if TYPE_CHECKING:
    from heave_node.numerics.arrays import Array

_WHERE = "after each of move_times; none: it stays."


@dataclass(frozen=True)
class PoseSensorParameters(SensorParameters):
    """Encoders of the crane's joints, read together. A scale, and a fault of one, is that of all of them."""

    rate: float = parameter(20.0, "Hz", 1e-3, 10_000.0, "Samples per second.")
    angle_resolution: float = 0.0  # step of the measured angles [rad]; 0 means none

    def view(self, truth: Array) -> View:
        """See the joints [rad], [m], and their rates [rad/s], [m/s], shape (8,)."""
        angle = self.angle_resolution
        return View(truth, 0.0, resolution=(angle, angle, angle, 0.0, 0.0, 0.0, 0.0, 0.0))


@dataclass(frozen=True)
class CraneMotionParameters(CraneParameters):
    """The crane of the simulated ship: it begins in the reference pose, moves by a programme, and measures its pose."""

    move_times: tuple[float, ...] = parameter((), "s", 0.0, None,
        "Simulated times at which moves of the crane begin, ascending.")  # fmt: skip
    move_slew: tuple[float, ...] = parameter((), "rad", -6.3, 6.3, f"Slew {_WHERE}")
    move_luff: tuple[float, ...] = parameter((), "rad", -1.6, 1.6, f"Luff {_WHERE}")
    move_knuckle: tuple[float, ...] = parameter((), "rad", -3.2, 3.2, f"Knuckle {_WHERE}")
    move_extension: tuple[float, ...] = parameter((), "m", -100.0, 100.0, f"Extension {_WHERE}")
    turn_rate: float = parameter(0.035, "rad/s", 1e-4, 1.0, "Largest rate of an angle during a move.")
    extension_rate: float = parameter(0.2, "m/s", 1e-4, 10.0, "Largest rate of the extension during a move.")
    pose: PoseSensorParameters = group(PoseSensorParameters)

    def __post_init__(self) -> None:
        self.pose.faults.check("crane.pose.faults", "sensor")
        if list(self.move_times) != sorted(self.move_times):
            raise ValueError(f"crane.move_times must be ascending; got {list(self.move_times)}")
        for joint in JOINTS:
            targets = getattr(self, f"move_{joint}")
            if targets and len(targets) != len(self.move_times):
                raise ValueError(f"crane.move_{joint} must be empty or have as many values as crane.move_times")
        if self.move_times and not self.is_fitted:
            raise ValueError("crane.move_times needs a crane: give crane.boom_length")

    def largest_rate(self, joint: str) -> float:
        """Return the largest rate of a `joint` during a move [rad/s], [m/s]."""
        return self.extension_rate if joint == "extension" else self.turn_rate
