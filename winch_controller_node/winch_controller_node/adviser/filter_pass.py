"""One pass of a linear filter over a record, for many versions of the record at once.

Covariance and gains of a linear Kalman filter do not depend on what was read, so that innovations are linear in the
readings: a column each for the record as it is, for what one sensor alone has read, for a step of it, goes through one
pass, and the innovations under any correction of the readings are a sum of columns.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import kernel
from numpy.typing import NDArray

from winch_controller_node.model.drag_kernel import DOUBT, DOUBT_TIME, Drag
from winch_controller_node.model.slack_kernel import Slack

SETTLING = 15.0
"""Time at the start of a record over which innovations are not judged [s]: the state is not known yet."""


@dataclass(frozen=True)
class PassModel:
    """A sampled model as a pass needs it.

    Attributes
    ----------
    F, B, Q : transition (n, n), input (n,), covariance of the process noise of a tick (n, n)
    start : covariance of the state at the start (n, n)
    rows : of each measurement on the state of its tick, and its first and second differences over ticks (3, k, n)
    drag, slack : of unit and cable, which go by the speed and the slack that were seen
    state_names : of the n states
    """

    F: Array
    B: Array
    Q: Array
    start: Array
    rows: Array
    drag: Drag
    slack: Slack
    state_names: tuple[str, ...]


@dataclass(frozen=True)
class PassInput:
    """A record in columns.

    Attributes
    ----------
    commands : in effect at each tick, (t, c)
    ends : where the readings of each tick end in the tables below, (t,)
    which : measurement of each reading (m,)
    offsets : how much later than its tick it was measured (m,) [ticks]
    variances : of its noise (m,)
    values : (m, c)
    unit_speed : absolute speed of the unit at each tick, by which its drag goes (t,) [m/s]
    missing_push : by how much a linear cable would push the unit more than it did, slack, at each tick (t,) [m]
    """

    commands: Array
    ends: NDArray[np.int64]
    which: NDArray[np.int64]
    offsets: Array
    variances: Array
    values: Array
    unit_speed: Array
    missing_push: Array

    def among(self, columns: NDArray[np.int64]) -> PassInput:
        """Return it with some of its `columns` only."""
        return replace(
            self,
            commands=np.ascontiguousarray(self.commands[:, columns]),
            values=np.ascontiguousarray(self.values[:, columns]),
        )


@dataclass(frozen=True)
class PassResult:
    """What a pass leaves.

    Attributes
    ----------
    innovations : of each reading in each column, over the standard deviation that the filter foresaw, (m, c)
    variances : that it foresaw (m,)
    state, covariance : at the end, (n, c) and (n, n)
    """

    innovations: Array
    variances: Array
    state: Array
    covariance: Array


def run_pass(model: PassModel, record: PassInput, used: NDArray[np.bool_]) -> PassResult:
    """Go through a `record` with a `model`.

    Parameters
    ----------
    model, record : see there
    used : which measurements the filter takes, (k,); of the others innovations are noted only
    """
    row, change, bend = (table[record.which] for table in model.rows)
    offset = record.offsets[:, None]
    rows = row + offset * change + 0.5 * offset * (offset - 1.0) * bend
    state = np.zeros((len(model.F), record.values.shape[1]))
    innovations, variances = np.empty_like(record.values), np.empty(len(record.values))
    covariance = model.start.copy()
    filled = [np.flatnonzero(row) for row in model.F]
    drag = model.drag
    excess = np.maximum(drag.quadratic * record.unit_speed - drag.damping, 0.0) / drag.inertia
    kept = np.exp(-0.5 * excess * drag.tick_period)
    slack, missing = model.slack, record.missing_push
    # beside the drag, which takes its share of the rate after it
    gives = np.where(missing > 0.0, missing / (missing + slack.largest), 0.0) * slack.tick_period / slack.inertia / kept
    unknown = (DOUBT * excess * record.unit_speed) ** 2 + (DOUBT * missing / slack.inertia) ** 2
    unknown *= DOUBT_TIME * drag.tick_period
    _follow(
        np.ascontiguousarray(model.F),
        np.concatenate(filled),
        np.cumsum([0, *(len(one) for one in filled)]),
        np.ascontiguousarray(model.B),
        np.ascontiguousarray(model.Q),
        state,
        covariance,
        drag.rate,
        kept,
        gives,
        np.ascontiguousarray(slack.pull),
        unknown,
        record.commands,
        record.ends,
        np.ascontiguousarray(rows),
        record.variances,
        used[record.which],
        record.values,
        innovations,
        variances,
    )
    return PassResult(innovations, variances, state, covariance)


@kernel
def _follow(
    F: Array,
    filled: NDArray[np.int64],
    begins: NDArray[np.int64],
    B: Array,
    Q: Array,
    x: Array,
    P: Array,
    rate: int,
    kept: Array,
    gives: Array,
    pull: Array,
    unknown: Array,
    commands: Array,
    ends: NDArray[np.int64],
    rows: Array,
    noise: Array,
    used: NDArray[np.bool_],
    values: Array,
    innovations: Array,
    variances: Array,
) -> None:
    """Kalman filter of one model, readings one after the other; x (n, c) and P (n, n) are changed in place.

    The unit's rate, state `rate`, keeps a share `kept` of itself in each half tick, with an `unknown` variance, and is
    not pushed by what a slack cable `gives` of its `pull`.
    `filled` has the columns of F that are not zero, of row i from begins[i] on: a chain of commands is nearly empty.
    """
    n, c = x.shape
    moved, half = np.empty_like(x), np.empty_like(P)
    across, left = np.empty(n), np.empty(c)
    first = 0
    for k in range(len(ends)):
        # drag takes a share of the unit's speed before and after the linear step, x = F x + B u, P = F P F' + Q
        x[rate] *= kept[k]
        P[rate] *= kept[k]
        P[:, rate] *= kept[k]
        for i in range(n):
            moved[i, :] = 0.0
            half[i, :] = 0.0
            for place in range(begins[i], begins[i + 1]):
                j = filled[place]
                f = F[i, j]
                for m in range(c):
                    moved[i, m] += f * x[j, m]
                for m in range(n):
                    half[i, m] += f * P[j, m]
            if B[i] != 0.0:
                for m in range(c):
                    moved[i, m] += B[i] * commands[k, m]
        if gives[k] > 0.0:
            # a slack cable does not push: the row of the unit's rate loses a share of the pull
            for j in range(n):
                if pull[j] != 0.0:
                    for m in range(c):
                        moved[rate, m] -= gives[k] * pull[j] * x[j, m]
                    for m in range(n):
                        half[rate, m] -= gives[k] * pull[j] * P[j, m]
        x[:, :] = moved
        for i in range(n):
            for m in range(i + 1):
                total = Q[i, m]
                for place in range(begins[m], begins[m + 1]):
                    total += half[i, filled[place]] * F[m, filled[place]]
                P[i, m] = total
                P[m, i] = total
        if gives[k] > 0.0:
            # those before it in the row have it already
            for i in range(rate, n):
                less = 0.0
                for j in range(n):
                    less += half[i, j] * pull[j]
                P[i, rate] -= gives[k] * less
                P[rate, i] = P[i, rate]
        x[rate] *= kept[k]
        P[rate] *= kept[k]
        P[:, rate] *= kept[k]
        P[rate, rate] += unknown[k]
        for m in range(first, ends[k]):
            # e = z - h x, S = h P h' + r
            spread = noise[m]
            left[:] = values[m]
            across[:] = 0.0
            for i in range(n):
                h = rows[m, i]
                if h != 0.0:
                    for j in range(n):
                        across[j] += h * P[i, j]
                    for j in range(c):
                        left[j] -= h * x[i, j]
            for i in range(n):
                spread += rows[m, i] * across[i]
            variances[m] = spread
            sigma = math.sqrt(spread)
            for j in range(c):
                innovations[m, j] = left[j] / sigma
            if not used[m]:
                continue
            # K = P h' / S, x = x + K e, P = P - K S K'
            for i in range(n):
                gain = across[i] / spread
                for j in range(c):
                    x[i, j] += gain * left[j]
                for j in range(n):
                    P[i, j] -= gain * across[j]
        first = ends[k]
