"""What the depth sensor has seen of the payout that the encoder reads.

The unit moves by what the boom tip does to it, by what the drum does to it, and freely, by how it swung before.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import kernel
from heave_node.numerics.newest import Newest

from winch_controller_node.model.blocks import CableModel
from winch_controller_node.model.models import shadow_model

WINDOWS = (4.0, 6.0, 8.0)
"""Times over which they are compared [s]: a wave, and less where that is enough."""

LONGEST_GAP = 0.25
"""Time without the encoder that a record goes on over [s], as if the drum stood: a jump that is taken off is one."""

LONGEST_SLACK, NO_SLACK = 1.0, 5.0
"""Time for which the cable may be slack [s]: what the drum does reaches the unit later, and as a shock. For longer than
the second no unit falls: the load cell is wrong.
"""

LEAST_READINGS = 12
"""Of the depth sensor within each of them."""

CORRELATED = 4.0
"""Residuals in a row that count as one: they are not white."""

RIDGE = 1e-10
"""What has not moved at all is known this badly, over all terms: no inverse is singular."""


class Seen(NamedTuple):
    """What the depth sensor sees of the payout that the encoder reads.

    Attributes
    ----------
    share, sigma : times as much, and its standard deviation
    left : standard deviation of the rest over that of all that was to be explained
    payout : that the unit shows now [m], less the mean depth
    unit : heave [m] and rate [m/s] of the unit now, shape (2,), less the mean depth
    """

    share: float
    sigma: float
    left: float
    payout: float
    unit: Array


class DepthWitness:
    """What the depth sensor sees of what the encoder reads, the boom tip being right.

    How the unit swung when the comparison begins is not known: the encoder may have been wrong before.

    Parameters
    ----------
    cable : that the unit hangs on
    tick_period : [s]
    """

    def __init__(self, cable: CableModel, tick_period: float) -> None:
        self._dt = tick_period
        self._count = round(max(WINDOWS) / tick_period)
        self._payouts = Newest(self._count + 1)
        self._boom_tip: deque[Array] = deque(maxlen=self._count + 1)
        self._depths: deque[tuple[float, float]] = deque(maxlen=self._count)
        self._tick = self._missing = self._slack = 0
        self.take_cable(cable)

    def take_cable(self, cable: CableModel) -> None:
        """Go on with another `cable`."""
        model = shadow_model(cable, self._dt)
        self._A, self._B = np.ascontiguousarray(model.A), np.ascontiguousarray(model.B)
        self._participation = cable.participation
        still = np.zeros((self._count + 1, 2))
        self._free = [self._unit(still, state) for state in np.eye(2)]

    def restart(self) -> None:
        """Begin a new record."""
        for record in (self._payouts, self._boom_tip, self._depths):
            record.clear()

    def add(
        self,
        tick: int,
        payout: float | None,
        boom_tip: Array,
        depths: Sequence[tuple[float, float]],
        *,
        is_slack: bool = False,
    ) -> None:
        """Take a tick in.

        Parameters
        ----------
        tick : its number
        payout : encoder reading [m]; None: none
        boom_tip : its heave [m] and heave rate [m/s], shape (2,)
        depths : stamps [s] and depths [m] of the readings that came
        is_slack : the cable is
        """
        self._tick = tick
        self._slack = self._slack + 1 if is_slack else 0
        if LONGEST_SLACK < self._slack * self._dt < NO_SLACK:
            self.restart()
        self._missing = self._missing + 1 if payout is None else 0
        if payout is None:
            if not len(self._payouts) or self._missing * self._dt > LONGEST_GAP:
                self.restart()
                return
            payout = float(self._payouts.last(1)[0])
        self._payouts.append(payout)
        self._boom_tip.append(boom_tip)
        self._depths.extend(depths)

    def seen(self) -> list[Seen | None]:
        """Return what it sees over each window; None: too little is known."""
        count = len(self._payouts) - 1
        if count * self._dt < min(WINDOWS):
            return [None for _ in WINDOWS]
        first, grid = self._tick - count, np.arange(count + 1)
        read = np.array([pair for pair in self._depths if pair[0] >= first * self._dt]).reshape(-1, 2)
        places = read[:, 0] / self._dt - first
        # about a unit from rest: how it swung, and what is not linear with the winch locked, is not in it
        by_boom_tip = self._unit(np.array(self._boom_tip), np.zeros(2))
        unit = -read[:, 1] - np.interp(places, grid, by_boom_tip[:, 0])
        states = np.stack([self._by_drum(), *(free[: count + 1] for free in self._free)], axis=2)
        terms = np.column_stack([*(np.interp(places, grid, states[:, 0, i]) for i in range(3)), np.ones(len(places))])
        now = (states[-1], by_boom_tip[-1])
        return [
            self._fitted(terms[late], unit[late], *now) if count >= ticks else None
            for ticks in (round(window / self._dt) for window in WINDOWS)
            for late in [places >= count - ticks]
        ]

    def _unit(self, motion: Array, start: Array) -> Array:
        """Return heave [m] and rate [m/s] of a unit below a boom tip in `motion`, shape (ticks, 2).

        Its first mode begins at `start`, see `driven_unit`.
        """
        mode = driven_unit(self._A, self._B, motion, start)
        return np.asarray(self._participation * mode + (1.0 - self._participation) * motion)

    def _by_drum(self) -> Array:
        """Return heave [m] and rate [m/s] of a unit from rest that only the drum moves, shape (ticks, 2)."""
        payouts = self._payouts.last()
        boom_tip = -np.column_stack([payouts - payouts[0], np.gradient(payouts, self._dt)])
        return self._unit(boom_tip, np.zeros(2))

    def _fitted(self, terms: Array, unit: Array, now: Array, by_boom_tip: Array) -> Seen | None:
        """Return what is seen over a window; None: there are too few readings.

        Parameters
        ----------
        terms : heave by the drum, of the two free swings, and 1, at each reading, shape (readings, 4)
        unit : heave that they have to explain, shape (readings,) [m]
        now : heave and rate by drum and free swings at the end, shape (2, 3) [m], [m/s]
        by_boom_tip : and by the boom tip, shape (2,)
        """
        if len(unit) < LEAST_READINGS:
            return None
        weights, sigma, left = _least_squares(terms, unit)
        share, mean, payouts = float(weights[0]), float(weights[3]), self._payouts.last()
        payout = share * float(payouts[-1] - payouts[0]) - mean
        return Seen(share, sigma, left, payout, by_boom_tip + now @ weights[:3] + [mean, 0.0])


def _least_squares(terms: Array, values: Array) -> tuple[Array, float, float]:
    """Return the weights of `terms`, shape (count, n), the last of them constant, that explain `values`.

    With them come the standard deviation of the first, and the share of the values' that is left.
    """
    information = terms.T @ terms
    inverse = np.linalg.inv(information + RIDGE * np.trace(information) * np.eye(len(information)))
    weights = inverse @ (terms.T @ values)
    left, about = values - terms @ weights, values - values.mean()
    squares, all_squares = float(left @ left), max(float(about @ about), 1e-12)
    variance = CORRELATED * squares / max(len(values) - len(weights), 1)
    return weights, math.sqrt(variance * inverse[0, 0]), math.sqrt(squares / max(all_squares, squares))


@kernel
def driven_unit(A: Array, B: Array, motion: Array, start: Array) -> Array:
    """Return heave and rate of the first mode of the unit at each tick, shape (count, 2) [m], [m/s].

    Parameters
    ----------
    A, B : of `shadow_model`, shape (2, 2)
    motion : heave and rate of the boom tip at each tick, shape (count, 2) [m], [m/s]
    start : heave and rate at the first, shape (2,)
    """
    states = np.empty((len(motion), 2))
    states[0] = start
    for k in range(len(motion) - 1):
        for i in range(2):
            states[k + 1, i] = (
                A[i, 0] * states[k, 0] + A[i, 1] * states[k, 1] + B[i, 0] * motion[k, 0] + B[i, 1] * motion[k, 1]
            )
    return states
