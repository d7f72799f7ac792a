"""The quantities that a device can give: dimension, largest size that can be, and which ways are positive.

One table for maps of devices and of records: units are checked by the dimension, and a value beyond the largest size is
not used.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from heave_node.crane.kinematics import JOINTS
from heave_node.crane.pose import RATES

from heave_devices.formats.device_time import LATEST


@dataclass(frozen=True)
class Quantity:
    """A quantity."""

    dimension: str  # name in `heave_node.files.units.UNITS`
    largest: float  # magnitude beyond which a value is not used, in the SI unit
    # words for a positive direction, with the sign that turns it into the suite's
    ways: Mapping[str, float] = field(default_factory=dict)

    @property
    def is_measured(self) -> bool:
        """Whether it is a measurement, of which an end of its number's range stands for none: no count, state, time."""
        return self.dimension not in ("number", "time")


_UP = {"up": 1.0, "down": -1.0}
_ROLL = {"starboard down": 1.0, "port up": 1.0, "port down": -1.0, "starboard up": -1.0}
_PITCH = {"bow down": 1.0, "bow up": -1.0}
_TURN = {"anticlockwise": 1.0, "clockwise": -1.0}
_OUT = {"out": 1.0, "in": -1.0}
QUANTITIES: Mapping[str, Quantity] = {
    "heave": Quantity("length", 30.0, _UP),
    "heave_rate": Quantity("speed", 30.0, _UP),
    "heave_acceleration": Quantity("acceleration", 100.0, _UP),
    "surge": Quantity("length", 1e3, {"forward": 1.0, "aft": -1.0}),
    "sway": Quantity("length", 1e3, {"port": 1.0, "starboard": -1.0}),
    "roll": Quantity("angle", 1.6, _ROLL),
    "pitch": Quantity("angle", 1.6, _PITCH),
    "roll_rate": Quantity("turn rate", 3.0, _ROLL),
    "pitch_rate": Quantity("turn rate", 3.0, _PITCH),
    "pressure": Quantity("pressure", 2e8),
    "tension": Quantity("force", 1e8),
    "payout": Quantity("length", 1e4, _OUT),
    "payout_rate": Quantity("speed", 30.0, _OUT),
    "ordered_rate": Quantity("speed", 30.0, _OUT),
    "unit_heave": Quantity("length", 1e4, _UP),
    "brake": Quantity("number", 1e9),
    "fault": Quantity("number", 1e9),
    "watchdog": Quantity("number", 1e19),
    "device_time": Quantity("time", LATEST),
    "slew": Quantity("angle", 7.0, _TURN),
    "luff": Quantity("angle", 3.2, _UP),
    "knuckle": Quantity("angle", 3.2, _UP),
    "extension": Quantity("length", 100.0, _OUT),
    "slew_rate": Quantity("turn rate", 3.0, _TURN),
    "luff_rate": Quantity("turn rate", 3.0, _UP),
    "knuckle_rate": Quantity("turn rate", 3.0, _UP),
    "extension_rate": Quantity("speed", 10.0, _OUT),
}
"""Quantities by name; SI units, signs of `sample`. Of ordered_rate and unit_heave only records are made use of."""
NED_WAYS = {
    **dict.fromkeys(("heave", "heave_rate", "heave_acceleration"), "down"),
    **dict.fromkeys(("pitch", "pitch_rate"), "bow up"),
}
"""Positive direction of each where x is forward, y to starboard and z down; others are as in the suite's own axes."""

OUTPUTS: Mapping[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "mru": (("heave",), ("heave_rate", "heave_acceleration", "roll", "pitch", "roll_rate", "pitch_rate")),
    "unit/pressure": (("pressure",), ()),
    "winch/load_cell": (("tension",), ()),
    "winch/state": (("payout",), ("payout_rate", "tension", "brake", "fault")),
    "crane/pose": (JOINTS, RATES),
}
"""Topics of the suite: quantities of which one makes it be published, and those that it takes besides."""
