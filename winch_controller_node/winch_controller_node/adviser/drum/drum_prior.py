"""What a drum can be, and how far it may well be from the nominal one."""

from __future__ import annotations

import numpy as np
from heave_core.watch import NO_POWER_LIMIT, Drum
from heave_node.numerics.arrays import Array

from winch_controller_node.adviser.drum.drum_fit import DrumPrior
from winch_controller_node.adviser.drum.drum_record import FIELDS
from winch_controller_node.beliefs.drum import QUANTITY_OF, drum_of
from winch_controller_node.beliefs.quantities import ENCODER_SCALE, range_of
from winch_controller_node.node_parameters import WinchControllerParameters

SIGMAS = Drum(0.05, 0.1, 0.2, 0.02, np.inf, np.inf, np.inf, np.inf, 0.005, np.inf, 0.2, 0.05, np.inf)
"""Prior standard deviation of each quantity of the drum about nominal; infinite for limits, which are unknown."""

LEAST_POWER = 1.0
"""Least power limit of a winch [W]."""


def prior_of(parameters: WinchControllerParameters) -> DrumPrior:
    """Return the prior of a drum like that of the `parameters`: what can be is the range of each quantity."""
    nominal = drum_of(parameters.winch)
    ranges = {name: range_of(quantity, parameters) for name, quantity in QUANTITY_OF.items()}
    lowest = nominal._replace(**{name: lowest for name, (lowest, _) in ranges.items()})
    highest = nominal._replace(**{name: min(highest, NO_POWER_LIMIT) for name, (_, highest) in ranges.items()})
    lowest = lowest._replace(power=max(lowest.power, LEAST_POWER))
    factors = range_of(ENCODER_SCALE, parameters)
    return DrumPrior(
        _with_factor(nominal, 1.0),
        _with_factor(SIGMAS, np.inf),
        _with_factor(lowest, factors[0]),
        _with_factor(highest, factors[1]),
    )


def _with_factor(drum: Drum, factor: float) -> Array:
    vector = np.array([*drum, factor], dtype=float)
    assert vector.shape == (FIELDS + 1,)
    return vector
