"""A slack cable in a step of a linear model, compiled: it lets the unit sink, and does not push it.

A boom tip that sinks faster than the unit leaves the cable slack at its lower end. The unit then goes down by its
weight in water alone, and the spring of the model, which would push it, has to give way to that: at the pull of the
tick its stiffness is what leaves the weight (secant, as for quadratic drag). Near a resonance a high sea does that
several times a minute.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import kernel

from winch_controller_node.model.drag_kernel import UNCERTAINTY, UNCERTAINTY_TIME


class Slack(NamedTuple):
    """When the cable is slack.

    Attributes
    ----------
    pull : of the cable on the unit about that at rest, as a row on the state, in metres of boom tip (n,)
    reads : sensitivity of each measurement to that pull, in its unit over metres (m,)
    rate : index of the unit's heave rate in the state
    inertia : of the cable model [s^2]
    largest : pull downwards at which the cable is slack, the weight of the unit in water over the stiffness [m]
    tick_period : [s]
    power : 2, see `drag_kernel.Drag`
    """

    pull: Array
    reads: Array
    rate: int = 0
    inertia: float = 1.0
    largest: float = math.inf
    tick_period: float = 0.0
    power: float = 2.0


def no_slack(order: int, measurements: int) -> Slack:
    """Return that of a cable that always pulls, for a state of an `order` and a number of `measurements`."""
    return Slack(np.zeros(order), np.zeros(measurements))


@kernel
def missing_push(slack: Slack, x: Array) -> float:
    """Return by how much the model pushes the unit down at a state x (n,), which no `slack` cable does [m]."""
    return max(-float(np.dot(slack.pull, x)) - slack.largest, 0.0)


@kernel
def with_slack(slack: Slack, x: Array, F: Array, Q: Array) -> tuple[Array, Array]:
    """Return F and noise Q, both (n, n), of a step from a state x (n,) in which the cable may be `slack`."""
    missing = missing_push(slack, x)
    if missing == 0.0:
        return F, Q
    F, Q = F.copy(), Q.copy()
    F[slack.rate] -= missing / (missing + slack.largest) * slack.tick_period / slack.inertia * slack.pull
    Q[slack.rate, slack.rate] += (
        (UNCERTAINTY * missing / slack.inertia) ** slack.power * UNCERTAINTY_TIME * slack.tick_period
    )
    return F, Q


@kernel
def slack_variance(slack: Slack, x: Array, which: int) -> float:
    """Return the variance that a reading of measurement `which` has besides its noise at a state x (n,).

    The stretch says nothing about the pull of a slack cable: it errs by as much as the cable is slack.
    """
    return float((slack.reads[which] * missing_push(slack, x)) ** slack.power)
