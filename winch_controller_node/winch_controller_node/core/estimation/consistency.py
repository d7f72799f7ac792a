"""Consistency of the readings: whether they are as far off their prediction as their noise allows.

Means of the normalised innovations squared are made in C++ (`heave_core`, watches.cpp).
"""

from __future__ import annotations

import math

MEMORY = 20.0
"""Memory of the mean of the normalised innovations squared [s]."""

INCONSISTENT = 2.0
"""Mean of the normalised innovations squared above which a sensor is inconsistent with its model; 1 is consistent."""

QUIET, QUIET_TIME = 0.4, 60.0
"""Mean of the normalised innovations squared below which a sensor is quieter than nominal, and time until that is
reported [s]."""

UNEXPLAINED_TIME = 90.0
"""Time after which readings that are inconsistent without a pause count as unexplained [s]: the adviser judges a
minute, accepts an explanation after 10 s more, and a new assumption begins the count again."""

LARGEST = 25.0
"""Largest weight of one normalised innovation squared: a spike is no lasting error."""

ENCODER_ROW = "payout"
"""Readings of the encoder are not judged: the winch is identified by them."""


def inconsistency_words(name: str, mean: float) -> str:
    """Return why readings are not consistent yet: the measurement `name` has the largest `mean` squared innovation."""
    wait = MEMORY * math.log((mean - 1.0) / (INCONSISTENT - 1.0))
    return (
        f"innovations of {name} are {math.sqrt(mean):.1f} times their expected size, limit "
        f"{math.sqrt(INCONSISTENT):.1f}: about {wait:.0f} s more to settle; the sensors are compared meanwhile"
    )
