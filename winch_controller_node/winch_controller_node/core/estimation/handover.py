"""Handing the loop over to compensation where the unit is: the present depth becomes the mean, nothing else changes.

Payout P = mean + p and unit X = -mean + x stay what they are when the mean goes down by d: p' = p - d, x' = x + d. The
pull x0 - p - x of the cable stays too, so that no law sees a step. A unit that has just been lifted off stood still:
the estimate of a hanging unit means nothing then, and restarts from what the load cell says of the pull.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel

from winch_controller_node.interface.sensors import DEPTH_BIAS
from winch_controller_node.model.estimator import begin_anew

PULL_SIGMA = 0.1
"""Standard deviation of the cable's pull [m] on a unit that was just lifted off: 5 % of a weight on a long cable."""

STANDING_SIGMA = 0.01
"""Standard deviation of the rate of such a unit [m/s]: it stood."""

SEEN_SIGMA = 0.05
"""Standard deviation of payout [m], heave [m] and rates [m/s] of drum and unit, seen by the depth sensor for a wave."""


@dataclass(frozen=True, eq=False)
class Handover:
    """How the loop goes on."""

    estimate: Array  # shape (n,)
    covariance: Array  # shape (n, n)
    mean_state: Array  # the mean payout's own motion, shape (n,)
    lowered: float  # how much the mean payout becomes larger [m]


def hand_over(model: LinearModel, estimate: Array, covariance: Array, mean_state: Array) -> Handover:
    """Return the loop with the unit's present heave as the mean.

    Parameters
    ----------
    model : of the loop
    estimate, covariance : shape (n,), (n, n)
    mean_state : the mean payout's own motion, shape (n,)
    """
    payout, unit = model.state("payout"), model.state("unit_heave")
    lowered = -float(estimate[unit] + mean_state[unit] + mean_state[payout])
    estimate, mean_state = estimate.copy(), mean_state.copy()
    estimate[payout] -= lowered
    estimate[unit] += lowered
    mean_state[payout] += lowered
    mean_state[unit] -= lowered
    return Handover(estimate, covariance, mean_state, lowered)


def followed(model: LinearModel, mean_state: Array) -> Array:
    """Return the mean payout's own motion in the states of a `model` where the unit has followed it: no swing is left.

    `mean_state` : that motion now; both of shape (n,)
    """
    mean_state = mean_state.copy()
    mean_state[model.state("unit_heave")] = -mean_state[model.state("payout")]
    mean_state[model.state("unit_heave_rate")] = -float(model.row("payout_rate") @ mean_state)
    return mean_state


def hand_over_standing(
    model: LinearModel, estimate: Array, covariance: Array, mean_state: Array, *, pull: float, heave: float
) -> Handover:
    """Return the loop with a unit that stood until now as the mean.

    Parameters
    ----------
    model, estimate, covariance, mean_state : as for `hand_over`
    pull : measured tension over the static one, over the stiffness: x0 - p - x [m]
    heave : newest heave from the depth sensor, about that of a unit that has `followed` the mean payout [m]
    """
    payout, unit, rate = model.state("payout"), model.state("unit_heave"), model.state("unit_heave_rate")
    estimate, covariance, mean_state = estimate.copy(), covariance.copy(), followed(model, mean_state)
    estimate[unit] = float(model.row("boom_tip_heave") @ estimate) - estimate[payout] - pull
    estimate[rate] = 0.0
    loose = [(unit, PULL_SIGMA), (rate, STANDING_SIGMA)]
    if model.has_state(DEPTH_BIAS):
        bias = model.state(DEPTH_BIAS)
        estimate[bias] = heave - estimate[unit]
        loose.append((bias, PULL_SIGMA))
    for index, sigma in loose:
        begin_anew(covariance, index, sigma)
    if model.has_state(DEPTH_BIAS):
        # the depth sensor knows their sum
        covariance[unit, bias] = covariance[bias, unit] = -(1.0 - 1e-3) * PULL_SIGMA**2
    return hand_over(model, np.asarray(estimate), covariance, mean_state)


def hand_over_seen(
    model: LinearModel, estimate: Array, covariance: Array, *, payout: float, unit: Array
) -> tuple[Array, Array]:
    """Return estimate and covariance of a loop whose drum and unit are elsewhere than the encoder had it.

    Parameters
    ----------
    model, estimate, covariance : as for `hand_over`
    payout : that is out, without the mean payout [m]
    unit : its heave [m] and rate [m/s], without those that the mean payout brings about, shape (2,)
    """
    estimate, covariance = estimate.copy(), covariance.copy()
    known = {"payout": payout, "unit_heave": float(unit[0]), "unit_heave_rate": float(unit[1])}
    for name in (*known, "payout_rate"):
        if model.has_state(name):
            index = model.state(name)
            estimate[index] = known.get(name, estimate[index])
            begin_anew(covariance, index, SEEN_SIGMA)
    return estimate, covariance
