"""Where the unit is between hanging and standing: landed, lifted off, or never suspended.

Whether a unit that is lowered has landed, and one that is lifted off hangs again, is found in C++ (`heave_core`,
landing.cpp), from the trends of depth sensor, load cell and mean payout. Under a brake nobody lowers, and a unit may
have stood from the start, on the bottom or on deck. Its cable then carries too little of the weight on average over a
whole swing.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any

from heave_core.watch import LandingWatch
from heave_core.watch_table import LANDING_STATE, Landed

from winch_controller_node.parameters.laws import TensionLawParameters

SHORTEST, LONGEST = 0.6, 8.0
"""Least and largest length of a window [s]."""

LEAST_AUTHORITY = 0.5
"""Authority above which the mean payout lowers the unit."""

LEAST_RATE = 0.01
"""The winch lowers above this speed [m/s]."""

MEAN_ERROR = 0.3
"""Error of the mean tension over its memory, over the standard deviation of the tension: a swell of 20 s leaves
sqrt(2)/(w t) = 0.15 of its own, and a group of waves, or a cable that goes slack and snaps, twice that."""

CONSTANTS = {
    "lowered": 0.15,  # some standard deviations of a depth sensor
    "shortest": SHORTEST,
    "longest": LONGEST,
    "windows": (1.0, 2.0, 3.0),  # longer ones for noisier sensors
    "least_readings": 4,
    "filled": 0.9,
    "least_rate": LEAST_RATE,
    "steady_share": 0.85,
    "standing_share": 0.4,
    "relief_share": 0.5,
    "certain": 3.0,
    "innovation_above": 1.0,
    "unconfirmed_time": 3.0,  # then compensation is judged again
    "pause": 4.0,
}
"""Constants of landing: meanings and units are in the core's table, LANDING_DESIGN."""


class LandingEvent(Enum):
    """What has just happened, by the code of its alarm."""

    TOUCHDOWN = "TOUCHDOWN"
    LIFTED_OFF = "UNIT_SUSPENDED"


EVENTS = {Landed.TOUCHDOWN: LandingEvent.TOUCHDOWN, Landed.LIFTED_OFF: LandingEvent.LIFTED_OFF}
"""By what the core has found."""

STANDS, WEIGHED, UNLOADED, LIFTING, SHARE, EVENT = (
    [row.name for row in LANDING_STATE.rows].index(name)
    for name in ("unit_stands", "is_weighed", "is_unloaded", "is_lifting", "share", "event")
)
"""Places in the core's state."""


@dataclass(frozen=True, slots=True)
class HangingLoad:
    """What is known of the load and its cable."""

    static_tension: float  # at the top while the unit hangs under water [N]
    weight: float  # of the unit in water [N]
    stiffness: float  # of the cable [N/m]
    following_time: float = 0.0  # that the hanging unit needs to follow the winch, a quarter of its free swing [s]
    swing_time: float = 10.0  # of a free swing or a wave, whichever is longer [s]
    cable_weight: float = 0.0  # of the cable in water [N/m]

    def weight_share(self, tension: float) -> float:
        """Return the share of the unit's weight that the cable carries under a `tension` at the top [N]."""
        return (tension - self.static_tension) / self.weight + 1.0


def landing_design(load: HangingLoad, touchdown_ratio: float) -> dict[str, Any]:
    """Return the core's LandingDesign of a `load` that has landed below `touchdown_ratio` of its weight."""
    return {
        "static_tension": load.static_tension,
        "weight": load.weight,
        "stiffness": load.stiffness,
        "following_time": load.following_time,
        "swing_time": load.swing_time,
        "touchdown_ratio": touchdown_ratio,
        **CONSTANTS,
    }


class Landing:
    """Where the unit is between hanging and standing.

    Parameters
    ----------
    parameters : shares of the weight at which it has landed, and hangs again
    load : on the cable
    """

    def __init__(self, parameters: TensionLawParameters, load: HangingLoad) -> None:
        self._parameters = parameters
        self.core = LandingWatch(landing_design(load, parameters.touchdown_ratio))  # design and state
        self._flags = self.core.flags

    def take_load(self, load: HangingLoad) -> None:
        """Judge another load, or another length of its cable, from now on."""
        self.core.take_design(landing_design(load, self._parameters.touchdown_ratio))

    @property
    def unit_stands(self) -> bool:
        """Tell whether the unit stands on the seabed."""
        return bool(self._flags[STANDS])

    @unit_stands.setter
    def unit_stands(self, stands: bool) -> None:
        self._flags[STANDS] = stands

    @property
    def share(self) -> float:
        """Share of the weight that the cable has carried then."""
        return float(self._flags[SHARE])

    @property
    def hangs(self) -> bool:
        """Tell whether the unit hangs, as far as is known."""
        return not (self._flags[STANDS] or self._flags[UNLOADED])

    @property
    def is_weighed(self) -> bool:
        """Tell whether there is a load cell to go by."""
        return bool(self._flags[WEIGHED])

    @property
    def event(self) -> Landed:
        """What has happened in the last tick."""
        return Landed(int(self._flags[EVENT]))

    def begin_hold(self) -> None:
        """Take a unit that does not hang, and whose tension is held on request, for one that has landed."""
        self._flags[STANDS] = not self.hangs
        self._flags[UNLOADED] = 0.0

    def begin_lift_off(self) -> None:
        """Expect a standing unit to be lifted off from now on."""
        self._flags[LIFTING] = 1.0
