"""The table of the proofs before the brake opens: MRU, count and braked drum, by nominal values and raw readings."""

from __future__ import annotations

from enum import IntEnum

from heave_core.rows import COUNTER, Row, Size, structure
from heave_core.watch_table import NOMINAL_LOAD_DESIGN, NOMINAL_LOAD_STATE

PROOF_TICKS = Size("PROOF_TICKS", 10240)
"""Most ticks of a record by which a proof is made: 20 s at 500 Hz."""

PROOF_READINGS = Size("PROOF_READINGS", 20480)
"""Most readings of a sensor in it: one may read more often than once a tick."""

FALL_TICKS = Size("FALL_TICKS", 640)
"""Most ticks over which the fall of the tension is looked at."""

WITNESSES = Size("WITNESSES", 2)
"""Sensors that the MRU is compared with: load cell, depth sensor."""


class Standing(IntEnum):
    """What is known of the MRU."""

    MRU_OPEN = 0
    MRU_QUIET = 1
    MRU_PROVED = 2
    MRU_SCALED = 3
    MRU_REVERSED = 4
    MRU_ALONE = 5


class ProofNews(IntEnum):
    """What is new in a tick."""

    COUNT_CONTRADICTS = 1
    LOAD_FALLS = 2
    DRUM_IS_HELD = 4
    DRUM_IS_NOT_HELD = 8
    MRU_CLOSED = 16
    CABLE_IS_LONGER = 32


PROOF_DESIGN = structure(
    "ProofDesign",
    "What the proofs go by: nominal values and constants.",
    Row("tick_period", "s", "time of a step"),
    Row("shortest", "s", "least record of a proof"),
    Row("looked_every", "s", "time from one look to the next"),
    Row("patience", "s", "after which a comparison that has proved nothing counts as no cross-check"),
    Row("quiet", "m", "standard deviation of the heave in which nothing can be proved"),
    Row("at_rest", "s", "after the brake was ordered from which on the drum counts as locked"),
    Row("low_pass", "s", "time constant of the low-pass of both sides of a comparison"),
    Row("certain", "", "slope over its standard error that a proof needs"),
    Row("alike", "", "correlation that a proof needs"),
    Row("least_scale", "", "least slope that proves an MRU"),
    Row("most_scale", "", "largest slope that does"),
    Row("softness", "", "plausible ones of the cable, over the nominal one", shape=(5,)),
    Row("refuted", "", "standard errors by which a slope lies outside of that where it says something"),
    Row("blend", "s", "time for which the MRU has read before its motion is known"),
    Row("unread", "s", "age of a reading from which on the motion is not known"),
    Row("largest_heave", "m", "beyond which a reading of the MRU is not taken"),
    Row("largest_rate", "m/s", "beyond which it is not"),
    Row("largest_load", "", "largest reading of the load cell that is used, over the static tension"),
    Row("length", "m", "of cable at a payout of 0"),
    Row("cable_length", "m", "of the cable that is described here"),
    Row("followed", "", "change of the length from which on another cable is taken, relative"),
    Row("stiffness", "N/m", "of the cable"),
    Row("static_tension", "N", "at the top at rest"),
    Row("frequency", "rad/s", "of the unit's free swing"),
    Row("off_course", "m", "difference of the count from its stated speed that is a contradiction"),
    Row("share_off", "", "the same, over the way"),
    Row("count_time", "s", "memory of that comparison"),
    Row("standing_speed", "m/s", "below which a drum stands"),
    Row("felt", "m", "wire paid out that the load cell has to show"),
    Row("fall_window", "s", "memory of how the tension falls without a cause"),
    Row("spreads", "", "standard deviations of such falls above which one is a motion"),
    Row("slack_share", "", "of the static tension below which a cable may go slack"),
    Row("slack_time", "s", "for which the load cell then says nothing"),
    Row("settled", "s", "under the brake from which on the load cell counts"),
    Row("held_time", "s", "after which is reported whether anything holds the drum"),
    Row("kept", "", "ticks of the record", COUNTER),
    Row("fall_ticks", "", "ticks within which the tension falls", COUNTER),
    Row("mru", "", "index of the MRU", COUNTER),
    Row("load_cell", "", "index of the load cell", COUNTER),
    Row("depth", "", "index of the depth sensor", COUNTER),
    Row("pad", "", "keeps the numbers aligned", COUNTER),
    Row("load", "", "the nominal unit under a locked drum", NOMINAL_LOAD_DESIGN),
)

