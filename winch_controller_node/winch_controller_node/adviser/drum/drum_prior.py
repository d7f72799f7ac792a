"""What a drum can be, and how far it may well be from the nominal one."""

from __future__ import annotations

import numpy as np
from heave_node.numerics.arrays import Array

from winch_controller_node.adviser.drum.drum_fit import DrumPrior
from winch_controller_node.adviser.drum.drum_record import FIELDS
from winch_controller_node.beliefs.drum import drum_of
from winch_controller_node.model.drum_kernel import Drum
from winch_controller_node.parameters.model import WinchModelParameters

SIGMAS = Drum(0.05, 0.1, 0.2, 0.02, np.inf, np.inf, np.inf, np.inf, 0.005, np.inf, 0.2, 0.05, np.inf)
"""Prior standard deviation of each quantity of the drum about nominal; infinite for limits, which are unknown."""

SMALLEST_LAG, LARGEST_LAG = 0.005, 2.0
"""Least time constant of a servo, and the most that it is above the nominal one [s]."""

GAINS, LARGEST_DEADBAND, LARGEST_BACKLASH, LOWEST_LIMIT = (0.25, 4.0), 0.2, 0.2, 0.05
"""Range of a drum: gain [-], dead zone [m/s], play [m], limits over the nominal ones [-]."""

LARGEST_UNEVENNESS, LARGEST_CREEP = 2.0, 0.2
"""Largest factor between the gains of paying out and hauling in [-], and creep beyond the nominal one [m/s]."""

LEAST_POWER = 1.0
"""Least power limit of a winch [W]."""

LARGEST_FACTOR = 5.0
"""Largest factor of an encoder's scale, either way [-]."""


def prior_of(winch: WinchModelParameters, largest: float) -> DrumPrior:
    """Return the prior of a drum like the nominal `winch`; its delay differs by `largest` [s] at most."""
    nominal = drum_of(winch)
    limits = ("speed_out", "speed_in", "acceleration_out", "acceleration_in")
    lowest = nominal._replace(
        lag=SMALLEST_LAG,
        delay=max(nominal.delay - largest, 0.0),
        gain=GAINS[0],
        hauling=nominal.hauling / LARGEST_UNEVENNESS,
        creep=nominal.creep - LARGEST_CREEP,
        power=LEAST_POWER,
        **{name: LOWEST_LIMIT * getattr(nominal, name) for name in limits},
    )
    highest = nominal._replace(
        lag=nominal.lag + LARGEST_LAG,
        delay=nominal.delay + largest,
        gain=GAINS[1],
        deadband=LARGEST_DEADBAND,
        backlash=LARGEST_BACKLASH,
        hauling=nominal.hauling * LARGEST_UNEVENNESS,
        creep=nominal.creep + LARGEST_CREEP,
    )
    return DrumPrior(
        _with_factor(nominal, 1.0),
        _with_factor(SIGMAS, np.inf),
        _with_factor(lowest, -LARGEST_FACTOR),
        _with_factor(highest, LARGEST_FACTOR),
    )


def _with_factor(drum: Drum, factor: float) -> Array:
    vector = np.array([*drum, factor], dtype=float)
    assert vector.shape == (FIELDS + 1,)
    return vector
