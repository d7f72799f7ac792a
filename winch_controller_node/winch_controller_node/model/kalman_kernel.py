"""The Kalman filter, compiled: a run of ticks with their readings in one call.

The filter keeps its recent past in rings by tick: the prediction for it, the command that followed, the readings used.
A late reading is taken in at its own tick, and the filter runs forward again from there.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import kernel, part_of_kernel
from numpy.typing import NDArray

from winch_controller_node.model.drag_kernel import Drag, with_drag
from winch_controller_node.model.slack_kernel import Slack, slack_variance, with_slack

TICK, WHICH, VALUE, OFFSET, VARIANCE, WEIGHTS = range(6)
"""Columns of a table of readings: tick that it belongs to, index of the measurement, value, how much later than the
tick [ticks], variance of the noise, and from the last on the further weights of the n states."""

INNOVATION, SIGMA, NIS, ACCEPTED = range(4)
"""Columns of what the readings said, see `estimator.Innovation`."""


class FilterModel(NamedTuple):
    """Model and measurements as arrays.

    Attributes
    ----------
    F, B, Q : transition (n, n), input (n,) and covariance of the process noise (n, n) of a tick
    drag, slack : of the unit, and of the cable
    rows, changes, bends : of the measurements at a tick, and their first and second differences over ticks, (m, n)
    scale_states : index of the state that is the relative scale error, (m,); -1: none
    is_gated : refused where it is far off its prediction, (m,)
    """

    F: Array
    B: Array
    Q: Array
    drag: Drag
    slack: Slack
    rows: Array
    changes: Array
    bends: Array
    scale_states: NDArray[np.int64]
    is_gated: NDArray[np.bool_]


class Gate(NamedTuple):
    """When a reading is refused, see `estimator.KalmanEstimator`.

    Attributes
    ----------
    threshold : normalised innovation squared above which a reading of a gated measurement is
    limit : refusals in a row after which the next reading is taken
    added : covariance that is added then (n, n)
    """

    threshold: float
    limit: int
    added: Array


class Memory(NamedTuple):
    """What the filter keeps; changed in place. Rings have a place for each tick, `tick % len`.

    Attributes
    ----------
    x, P : rings of the predictions for a tick, (k, n) and (k, n, n)
    commands : ring of what followed it (k,)
    counts : ring of the number of readings used of it (k,)
    span : newest tick, and number of ticks that are kept (2,)
    streams : innovation of the last accepted reading by measurement, (m,); NaN: none
    refusals : in a row, by measurement (m,)
    """

    x: Array
    P: Array
    commands: Array
    counts: NDArray[np.int64]
    span: NDArray[np.int64]
    streams: Array
    refusals: NDArray[np.int64]


class RunInputs(NamedTuple):
    """A run of ticks.

    Attributes
    ----------
    steps : number of each tick, command of the tick before, and where the readings delivered at it end in the table,
        (t, 3); numbers grow, and ticks left out are predicted over
    readings : table of them all, sorted by their own ticks within those delivered at one
    """

    steps: Array
    readings: Array


@kernel
def predicted_covariance(P: Array, F: Array, Q: Array) -> Array:
    """Return the covariance a step ahead, F P F' + Q, shape (n, n)."""
    return np.dot(np.dot(F, P), F.T) + Q


@kernel
def filter_gain(P: Array, H: Array, variances: Array) -> Array:
    """Return the gain K = P H' (H P H' + R)^-1, shape (n, m), for readings of rows H (m, n), R = diag(variances)."""
    across = np.dot(H, P)
    S = np.dot(across, H.T)
    for i in range(len(variances)):
        S[i, i] += variances[i]
    return np.ascontiguousarray(np.linalg.solve(S, across).T)


@kernel
def corrected_covariance(P: Array, K: Array, H: Array, variances: Array) -> Array:
    """Return the covariance after readings, (I - K H) P (I - K H)' + K R K' (Joseph's form), R = diag(variances)."""
    rest = np.eye(len(P)) - np.dot(K, H)
    P = np.dot(np.dot(rest, P), rest.T) + np.dot(K * variances, K.T)
    return 0.5 * (P + P.T)


@kernel
def corrected(x: Array, P: Array, z: Array, H: Array, variances: Array) -> tuple[Array, Array]:
    """Return state x (n,) and covariance P (n, n) after readings z (m,) of rows H (m, n) and noise `variances` (m,)."""
    K = filter_gain(P, H, variances)
    return x + np.dot(K, z - np.dot(H, x)), corrected_covariance(P, K, H, variances)


@part_of_kernel
def _predicted(model: FilterModel, x: Array, P: Array, command: float) -> tuple[Array, Array]:
    """Return the state and its covariance a tick ahead under a `command`."""
    return np.dot(model.F, x) + model.B * command, predicted_covariance(P, model.F, model.Q)


@part_of_kernel
def _linearised(model: FilterModel, reading: Array, x: Array) -> tuple[Array, float]:
    """Return the row of a reading at the estimate x (n,), and its prediction."""
    which, offset = int(reading[WHICH]), reading[OFFSET]
    row = model.rows[which] + offset * model.changes[which] + 0.5 * offset * (offset - 1.0) * model.bends[which]
    row += reading[WEIGHTS:]
    plain, scale_state = np.dot(row, x), model.scale_states[which]
    if scale_state < 0:
        return row, plain
    scale = 1.0 + x[scale_state]
    row *= scale
    row[scale_state] += plain
    return row, scale * plain


