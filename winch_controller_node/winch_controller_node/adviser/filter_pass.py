"""One pass of a linear filter over a record, for many versions of the record at once.

Covariance and gains of a linear Kalman filter do not depend on what was read, so that innovations are linear in the
readings: a column each for the record as it is, for what one sensor alone has read, for a step of it, goes through one
pass, and the innovations under any correction of the readings are a sum of columns.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from heave_core.filter import UNCERTAINTY, UNCERTAINTY_TIME, Drag, Slack
from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import kernel, part_of_kernel
from numpy.typing import NDArray

SETTLING = 15.0
"""Time at the start of a record over which innovations are not judged [s]: the state is not known yet."""

STOPPED = 30.0
"""Exponent of drag that leaves nothing of a speed."""


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


class Motion(NamedTuple):
    """How the state moves, tick by tick.

    Attributes
    ----------
    F, B, Q : of the model
    filled, begins : columns of F that are not zero, of row i from begins[i] on: most of it is empty
    rate : index of the unit's heave rate
    kept : share that drag leaves of it in each half tick (t,)
    gives : share by which a slack cable does not push it (t,)
    pull : of the cable on the unit, as a row on the state (n,)
    unknown : variance of it that both add (t,)
    """

    F: Array
    B: Array
    Q: Array
    filled: NDArray[np.int64]
    begins: NDArray[np.int64]
    rate: int
    kept: Array
    gives: Array
    pull: Array
    unknown: Array


class Reads(NamedTuple):
    """What is read.

    Attributes
    ----------
    ends : where the readings of each tick end (t,)
    rows, noise : of each reading, on the state (m, n), and its variance (m,)
    used : it is taken (m,)
    values : (m, c)
    """

    ends: NDArray[np.int64]
    rows: Array
    noise: Array
    used: NDArray[np.bool_]
    values: Array


def run_pass(model: PassModel, record: PassInput, used: NDArray[np.bool_]) -> PassResult:
    """Go through a `record` with a `model`.

    Parameters
    ----------
    model, record : see there
    used : which measurements the filter takes, (k,); of the others innovations are noted only
    """
    row, change, bend = (table[record.which] for table in model.rows)
    offset = record.offsets[:, None]
    rows = np.ascontiguousarray(row + offset * change + 0.5 * offset * (offset - 1.0) * bend)
    reads = Reads(record.ends, rows, record.variances, used[record.which], record.values)
    state = np.zeros((len(model.F), record.values.shape[1]))
    covariance = model.start.copy()
    innovations, variances = _follow(_motion(model, record), reads, record.commands, state, covariance)
    return PassResult(innovations, variances, state, covariance)


def _motion(model: PassModel, record: PassInput) -> Motion:
    """Return how the state of a `model` moves at the speed and the slack that a `record` has seen."""
    drag, slack, missing = model.drag, model.slack, record.missing_push
    excess = np.maximum(drag.quadratic * record.unit_speed - drag.damping, 0.0) / drag.inertia
    unknown = (UNCERTAINTY * excess * record.unit_speed) ** 2 + (UNCERTAINTY * missing / slack.inertia) ** 2
    filled = [np.flatnonzero(row) for row in model.F]
    kept = np.exp(-np.minimum(0.5 * excess * drag.tick_period, STOPPED))
    gives = np.where(missing > 0.0, missing / (missing + slack.largest), 0.0) * slack.tick_period / slack.inertia
    return Motion(
        F=np.ascontiguousarray(model.F),
        B=np.ascontiguousarray(model.B),
        Q=np.ascontiguousarray(model.Q),
        filled=np.concatenate(filled),
        begins=np.cumsum([0, *(len(one) for one in filled)]),
        rate=drag.rate,
        kept=kept,
        # beside the drag, which takes its share of the rate after it
        gives=gives / kept,
        pull=np.ascontiguousarray(slack.pull),
        unknown=unknown * UNCERTAINTY_TIME * drag.tick_period,
    )


@part_of_kernel
def _move(motion: Motion, k: int, x: Array, moved: Array) -> None:
    """Put F x a tick on, with slack, into `moved`, both (n, c)."""
    n, c = x.shape
    for i in range(n):
        for m in range(c):
            moved[i, m] = 0.0
        for place in range(motion.begins[i], motion.begins[i + 1]):
            j = motion.filled[place]
            for m in range(c):
                moved[i, m] += motion.F[i, j] * x[j, m]
    if motion.gives[k] > 0.0:
        for j in range(n):
            if motion.pull[j] != 0.0:
                for m in range(c):
                    moved[motion.rate, m] -= motion.gives[k] * motion.pull[j] * x[j, m]


@part_of_kernel
def _slowed(motion: Motion, k: int, x: Array, P: Array) -> None:
    """Have drag take its share of the unit's speed for half a tick, in place."""
    for j in range(x.shape[1]):
        x[motion.rate, j] *= motion.kept[k]
    for j in range(len(P)):
        P[motion.rate, j] *= motion.kept[k]
    for j in range(len(P)):
        P[j, motion.rate] *= motion.kept[k]


