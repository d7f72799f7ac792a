"""The Kalman filter of the loop, compiled.

It estimates x[k+1] = F x[k] + B u[k] + w, w of covariance Q, from readings that are judged, and taken in at the tick
they were measured at. Its tests hold it against filterpy's, the classic filter of thesis 6.3.4.
"""

from __future__ import annotations

import math

import numpy as np
from heave_node.numerics.arrays import Array

from winch_controller_node.model.kalman_kernel import WEIGHTS, FilterModel, Gate, Memory, RunInputs, run


class KalmanFilter:
    """The filter; its estimate is that of its newest tick.

    `model` may be another one from a tick to the next; `streams` and `refusals` are those of `kalman_kernel.Memory`.

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
        """Go through a run of ticks, `inputs`; return the result of each reading, shape (number of readings, 4)."""
        self.x, self.P, self._used, said = run(self.model, self._gate, self._memory, self._used, self.x, self.P, inputs)
        return said
