"""The Kalman filter twice: compiled for the loop, and on filterpy's as the reference that anyone can read.

Both estimate x[k+1] = F x[k] + B u[k] + w, w of covariance Q, from readings that are judged, and taken in at the tick
they were measured at; they can take each other's place (parameter `estimator.implementation`).
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from heave_node.numerics.arrays import Array
from numpy.typing import NDArray

from winch_controller_node.model.drag_kernel import with_drag
from winch_controller_node.model.kalman_kernel import (
    OFFSET,
    TICK,
    VALUE,
    VARIANCE,
    WEIGHTS,
    WHICH,
    FilterModel,
    Gate,
    Memory,
    RunInputs,
    run,
)
from winch_controller_node.model.slack_kernel import slack_variance, with_slack


class KalmanFilter(Protocol):
    """A Kalman filter: estimate x, shape (n,), and covariance P, shape (n, n), of its newest `tick` (None: no yet).

    `model` may be another one from a tick to the next; `streams` and `refusals` are those of `kalman_kernel.Memory`.
    """

    model: FilterModel
    streams: Array
    refusals: NDArray[np.int64]

    @property
    def x(self) -> Array: ...  # noqa: D102

    @property
    def P(self) -> Array: ...  # noqa: D102

    @property
    def tick(self) -> int | None: ...  # noqa: D102

    def run(self, inputs: RunInputs) -> Array:
        """Go through a run of ticks, `inputs`; return the result of each reading, shape (number of readings, 4)."""
        ...


class CompiledKalmanFilter:
    """The filter of the loop.

    Parameters
    ----------
    model : of the state and its measurements
    gate : for the readings
    kept : number of ticks that it can go back over, with the present one
    x, P : estimate (n,) and covariance (n, n) to begin with
    """

    def __init__(self, model: FilterModel, gate: Gate, kept: int, x: Array, P: Array) -> None:
        n, m = len(x), len(model.rows)
        self.model, self._gate, self.x, self.P = model, gate, x, P
        self._used = np.zeros((kept, 4, WEIGHTS + n))
        self._memory = Memory(
            x=np.zeros((kept, n)),
            P=np.zeros((kept, n, n)),
            commands=np.zeros(kept),
            counts=np.zeros(kept, dtype=np.int64),
            span=np.zeros(2, dtype=np.int64),
            streams=np.full(m, math.nan),
            refusals=np.zeros(m, dtype=np.int64),
        )
        self.streams, self.refusals = self._memory.streams, self._memory.refusals
        # compiled (or fetched from the cache) here, not in the first tick of a run in real time
        self.run(RunInputs(np.zeros((0, 3)), np.zeros((0, WEIGHTS + n))))

    @property
    def tick(self) -> int | None:
        """Newest tick; None before the first."""
        return int(self._memory.span[0]) if self._memory.span[1] else None

    def run(self, inputs: RunInputs) -> Array:
        """See KalmanFilter."""
        self.x, self.P, self._used, said = run(self.model, self._gate, self._memory, self._used, self.x, self.P, inputs)
        return said


@dataclass
class _Tick:
    """What the reference keeps of one tick: the prediction for it, the readings used, the command that followed."""

    x: Array
    P: Array
    used: list[Array] = field(default_factory=list)
    command: float = 0.0


class ReferenceKalmanFilter:
    """The classic filter of thesis 6.3.4 as filterpy has it: readings one after the other, no shortcut.

    It takes many times as long as the compiled one, and gives the same estimate within rounding.

    Parameters
    ----------
    model, gate, kept, x, P : see CompiledKalmanFilter
    """

    def __init__(self, model: FilterModel, gate: Gate, kept: int, x: Array, P: Array) -> None:
        from filterpy.kalman import KalmanFilter  # noqa: PLC0415 - a second to import, for those who want the reference only

        self.model, self._gate = model, gate
        self._filter = KalmanFilter(dim_x=len(x), dim_z=1, dim_u=1)
        self._set_state(x, P)
        self._past: deque[_Tick] = deque(maxlen=kept)
        self._newest: int | None = None
        self.streams = np.full(len(model.rows), math.nan)
        self.refusals = np.zeros(len(model.rows), dtype=np.int64)

    @property
    def x(self) -> Array:
        """Estimate, shape (n,)."""
        return np.asarray(self._filter.x[:, 0])

    @property
    def P(self) -> Array:
        """Covariance of the estimate, shape (n, n)."""
        return np.asarray(self._filter.P)

    @property
    def tick(self) -> int | None:
        """Newest tick; None before the first."""
        return self._newest

    def _set_state(self, x: Array, P: Array) -> None:
        self._filter.x, self._filter.P = np.array(x, dtype=float)[:, None], np.array(P, dtype=float)

    def run(self, inputs: RunInputs) -> Array:
        """See KalmanFilter."""
        said: list[tuple[float, float, float, bool]] = []
        for tick, command, end in inputs.steps.tolist():
            self._advance(int(tick), command)
            delivered = inputs.readings[len(said) : int(end)]
            for measured in sorted(set(delivered[:, TICK])):
                said += self._take(int(measured), delivered[delivered[:, TICK] == measured])
        return np.array(said).reshape(-1, 4)

    def _advance(self, tick: int, command: float) -> None:
        """Predict for a `tick`, with all between, under the drag of the speed before it."""
        F, B, Q = with_drag(self.model.drag, self.x, self.model.F, self.model.B, self.model.Q)
        F, Q = with_slack(self.model.slack, self.x, F, Q)
        self._filter.F, self._filter.B, self._filter.Q = F, B[:, None], Q
        if self._newest is None:
            self._past.append(_Tick(self.x, self.P))
        else:
            for _ in range(self._newest, tick):
                self._past[-1].command = command
                self._predict(command)
                self._past.append(_Tick(self.x, self.P))
        self._newest = tick

    def _predict(self, command: float) -> None:
        self._filter.predict(u=np.array([[command]]))

    def _take(self, tick: int, readings: Array) -> list[tuple[float, float, float, bool]]:
        """Take in the `readings` measured at a `tick`, and run forward again to the present; return what they said."""
        index = len(self._past) - 1 - ((self._newest or 0) - tick)
        if index < 0:
            return [(math.nan, math.nan, math.nan, False)] * len(readings)
        entry = self._past[index]
        if index < len(self._past) - 1:
            self._set_state(entry.x, entry.P)
            self._update(entry.used)
        for reading in readings:
            reading[VARIANCE] += slack_variance(self.model.slack, self.x, int(reading[WHICH]))
        judged = [self._judge(reading) for reading in readings]
        accepted = [reading for reading, (_, is_used) in zip(readings, judged, strict=True) if is_used]
        self._update(accepted)
        entry.used += accepted
        for before, after in zip(list(self._past)[index:], list(self._past)[index + 1 :], strict=False):
            self._predict(before.command)
            after.x, after.P = self.x, self.P
            self._update(after.used)
        return [said for said, _ in judged]

    def _judge(self, reading: Array) -> tuple[tuple[float, float, float, bool], bool]:
        """Compare a reading with its prediction; return what it says, and whether it is used."""
        gate, which = self._gate, int(reading[WHICH])
        row, predicted = self._linearised(reading)
        variance = float(row @ self.P @ row + reading[VARIANCE])
        innovation = float(reading[VALUE]) - predicted
        nis = innovation * innovation / variance  # a power would raise OverflowError for a number that is absurd
        # a stream that goes on where its last reading was says something of the model, not of the sensor
        step = innovation - float(self.streams[which])
        is_stream = step * step <= 2.0 * gate.threshold * variance
        accepted = nis <= gate.threshold or ((is_stream or not self.model.is_gated[which]) and math.isfinite(nis))
        self.refusals[which] = 0 if accepted else self.refusals[which] + 1
        # that many in a row: it is the filter that is wrong, and its covariance must be large enough to come back
        is_lost = bool(self.refusals[which] > gate.limit) and math.isfinite(nis)
        if is_lost:
            self._set_state(self.x, self.P + gate.added)
            self.refusals[which] = 0
        if accepted or is_lost:
            self.streams[which] = innovation
        return (innovation, math.sqrt(variance), nis, accepted), accepted or is_lost

    def _linearised(self, reading: Array) -> tuple[Array, float]:
        """Return the row of a reading at the present estimate, and its prediction."""
        model, which, offset = self.model, int(reading[WHICH]), float(reading[OFFSET])
        row = model.rows[which] + offset * model.changes[which] + 0.5 * offset * (offset - 1.0) * model.bends[which]
        row = row + reading[WEIGHTS:]
        plain, scale_state = float(row @ self.x), model.scale_states[which]
        if scale_state < 0:
            return row, plain
        scale = 1.0 + float(self.x[scale_state])
        row = scale * row
        row[scale_state] += plain
        return row, scale * plain

    def _update(self, readings: list[Array]) -> None:
        """Take in readings one by one, all linearised at the present estimate: their noise is independent."""
        x = self.x
        for reading, (row, predicted) in zip(readings, [self._linearised(one) for one in readings], strict=True):
            # the filter predicts H x; a bilinear measurement predicts something else
            value = reading[VALUE] - predicted + row @ x
            self._filter.update(value, R=reading[VARIANCE], H=row[None, :])


IMPLEMENTATIONS: dict[str, type[CompiledKalmanFilter] | type[ReferenceKalmanFilter]] = {
    "compiled": CompiledKalmanFilter,
    "filterpy": ReferenceKalmanFilter,
}
"""Filters by the value of the parameter `estimator.implementation`."""