@part_of_kernel
def _innovation(row: Array, noise: float, x: Array, P: Array, left: Array, across: Array) -> float:
    """Return S = h P h' + r of a reading, and leave e = z - h x in `left` (z before) and P h' in `across`."""
    for j in range(len(x)):
        across[j] = 0.0
    for i in range(len(x)):
        if row[i] != 0.0:
            for j in range(len(x)):
                across[j] += row[i] * P[i, j]
            for j in range(len(left)):
                left[j] -= row[i] * x[i, j]
    spread = noise
    for i in range(len(x)):
        spread += row[i] * across[i]
    return spread


@part_of_kernel
def _take(x: Array, P: Array, left: Array, across: Array, spread: float) -> None:
    """Take in a reading: K = P h' / S, x = x + K e, P = P - K S K', with P h' `across`, e `left` and S the `spread`."""
    for i in range(len(x)):
        gain = across[i] / spread
        for j in range(len(left)):
            x[i, j] += gain * left[j]
        for j in range(len(x)):
            P[i, j] -= gain * across[j]


@kernel
def _follow(motion: Motion, reads: Reads, commands: Array, x: Array, P: Array) -> tuple[Array, Array]:
    """Kalman filter of one model, readings one after the other; x (n, c) and P (n, n) are changed in place.

    Returns the innovations over the standard deviation that was predicted (m, c), and its square (m,). Loops over
    single values take half the time of operations on small arrays.
    """
    n, c = x.shape
    innovations, variances = np.empty_like(reads.values), np.empty(len(reads.values))
    across, left, first = np.empty(n), np.empty(c), 0
    moved, half, turned = np.empty_like(x), np.empty_like(P), np.empty_like(P)
    for k in range(len(reads.ends)):
        _slowed(motion, k, x, P)
        _move(motion, k, x, moved)
        for i in range(n):
            for j in range(c):
                x[i, j] = moved[i, j] + motion.B[i] * commands[k, j]
        # P = F P F' + Q = F (F P)' + Q, of a symmetric P
        _move(motion, k, P, half)
        for i in range(n):
            for j in range(n):
                turned[i, j] = half[j, i]
        _move(motion, k, turned, P)
        for i in range(n):
            for j in range(n):
                P[i, j] += motion.Q[i, j]
        _slowed(motion, k, x, P)
        P[motion.rate, motion.rate] += motion.unknown[k]
        for m in range(first, reads.ends[k]):
            for j in range(c):
                left[j] = reads.values[m, j]
            variances[m] = _innovation(reads.rows[m], reads.noise[m], x, P, left, across)
            deviation = math.sqrt(variances[m])
            for j in range(c):
                innovations[m, j] = left[j] / deviation
            if reads.used[m]:
                _take(x, P, left, across, variances[m])
        first = reads.ends[k]
    return innovations, variances
