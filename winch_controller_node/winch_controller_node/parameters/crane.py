"""The crane as the controller knows it: lengths, which joints are measured, how fast they can move."""

from __future__ import annotations

from dataclasses import dataclass

from heave_node.crane.kinematics import JOINTS, CraneParameters
from heave_node.parameters import parameter


@dataclass(frozen=True)
class CraneModelParameters(CraneParameters):
    """Lengths and reference pose of the crane, and what of its pose is read on `crane/pose`."""

    joints: tuple[str, ...] = parameter(
        JOINTS,
        unit="",
        choices=JOINTS,
        description="Joints that crane/pose measures; others keep the reference pose.",
    )
    pose_timeout: float = parameter(
        1.0,
        unit="s",
        minimum=0.05,
        maximum=60.0,
        description="Age of the newest usable pose above which it is stale, and the last one is held.",
    )
    largest_turn_rate: float = parameter(
        0.1,
        unit="rad/s",
        minimum=1e-3,
        maximum=3.0,
        description="Fastest that slew, luff or knuckle can turn: an angle that changes faster has jumped.",
    )
    largest_extension_rate: float = parameter(
        0.5,
        unit="m/s",
        minimum=1e-3,
        maximum=10.0,
        description="Fastest that the boom can extend: an extension that changes faster has jumped.",
    )
    lift_speed_share: float = parameter(
        0.5,
        unit="",
        minimum=0.0,
        maximum=1.0,
        description="Fraction of the winch's active speed limit that may follow the crane's lift; compensation has the "
        "rest.",
    )
    lift_acceleration_share: float = parameter(
        0.3,
        unit="",
        minimum=0.001,
        maximum=1.0,
        description="Fraction of the winch's active acceleration limit that may follow the crane's lift; compensation "
        "has the rest.",
    )

    @property
    def largest_rates(self) -> tuple[float, ...]:
        """Fastest that each joint can move [rad/s], [m/s]."""
        turn = self.largest_turn_rate
        return turn, turn, turn, self.largest_extension_rate
