"""The Kalman filter of one step, twice: compiled for the loop, and filterpy's as the reference that anyone can read.

Both estimate x[k+1] = F x[k] + B u[k] + w, w of covariance Q, from readings z = H x + v, v of independent noise, and
can take each other's place (parameter `estimator.implementation`).
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from heave_node.numerics.arrays import Array

from winch_controller_node.model.kalman_kernel import corrected, predicted_covariance


class StepFilter(Protocol):
    """A Kalman filter of one input, a step at a time: estimate x, shape (n,), and its covariance P, shape (n, n)."""

    @property
    def x(self) -> Array: ...  # noqa: D102

    @property
    def P(self) -> Array: ...  # noqa: D102

    def set_model(self, F: Array, B: Array, Q: Array) -> None:
        """Use another model: transition F (n, n), input B (n, 1), covariance Q of the process noise of a step."""
        ...

    def set_state(self, x: Array, P: Array) -> None:
        """Go on from an estimate x, shape (n,), and its covariance P, shape (n, n)."""
        ...

    def predict(self, command: float) -> None:
        """Go a step ahead under `command`."""
        ...

    def correct(self, z: Array, H: Array, variances: Array) -> None:
        """Take in readings z, shape (m,), of rows H (m, n), whose noise has the `variances` (m,)."""
        ...


class CompiledKalmanFilter:
    """The filter of the loop.

    Parameters
    ----------
    order : number of states n
    """

    def __init__(self, order: int) -> None:
        self._F, self._B, self._Q = np.eye(order), np.zeros(order), np.zeros((order, order))
        self.x, self.P = np.zeros(order), np.eye(order)
        # compiled (or fetched from the cache) here, not in the first tick of a run in real time
        self.correct(np.zeros(1), np.zeros((1, order)), np.ones(1))
        self.predict(0.0)
        self.set_state(np.zeros(order), np.eye(order))

    def set_model(self, F: Array, B: Array, Q: Array) -> None:
        """See StepFilter."""
        self._F, self._Q = np.ascontiguousarray(F), np.ascontiguousarray(Q)
        self._B = np.ascontiguousarray(B[:, 0])

    def set_state(self, x: Array, P: Array) -> None:
        """Go on from an estimate x and its covariance P; they are not copied, and never changed."""
        self.x, self.P = x, P

    def predict(self, command: float) -> None:
        """See StepFilter."""
        self.x = self._F @ self.x + self._B * command
        self.P = predicted_covariance(self.P, self._F, self._Q)

    def correct(self, z: Array, H: Array, variances: Array) -> None:
        """See StepFilter; the readings are taken together."""
        self.x, self.P = corrected(self.x, self.P, z, H, variances)


class ReferenceKalmanFilter:
    """The classic filter of thesis 6.3.4 as filterpy has it: readings one after the other, no shortcut.

    It takes ten times as long as the compiled one, and gives the same estimate within rounding.

    Parameters
    ----------
    order : number of states n
    """

    def __init__(self, order: int) -> None:
        from filterpy.kalman import KalmanFilter  # noqa: PLC0415 - a second to import, for those who want the reference only

        self._filter = KalmanFilter(dim_x=order, dim_z=1, dim_u=1)

    @property
    def x(self) -> Array:
        """Estimate, shape (n,)."""
        return np.asarray(self._filter.x[:, 0])

    @property
    def P(self) -> Array:
        """Covariance of the estimate, shape (n, n)."""
        return np.asarray(self._filter.P)

    def set_model(self, F: Array, B: Array, Q: Array) -> None:
        """See StepFilter."""
        self._filter.F, self._filter.B, self._filter.Q = F, B, Q

    def set_state(self, x: Array, P: Array) -> None:
        """See StepFilter."""
        self._filter.x, self._filter.P = np.array(x, dtype=float)[:, None], np.array(P, dtype=float)

    def predict(self, command: float) -> None:
        """See StepFilter."""
        self._filter.predict(u=np.array([[command]]))

    def correct(self, z: Array, H: Array, variances: Array) -> None:
        """See StepFilter; readings are taken one by one: their noise is independent, so the order does not matter."""
        for value, row, variance in zip(z, H, variances, strict=True):
            self._filter.update(value, R=variance, H=row[None, :])


IMPLEMENTATIONS: dict[str, type[CompiledKalmanFilter] | type[ReferenceKalmanFilter]] = {
    "compiled": CompiledKalmanFilter,
    "filterpy": ReferenceKalmanFilter,
}
"""Filters by the value of the parameter `estimator.implementation`."""