WITNESS_RECORD = structure(
    "WitnessRecord",
    "Newest samples of a sensor, low-passed, in a ring.",
    Row("next", "", "place of the next one", COUNTER),
    Row("count", "", "that are held", COUNTER),
    Row("times", "s", "ascending", shape=(PROOF_READINGS,)),
    Row("values", "", "low-passed", shape=(PROOF_READINGS,)),
)

EXPECTED = structure(
    "Expected",
    "Newest ticks of the nominal load, in a ring.",
    Row("next", "", "place of the next one", COUNTER),
    Row("count", "", "that are held", COUNTER),
    Row("times", "s", "ascending", shape=(PROOF_TICKS,)),
    Row("heaves", "m", "of the boom tip", shape=(PROOF_TICKS,)),
    Row("values", "", "what each witness should read, low-passed", shape=(WITNESSES, PROOF_TICKS)),
)

BESIDE = Size("BESIDE", 4)
"""What a record may hold beside the motion: offset, trend, and a free swing of two phases."""

PROOF_WORK = structure(
    "ProofWork",
    "Room for a fit; nothing in it is remembered.",
    Row("beside", "", "offset, trend and free swing, made orthonormal", shape=(BESIDE, PROOF_TICKS)),
    Row("expected", "", "what a witness should have read", shape=(PROOF_TICKS,)),
    Row("read", "", "what it has read then", shape=(PROOF_TICKS,)),
)

PROOF_STATE = structure(
    "ProofState",
    "State of the proofs.",
    Row("standing", "", "of the MRU, of Standing", COUNTER),
    Row("told", "", "the same when it was last reported", COUNTER),
    Row("witness", "", "that the numbers are of; -1: none", COUNTER),
    Row("consent", "", "1: an operator has compensation begin without a cross-check", COUNTER),
    Row("is_falling", "", "1: the braked load was felt to fall, and nobody has acknowledged it", COUNTER),
    Row("falls", "", "ticks in a row in which the tension has fallen", COUNTER),
    Row("has_rate", "", "1: the drive states a speed", COUNTER),
    Row("pad", "", "keeps the numbers aligned", COUNTER),
    Row("scale", "", "slope of reading on expectation"),
    Row("correlation", "", "of both without offset, trend and free swing"),
    Row("certainty", "", "slope over its standard error"),
    Row("waited", "s", "time of records so far"),
    Row("next_look", "s", "time until the next look"),
    Row("braked_time", "s", "for which the brake has been ordered"),
    Row("watched_time", "s", "for which the braked drum has been watched"),
    Row("since", "s", "time since a motion under the brake was found; NaN: none was"),
    Row("count", "m", "of the drum; NaN: not read in the last tick"),
    Row("begin", "m", "count when the brake was ordered; NaN: none read"),
    Row("moved", "m", "count since then"),
    Row("moved_rate", "m/s", "speed of that"),
    Row("fall", "N", "of the tension within the time of a fall"),
    Row("square", "N^2", "mean square of falls without a cause"),
    Row("seen", "s", "time over which that is known"),
    Row("slack", "s", "time for which the load cell says nothing"),
    Row("had_mru", "", "has_mru of the last tick"),
    Row("drive_time", "s", "time of the last report of the drive, by its clock; NaN: none"),
    Row("drive_count", "m", "count in it"),
    Row("drive_rate", "m/s", "speed that it stated"),
    Row("error", "m", "count less the way of its stated speed"),
    Row("way", "m", "that it has turned of late"),
    Row("found_error", "m", "error at the last contradiction"),
    Row("rest_count", "", "ticks of the next that are held"),
    Row("rest", "N", "tension less what the nominal load makes of it, newest last", shape=(FALL_TICKS,)),
    Row("load", "", "the nominal unit under a locked drum", NOMINAL_LOAD_STATE),
    Row("expected", "", "what the witnesses should read", EXPECTED),
    Row("read", "", "what they have read", WITNESS_RECORD, (WITNESSES,)),
)
