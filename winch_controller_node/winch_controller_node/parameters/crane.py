"""The crane as the controller knows it: lengths, which joints are measured, how fast they can move."""

from __future__ import annotations

from dataclasses import dataclass

from heave_node.crane.kinematics import JOINTS, CraneParameters
from heave_node.parameters import parameter

CONFIRMED_AFTER = 5.0
"""A pose elsewhere is used once it has gone on without a further jump for so long [s]."""


@dataclass(frozen=True)
class CraneModelParameters(CraneParameters):
    """Lengths and reference pose of the crane, and what of its pose is read on `crane/pose`."""

    joints: tuple[str, ...] = parameter(JOINTS,
        description="Joints that crane/pose measures; others keep the reference pose.", choices=JOINTS)  # fmt: skip
    pose_timeout: float = parameter(1.0, "s", 0.05, 60.0,
        "Age of the newest usable pose above which it is stale, and the last one is held.")  # fmt: skip
    # fastest that slew, luff or knuckle can turn: an angle that changes faster has jumped [rad/s]
    largest_turn_rate: float = 0.1
    # fastest that the boom can extend: an extension that changes faster has jumped [m/s]
    largest_extension_rate: float = 0.5

    @property
    def largest_rates(self) -> tuple[float, ...]:
        """Fastest that each joint can move [rad/s], [m/s]."""
        turn = self.largest_turn_rate
        return turn, turn, turn, self.largest_extension_rate
