"""Where the motions of unit, winch and boom tip are found in a state of the design's model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class LoopRows:
    """Rows and indices of a model.

    Attributes
    ----------
    payout, payout_rate : rows of payout [m] and its rate [m/s], shape (n,)
    payout_rate_through : what the active command adds to that rate: not 0 for a first-order winch without delay
    winch : payout and its rate without that, shape (2, n); tip : heave of the boom tip [m] and its rate, shape (2, n)
    unit_states : indices of unit heave and rate in the state
    """

    payout: Array
    payout_rate: Array
    payout_rate_through: float
    winch: Array
    tip: Array
    unit_states: NDArray[np.int64]

    def drum(self, state: Array, command: float) -> Array:
        """Return payout [m] and rate [m/s] in a `state`, shape (n,), under the `command` that is active, shape (2,)."""
        return np.asarray(self.winch @ state + [0.0, self.payout_rate_through * command])


def loop_rows(model: LinearModel) -> LoopRows:
    """Return the rows of a design's model."""
    payout, rate = model.row("payout"), model.row("payout_rate")
    return LoopRows(
        payout=payout,
        payout_rate=rate,
        payout_rate_through=float(model.D[model.output_names.index("payout_rate"), 0]),
        winch=np.array([payout, rate]),
        tip=np.array([model.row("boom_tip_heave"), model.row("boom_tip_heave_rate")]),
        unit_states=np.array([model.state("unit_heave"), model.state("unit_heave_rate")]),
    )
