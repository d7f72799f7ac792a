"""The boom tip's motion seen ahead: what it says beyond the estimate, and the best command for it.

The estimate alone predicts the boom tip as its sea model would have it on the average. A preview y of its heave at
times ahead differs from that by e = y - H x: the sum of what white noise w will have driven the sea model to, and of
the preview's own error. The noise to be expected is linear in e (Gauss-Markov), w_j = Q H_j' (sum H_j Q H_j' + R)^-1 e,
and so is the best command for a known disturbance, by the costate of the Riccati equation (preview control): u = -G x
+ c, c_k = -W^-1 B' (P w_k + s_(k+1)), s_k = (A - B G)' (P w_k + s_(k+1)), W = R + B' P B.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from heave_node.interface.preview import HeavePreview
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel
from scipy.linalg import solve_discrete_lyapunov

from winch_controller_node.model.lqr import output_cost
from winch_controller_node.model.regulator import is_sea_state, is_sensor_state

STEP = 0.25
"""Step at which a preview is used [s]; a boom tip is straight enough between."""


@dataclass(frozen=True, slots=True)
class PreviewUse:
    """What a law wants of a preview."""

    first: float  # it must cover all times ahead from this one on [s]
    last: float  # to this one [s]
    noise: float  # assumed standard deviation of its error [m]


class PreviewReader:
    """Returns what a preview predicts beyond the estimate.

    Parameters
    ----------
    model : sampled augmented model of the design
    duration : of the preview that is used [s]
    noise : standard deviation of the preview's error [m]
    """

    def __init__(self, model: LinearModel, duration: float, noise: float) -> None:
        assert model.dt is not None
        every = max(1, round(STEP / model.dt))
        ticks = np.arange(every, round(duration / model.dt) + 1, every)
        self._times = ticks * model.dt
        self.use = PreviewUse(float(self._times[0]), float(self._times[-1]), noise)  # what it wants of a preview
        sea = [i for i, name in enumerate(model.state_names) if is_sea_state(name)]
        A, Q = model.A[np.ix_(sea, sea)], model.noise_covariance[np.ix_(sea, sea)]
        rows = [model.row("boom_tip_heave")[sea]]
        for _ in range(ticks[-1]):
            rows.append(rows[-1] @ A)
        zero = np.zeros(len(sea))
        self._prediction = np.zeros((len(ticks), model.order))
        self._prediction[:, sea] = [rows[k] for k in ticks]
        effects = np.array([[rows[k - 1 - j] if j < k else zero for k in ticks] for j in range(ticks[-1])])
        spread = effects @ Q
        covariance = np.einsum("jis,jks->ik", spread, effects) + noise**2 * np.eye(len(ticks))
        # of the states at each tick, per innovation of the preview, shape (ticks, n, m)
        self.disturbances = np.zeros((ticks[-1], model.order, len(ticks)))
        self.disturbances[:, sea] = np.swapaxes(spread, 1, 2) @ np.linalg.inv(covariance)

    def innovation(self, preview: HeavePreview | None, x: Array) -> Array | None:
        """Return heave ahead less that predicted from `x`, shape (m,) [m]; None where a preview does not reach so far.

        `preview` and `x` have the same authority.
        """
        if preview is None or not preview.covers(self.use.first, self.use.last):
            return None
        heave = np.interp(self._times, preview.ahead, preview.heave)
        return np.asarray(heave - self._prediction @ x) if np.all(np.isfinite(heave)) else None


def feedforward(
    model: LinearModel, gain: Array, sizes: Mapping[str, float], command_size: float, disturbances: Array
) -> Array:
    """Return the best commands to come per innovation of the preview, shape (ticks, m), on top of u = -gain x.

    Parameters
    ----------
    model : sampled augmented model
    gain : LQR gain over its states for the cost that follows, see `full_gain`
    sizes, command_size : of outputs by name and of the command, that have equal weight in the cost
    disturbances : see `PreviewReader`
    """
    keep = [i for i, name in enumerate(model.state_names) if not is_sensor_state(name)]
    plant = model.select_states([model.state_names[i] for i in keep])
    cost, G, B = output_cost(plant, sizes, command_size), gain[keep][None, :], plant.B
    closed = plant.A - B @ G
    P = solve_discrete_lyapunov(closed.T, cost.Q + G.T @ cost.R @ G - cost.N @ G - G.T @ cost.N.T)
    weight = float((cost.R + B.T @ P @ B)[0, 0])
    costate = np.zeros((len(keep), disturbances.shape[2]))
    commands = np.empty((len(disturbances), disturbances.shape[2]))
    for k in range(len(disturbances) - 1, -1, -1):
        pushed = P @ disturbances[k][keep] + costate
        commands[k] = -(B[:, 0] @ pushed) / weight
        costate = closed.T @ pushed
    return commands
