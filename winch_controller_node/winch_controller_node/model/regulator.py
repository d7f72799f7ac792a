"""The regulator of the augmented model: its quadratic cost from the weights, and gains for all of its states.

States that belong to a sensor alone (high-pass, scale, bias) are moved by no command and have no gain.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel

from winch_controller_node.interface.sensors import KNOWN_SENSORS, LEVER_ARM_X, LEVER_ARM_Y
from winch_controller_node.model.lqr import QuadraticCost, lqr_gain, output_cost
from winch_controller_node.parameters.model import WeightParameters

_SENSOR_STATES = (*(f"{sensor}_" for sensor in KNOWN_SENSORS), LEVER_ARM_X, LEVER_ARM_Y)
"""Prefixes of the names of sensors' own states."""


def is_sensor_state(name: str) -> bool:
    """Return whether the state `name` belongs to a sensor alone, so that no control can or need act on it."""
    return name.startswith(_SENSOR_STATES)


def is_sea_state(name: str) -> bool:
    """Return whether the state `name` is one of waves and vessel, which grow with the sea."""
    return name.startswith(("vessel_", "wave_"))


def weighted_cost(weights: WeightParameters, model: LinearModel) -> QuadraticCost:
    """Return the quadratic cost of `weights` on the augmented model.

    Raises DesignError for weights that leave the cost singular.
    """
    sizes = {
        "unit_heave": weights.unit_heave,
        "unit_heave_rate": weights.unit_heave_rate,
        "outlet_heave": weights.outlet_heave,
        "payout": weights.payout,
        "payout_rate": weights.payout_rate,
        "payout_acceleration": acceleration_size(model, weights.payout_acceleration),
    }
    return output_cost(model, sizes, weights.command)


def acceleration_size(model: LinearModel, size: float) -> float:
    """Return the scale of the payout's acceleration in a cost, `size` [m/s^2] for a slow servo; 0 leaves it out.

    The model gives the acceleration at the start of a tick. A servo with a lag T shorter than the tick has gained its
    speed long before the end: that is dt/T times what the drum gains over the tick, and its scale grows with it. A
    winch of first order has no acceleration.
    """
    if "payout_acceleration" not in model.output_names:
        return 0.0
    per_lag = -float(model.row("payout_acceleration")[model.state("payout_rate")])
    return size if model.dt is None else size * max(1.0, per_lag * model.dt)


def full_gain(model: LinearModel, cost: QuadraticCost) -> Array:
    """Return the LQR gain over all states of `model` that minimises `cost`, shape (n,); those of sensors have none.

    Raises DesignError where there is no stabilising gain, see `lqr.lqr_gain`.
    """
    keep = [i for i, name in enumerate(model.state_names) if not is_sensor_state(name)]
    plant = model.select_states([model.state_names[i] for i in keep])
    reduced = QuadraticCost(cost.Q[np.ix_(keep, keep)], cost.N[keep], cost.R)
    gain = np.zeros(model.order)
    gain[keep] = lqr_gain(plant, reduced)[0]
    return gain


def unit_regulator_gain(weights: WeightParameters, model: LinearModel) -> Array:
    """Return the gain of the regulator of unit, winch and delay under `weights` (thesis 6.2.4, 6.2.5), shape (n,).

    The outlet has no weight in it: without a boom tip to follow, that would hold the payout where it is. Nothing but
    the unit's own motion then asks for a command, so that it is weighed as in the thesis, by itself. `model` is the
    whole one, sampled.

    Raises DesignError where there is no stabilising gain.
    """
    gain = full_gain(model, weighted_cost(replace(weights, outlet_heave=0.0), model))
    return np.where([is_sea_state(name) for name in model.state_names], 0.0, gain)
