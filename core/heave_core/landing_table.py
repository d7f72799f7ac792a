"""The table of landing: trends of depth, tension and payout, and where the unit is between hanging and standing."""

from __future__ import annotations

from enum import IntEnum

from heave_core.rows import COUNTER, Row, structure

REMEMBERED = 4096
"""Readings of a trend that are kept."""

WINDOWS = 3
"""Windows that are looked at, longer ones for noisier sensors."""


class Landed(IntEnum):
    """What has just happened to the unit."""

    NOT = 0
    TOUCHDOWN = 1
    LIFTED_OFF = 2


TREND = structure(
    "Trend",
    "The newest readings, in the order of their times.",
    Row("count", "", "readings that are kept", COUNTER),
    Row("next", "", "place of the next one", COUNTER),
    Row("changed", "s", "time of the last one that was another than the one before"),
    Row("times", "s", "of the readings", shape=(REMEMBERED,)),
    Row("values", "", "read", shape=(REMEMBERED,)),
)

LANDING_DESIGN = structure(
    "LandingDesign",
    "The load on its cable, and what shows that it has landed.",
    Row("static_tension", "N", "at the top while the unit hangs under water"),
    Row("weight", "N", "of the unit in water"),
    Row("stiffness", "N/m", "of the cable"),
    Row("following_time", "s", "that a hanging unit needs to follow the winch"),
    Row("swing_time", "s", "of a free swing or a wave, whichever is longer"),
    Row("touchdown_ratio", "", "share of the weight below which the unit has landed: `tension.touchdown_ratio`"),
    Row("lowered", "m", "distance that the winch lowers within a window"),
    Row("shortest", "s", "least length of a window"),
    Row("longest", "s", "largest length of a window"),
    Row("windows", "", "that are looked at, over that", shape=(WINDOWS,)),
    Row("least_readings", "", "that a slope needs"),
    Row("filled", "", "share of a window that the readings must span"),
    Row("least_rate", "m/s", "above which the winch lowers"),
    Row("steady_share", "", "of the speed now that a steady one has had over a window at least"),
    Row("standing_share", "", "of the speed of lowering at which a unit that stands moves at most"),
    Row("relief_share", "", "of what the stiffness makes of the lowering that a relieved cable loses at least"),
    Row("certain", "", "standard errors by which a trend must be more than nothing"),
    Row("innovation_above", "", "standard deviations by which a landed unit is read above a hanging one"),
    Row("unconfirmed_time", "", "longest time of an unconfirmed touchdown, in windows"),
    Row("pause", "", "time after one until the next such, over that time"),
)

LANDING_STATE = structure(
    "LandingState",
    "Where the unit is, and what was read.",
    Row("unit_stands", "", "1: on the seabed"),
    Row("may_stand", "", "1: it may just have landed"),
    Row("is_unloaded", "", "1: the winch is braked over a cable that does not carry the unit, on average"),
    Row("is_lifting", "", "1: a standing unit is to be lifted off"),
    Row("share", "", "of the weight that the cable has carried under the brake"),
    Row("lowering_rate", "m/s", "at which the winch lowers; 0 before that is known"),
    Row("may_stand_since", "s", "time of the last unconfirmed touchdown"),
    Row("event", "", "Landed: in this tick"),
    Row("depth", "m", "read, positive down", TREND),
    Row("hanging", "m", "depth of a unit that only hangs on its cable", TREND),
    Row("tension", "N", "at the top", TREND),
    Row("payout", "m", "mean one of the drum", TREND),
    Row("innovation", "", "of the depth sensor, over its standard deviation", TREND),
    Row("hanging_share", "", "of the weight that the cable of a hanging unit carries", TREND),
)

LANDING_SEEN = structure(
    "LandingSeen",
    "What is known at a tick.",
    Row("time", "s", "of the tick"),
    Row("tension", "N", "at the top; NaN: none was read"),
    Row("is_weighed", "", "1: the load cell is not lost"),
    Row("mean_payout", "m", "of the drum"),
    Row("hanging_depth", "m", "of a unit that only hangs on its cable, about that at rest"),
    Row("hanging_stretch", "m", "of its cable"),
    Row("innovation", "", "of the depth sensor, over its standard deviation; NaN: none"),
    Row("filtered_tension", "N", "low-passed"),
    Row("sees_landing", "", "1: there is a depth sensor, and it is neither lost nor excluded"),
    Row("has_depths", "", "1: a depth has been read in this tick"),
    Row("compensates", "", "1: the winch follows the mean payout"),
)

STRUCTURES = (TREND, LANDING_DESIGN, LANDING_STATE, LANDING_SEEN)
"""In the order in which C++ needs them."""

RECORDS = STRUCTURES
"""What Python and C++ hold together."""

ENUMERATIONS = (Landed,)
"""Names of numbers."""

SIZES = {"REMEMBERED": REMEMBERED, "WINDOWS": WINDOWS}
"""Sizes of arrays."""
