"""The table of a pass: one linear filter over a record, in many versions of the record at once."""

from __future__ import annotations

from enum import IntEnum, IntFlag

from heave_core.filter_table import STATES
from heave_core.rows import COUNTER, Row, structure

PASS = structure(
    "Pass",
    "Model of a pass: n states, k measurements, c columns.",
    Row("states", "", "n", COUNTER),
    Row("measurements", "", "k", COUNTER),
    Row("columns", "", "c, versions of the record", COUNTER),
    Row("ticks", "", "of the record", COUNTER),
    Row("rate", "", "index of the unit's heave rate", COUNTER),
    Row("pad", "", "keeps the numbers aligned", COUNTER),
    Row("F", "", "transition of a tick, (n, n)", shape=(STATES * STATES,)),
    Row("B", "", "input of a tick, (n,)", shape=(STATES,)),
    Row("Q", "", "covariance of the process noise of a tick, (n, n)", shape=(STATES * STATES,)),
    Row("pull", "", "of the cable on the unit, as a row on the state (n,)", shape=(STATES,)),
)

PASS_TICK = structure(
    "PassTick",
    "What the record has seen of unit and cable at a tick, by which its step goes.",
    Row("kept", "", "share that drag leaves of the unit's speed in each half of the tick"),
    Row("gives", "", "share by which a slack cable does not push it"),
    Row("unknown", "m^2/s^2", "variance of its rate that both add"),
    Row("end", "", "where the readings of the tick end in the table"),
)

PASS_READING = structure(
    "PassReading",
    "A reading of the record, its values apart.",
    Row("which", "", "index of the measurement"),
    Row("offset", "", "how much later than its tick it was measured, in ticks"),
    Row("noise", "", "variance"),
    Row("used", "", "1: it is taken in; 0: judged alone"),
)

STRUCTURES = (PASS, PASS_TICK, PASS_READING)
"""In the order in which C++ needs them."""

RECORDS = STRUCTURES
"""What Python and C++ hold together."""

SIZES: dict[str, int] = {}
"""Sizes of arrays."""

ENUMERATIONS: tuple[type[IntEnum | IntFlag], ...] = ()
"""Names of numbers, and of bits."""