@part_of_kernel
def _with_readings(model: FilterModel, x: Array, P: Array, readings: Array) -> tuple[Array, Array]:
    """Return state and covariance after the readings of a tick, taken together, each linearised at x."""
    if len(readings) == 0:
        return x, P
    H, z = np.empty((len(readings), len(x))), np.empty(len(readings))
    for i in range(len(readings)):
        H[i], predicted = _linearised(model, readings[i], x)
        # the filter predicts H x; a bilinear measurement predicts something else
        z[i] = readings[i, VALUE] - predicted + np.dot(H[i], x)
    return corrected(x, P, z, H, readings[:, VARIANCE].copy())


@part_of_kernel
def _judged(
    model: FilterModel, gate: Gate, memory: Memory, x: Array, P: Array, reading: Array, said: Array
) -> tuple[bool, Array]:
    """Compare a reading with its prediction, note what it `said`, and return whether it may be used, and P for it."""
    which = int(reading[WHICH])
    row, predicted = _linearised(model, reading, x)
    variance = np.dot(np.dot(row, P), row) + reading[VARIANCE]
    innovation = reading[VALUE] - predicted
    nis = innovation * innovation / variance
    # a stream that goes on where its last reading was says something of the model, not of the sensor
    step = innovation - memory.streams[which]
    is_stream = step * step <= 2.0 * gate.threshold * variance
    accepted = nis <= gate.threshold or ((is_stream or not model.is_gated[which]) and math.isfinite(nis))
    said[INNOVATION], said[SIGMA], said[NIS], said[ACCEPTED] = innovation, math.sqrt(variance), nis, accepted
    memory.refusals[which] = 0 if accepted else memory.refusals[which] + 1
    if memory.refusals[which] > gate.limit and math.isfinite(nis):
        # that many in a row: it is the filter that is wrong, and its covariance must be large enough to come back
        P = P + gate.added
        memory.refusals[which] = 0
        accepted = True
    if accepted:
        memory.streams[which] = innovation
    return accepted, P


@part_of_kernel
def _begun(memory: Memory, tick: int, x: Array, P: Array) -> None:
    """Keep the prediction for a tick that begins, and discard the tick that has its place."""
    place = tick % len(memory.x)
    memory.x[place], memory.P[place], memory.counts[place] = x, P, 0
    memory.span[0], memory.span[1] = tick, min(memory.span[1] + 1, len(memory.x))


@part_of_kernel
def _noted(memory: Memory, used: Array, place: int, reading: Array) -> Array:
    """Return the ring of the readings `used` with another one; it grows where a tick has more than ever before."""
    count = memory.counts[place]
    if count == used.shape[1]:
        grown = np.zeros((used.shape[0], 2 * count + 1, used.shape[2]))
        grown[:, :count] = used
        used = grown
    used[place, count] = reading
    memory.counts[place] = count + 1
    return used


@part_of_kernel
def _taken(
    model: FilterModel, gate: Gate, memory: Memory, used: Array, x: Array, P: Array, readings: Array, said: Array
) -> tuple[Array, Array, Array]:
    """Take in `readings` of one tick; return state and covariance of the present, and the ring of readings used."""
    now, kept, tick = memory.span[0], memory.span[1], int(readings[0, TICK])
    if now - tick >= kept:
        said[:, :ACCEPTED], said[:, ACCEPTED] = math.nan, 0.0
        return x, P, used
    place = tick % len(memory.x)
    before = memory.counts[place]
    if tick < now:
        x, P = _with_readings(model, memory.x[place].copy(), memory.P[place].copy(), used[place, :before])
    for i in range(len(readings)):
        readings[i, VARIANCE] += slack_variance(model.slack, x, int(readings[i, WHICH]))
        accepted, P = _judged(model, gate, memory, x, P, readings[i], said[i])
        if accepted:
            used = _noted(memory, used, place, readings[i])
    x, P = _with_readings(model, x, P, used[place, before : memory.counts[place]])
    for later in range(tick + 1, now + 1):
        x, P = _predicted(model, x, P, memory.commands[(later - 1) % len(memory.x)])
        place = later % len(memory.x)
        memory.x[place], memory.P[place] = x, P
        x, P = _with_readings(model, x, P, used[place, : memory.counts[place]])
    return x, P, used


@kernel
def run(
    model: FilterModel, gate: Gate, memory: Memory, used: Array, x: Array, P: Array, inputs: RunInputs
) -> tuple[Array, Array, Array, Array]:
    """Go through a run of ticks.

    Parameters
    ----------
    model, gate : of the filter
    memory : of its past, changed in place
    used : ring of the tables of the readings used of each tick (k, most, 6 + n)
    x, P : state (n,) and covariance (n, n) of the newest tick, or to begin with
    inputs : of the run

    Returns
    -------
    x, P, used : at the end of the run
    said : result of each reading, shape (number of readings, 4)
    """
    said, first = np.empty((len(inputs.readings), 4)), 0
    for step in inputs.steps:
        number, command, last = int(step[0]), step[1], int(step[2])
        F, B, Q = with_drag(model.drag, x, model.F, model.B, model.Q)
        F, Q = with_slack(model.slack, x, F, Q)
        now = FilterModel(
            F, B, Q, model.drag, model.slack, model.rows, model.changes, model.bends, model.scale_states, model.is_gated
        )
        if memory.span[1] == 0:
            _begun(memory, number, x, P)
        for tick in range(memory.span[0] + 1, number + 1):
            memory.commands[(tick - 1) % len(memory.x)] = command
            x, P = _predicted(now, x, P, command)
            _begun(memory, tick, x, P)
        while first < last:
            end = first + 1
            while end < last and inputs.readings[end, TICK] == inputs.readings[first, TICK]:
                end += 1
            x, P, used = _taken(now, gate, memory, used, x, P, inputs.readings[first:end], said[first:end])
            first = end
    return x, P, used, said
