"""Where the boom tip of a crane is in the ship's frame, and how it moves there.

Frame of the ship (REP-103): x forward, y to port, z up. Slew s turns the boom about z, anticlockwise seen from above,
0 forward. Luff l is the main boom's angle above the horizontal, knuckle k the jib's against the main boom, both
positive up; the extension e lengthens the last part. From the slew axis, at the height of the boom's hinge:

    reach  = offset + boom cos(l) + (jib + e) cos(l + k)
    height =          boom sin(l) + (jib + e) sin(l + k)
    r      = (reach cos(s), reach sin(s), height)

and the velocity and acceleration in that frame are its time derivatives, by the chain rule. Only differences of r
matter: the boom tip of the reference pose is where `boom_tip_arm` says, so the pedestal stands at `boom_tip_arm` less r
of that pose. A boom without a knuckle has a jib of 0: the extension is then that of the boom.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from heave_node.parameters import parameter

JOINTS = ("slew", "luff", "knuckle", "extension")
"""Joints of a crane: three angles [rad] and a length [m]."""

Vector = tuple[float, float, float]
"""Three components in the ship's frame."""
STILL = (0.0, 0.0, 0.0, 0.0)
"""Rates of joints that stand still."""


@dataclass(frozen=True)
class CraneParameters:
    """Lengths of the crane, and the pose in which the boom tip is at `vessel.boom_tip_arm`."""

    boom_length: float = parameter(0.0, "m", 0.0, 200.0, "Main boom, hinge to knuckle or tip; 0: no crane.")
    jib_length: float = parameter(0.0, "m", 0.0, 200.0, "Knuckle to tip, retracted; 0: the boom has no knuckle.")
    offset: float = parameter(0.0, "m", -20.0, 20.0, "Slew axis to the hinge of the boom, along the boom.")
    slew: float = parameter(1.5707963267948966, "rad", -6.3, 6.3,
        "Reference pose: boom from forward, anticlockwise seen from above; pi/2 is to port.")  # fmt: skip
    luff: float = parameter(0.7, "rad", -1.6, 1.6, "Reference pose: main boom above the horizontal.")
    knuckle: float = parameter(0.0, "rad", -3.2, 3.2, "Reference pose: jib against the main boom, positive up.")
    extension: float = parameter(0.0, "m", 0.0, 100.0, "Reference pose: extension of the last part.")

    @property
    def is_fitted(self) -> bool:
        """Whether there is a crane whose tip moves with its joints."""
        return self.boom_length > 0.0

    @property
    def reference(self) -> tuple[float, ...]:
        """Joints of the reference pose: slew, luff, knuckle [rad], extension [m]."""
        return self.slew, self.luff, self.knuckle, self.extension


class TipPlace(NamedTuple):
    """The boom tip in the ship's frame."""

    arm: Vector  # from its place in the reference pose [m]
    velocity: Vector  # in the ship's frame [m/s]
    acceleration: Vector  # in the ship's frame [m/s^2]


class Crane:
    """Kinematics of the boom tip of a crane with these `parameters`."""

    def __init__(self, parameters: CraneParameters) -> None:
        self._parameters = parameters
        self._reference: Vector = (0.0, 0.0, 0.0)
        self._reference = self.tip(parameters.reference).arm

    def tip(
        self, joints: Sequence[float], rates: Sequence[float] = STILL, accelerations: Sequence[float] = STILL
    ) -> TipPlace:
        """Return where the boom tip is and how it moves in the ship's frame; see the equation at the top.

        Parameters
        ----------
        joints : slew, luff, knuckle [rad], extension [m]
        rates : their time derivatives [rad/s], [m/s]
        accelerations : their second ones [rad/s^2], [m/s^2]
        """
        slew, luff, knuckle, extension = joints
        slew_rate, luff_rate, knuckle_rate, extension_rate = rates
        p = self._parameters
        boom = _part(p.boom_length, 0.0, 0.0, luff, luff_rate, accelerations[1])
        last = _part(
            p.jib_length + extension,
            extension_rate,
            accelerations[3],
            luff + knuckle,
            luff_rate + knuckle_rate,
            accelerations[1] + accelerations[2],
        )
        (reach, height), (reach_rate, height_rate), (reach_2, height_2) = (
            (a[0] + b[0], a[1] + b[1]) for a, b in zip(boom, last, strict=True)
        )
        reach += p.offset
        c, s = math.cos(slew), math.sin(slew)
        along = reach_2 - reach * slew_rate**2
        across = reach * accelerations[0] + 2.0 * reach_rate * slew_rate
        x0, y0, z0 = self._reference
        return TipPlace(
            (reach * c - x0, reach * s - y0, height - z0),
            (reach_rate * c - reach * slew_rate * s, reach_rate * s + reach * slew_rate * c, height_rate),
            (along * c - across * s, along * s + across * c, height_2),
        )


Plane = tuple[float, float]


def _part(
    length: float, length_rate: float, length_2: float, angle: float, angle_rate: float, angle_2: float
) -> tuple[Plane, Plane, Plane]:
    """Return reach and height of a part of the boom, and their first and second derivatives.

    Parameters
    ----------
    length, length_rate, length_2 : of the part, and derivatives
    angle, angle_rate, angle_2 : above the horizontal, and derivatives
    """
    c, s = math.cos(angle), math.sin(angle)
    along = length_2 - length * angle_rate**2
    across = length * angle_2 + 2.0 * length_rate * angle_rate
    return (
        (length * c, length * s),
        (length_rate * c - length * angle_rate * s, length_rate * s + length * angle_rate * c),
        (along * c - across * s, along * s + across * c),
    )
