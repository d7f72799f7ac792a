"""What the guard is told of a tick, computed from the estimate, and whether a lost loop has been brought back."""

from __future__ import annotations

import math

from heave_node.arrays import Array

from winch_controller_node.model.loop_rows import LoopRows
from winch_controller_node.parameters.laws import ModeParameters
from winch_controller_node.supervision.guard import Seen


class GuardInputs:
    """Motions of unit and drum as the guard compares them.

    Parameters
    ----------
    parameters : how fast authority may move
    tick_period : [s]
    """

    def __init__(self, parameters: ModeParameters, *, tick_period: float) -> None:
        self._dt = tick_period
        self._largest_change = tick_period / min(parameters.fade_in_time, parameters.fade_out_time)
        self._authority_before = 0.0

    def seen(
        self,
        rows: LoopRows,
        estimate: Array,
        mean_state: Array,
        uncompensated: Array,
        *,
        authority: float,
        depth_reading: float | None,
    ) -> Seen:
        """Return what the guard is told of a tick; the mean payout's own motion is no harm.

        Parameters
        ----------
        rows : of the design's model
        estimate, mean_state : estimate and the mean payout's own motion, shape (n,)
        uncompensated : heave and rate of the unit with the winch locked, shape (2,)
        authority : share of the sea that is compensated and judged
        depth_reading : heave by the depth sensor, the mean payout's share off [m]; None: no reading
        """
        mean = rows.winch @ mean_state + mean_state[rows.unit_states]
        residual = mean + estimate[rows.unit_states]
        tip, tip_rate = (float(value) for value in rows.tip @ estimate)
        # while authority A moves, the unit goes over to (1 - A) of the uncompensated motion: by Eq. 6.2 that asks for
        # payout = A tip + 2 a A' z_off' (b and A'' left out), with a z_off'' = tip - z_off
        change, self._authority_before = authority - self._authority_before, authority
        change = min(max(change, -self._largest_change), self._largest_change) / self._dt
        meant = authority * tip_rate + change * (3.0 * tip - 2.0 * float(uncompensated[0]))
        return Seen(
            residual=(float(residual[0]), float(residual[1])),
            uncompensated=(float(uncompensated[0]), float(uncompensated[1])),
            tip_rate=tip_rate,
            drum_error=float(rows.payout_rate @ estimate) - meant,
            depth=None if depth_reading is None else depth_reading + float(mean[0]),
        )


def swing_left(rows: LoopRows, estimate: Array, uncompensated: Array, inertia: float) -> float:
    """Return the amplitude of the unit about its uncompensated motion [m], payout that is out taken off.

    `inertia` is a of the two-state cable [s^2].
    """
    error = estimate[rows.unit_states] + rows.winch @ estimate - uncompensated
    return math.hypot(error[0], math.sqrt(inertia) * error[1])
