"""The mean payout and the loop's own answer to it: what the winch does on purpose, superposed on compensation.

By linearity the loop's motion under the mean payout's share of the command is known exactly; estimator and laws deal
with the rest. A payout left over from before a stop is a mean as well, and returns slowly; so is the payout by which
the mean is carried along where the place moves about which the boom tip heaves, and the unit keeps its depth.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from heave_core.filter_table import STATES
from heave_core.law import put
from heave_core.law_table import MEAN_MOTION, Moved
from heave_core.library import library, new
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel

from winch_controller_node.motion.trajectory import MeanPayout
from winch_controller_node.parameters.laws import MoveParameters
from winch_controller_node.parameters.model import WinchModelParameters

RETURN_SPEED = 0.05
"""Speed at which a payout left over from before a stop returns to the mean [m/s]."""


class MeanMotion:
    """Mean payout, what is left over of an earlier one, and the state of the loop that both alone would bring about.

    Parameters
    ----------
    parameters : of moves
    order : number of states of the design's model
    tick_period : [s]
    """

    def __init__(self, parameters: MoveParameters, order: int, *, tick_period: float) -> None:
        self.record = new(MEAN_MOTION)  # array of one `MeanMotion` of the core
        self.mean = MeanPayout(parameters, tick_period=tick_period, record=self.record["mean"])
        # from before a stop, which returns slowly
        self.left_over = MeanPayout(parameters, tick_period=tick_period, record=self.record["left_over"])
        at_once, carried = replace(parameters, jerk_time=0.0), self.record["carried"]
        # by which the mean is carried along
        self.carried = MeanPayout(at_once, tick_period=tick_period, record=carried)
        self.address: int = self.record.ctypes.data  # of the core's MeanMotion
        self._advance = library().heave_core_advance_motion
        self._model: LinearModel | None = None
        self.state = np.zeros(order)

    @property
    def state(self) -> Array:
        """The mean payout's own motion in the states of the design's model, shape (n,): a copy."""
        state: Array = self._states.copy()
        state.setflags(write=False)
        return state

    @state.setter
    def state(self, state: Array) -> None:
        self._states = self.record["state"][0, : len(state)]
        self._states[:] = state

    @property
    def set_point(self) -> float:
        """Payout about which the winch works now [m]."""
        return self.depth_set_point + self.carried.point.payout

    @property
    def depth_set_point(self) -> float:
        """The part of it that takes the unit to another depth [m]."""
        return self.mean.point.payout + self.left_over.point.payout

    def reference_command(self, winch: WinchModelParameters) -> float:
        """Return the share of the command that moves the mean payout: its rate, and the lag of the `winch` ahead."""
        payout, rate, acceleration = map(sum, zip(self.mean.point, self.carried.point, strict=True))
        if winch.law == "first_order":
            return payout + rate / winch.position_rate
        return rate + winch.time_constant * acceleration + winch.position_gain * payout

    def carry(self, matrix: Array) -> None:
        """Count the state in the terms of another model: `matrix` times the present one, shape (n_new, n)."""
        lead = matrix @ self.record["lead"][0, : matrix.shape[1]]
        put(self.record, {"lead": np.pad(lead, (0, STATES - len(lead)))})
        self.state = matrix @ self.state

    def begin_at(self, payout: float, model: LinearModel, winch: WinchModelParameters) -> None:
        """Begin with drum and unit at rest at a `payout` [m], by the `model` of the design and its `winch`."""
        self.mean.jump_to(payout)
        command = self.reference_command(winch)
        state = np.zeros(model.order)
        state[model.state("payout")], state[model.state("unit_heave")] = payout, -payout
        past_commands = f"{model.input_names[0]}_"
        state[[name.startswith(past_commands) for name in model.state_names]] = command
        self.state = state

    def continue_at(self, state: Array, lowered: float) -> None:
        """Go on from `state`, shape (n,), about a mean that is `lowered` [m] below the present one, at rest there."""
        self.mean.jump_to(self.mean.point.payout + lowered)
        self.state = state
        self.record["lead"] = 0.0
        self.left_over.jump_to(0.0)
        self.carried.jump_to(self.carried.point.payout)

    def stand(self) -> None:
        """Take the mean payout to be where it is now, at rest: the winch is stopped."""
        for one in (self.mean, self.carried):
            one.jump_to(one.point.payout)

    def return_from(self, payout: float) -> None:
        """Count `payout` [m] off the mean as left over from now on; it goes away slowly."""
        self.left_over.jump_to(payout)
        self.left_over.move_to(0.0, RETURN_SPEED)

    def advance(self, model: LinearModel, command: float, *, is_braked: bool) -> None:
        """Advance by a tick in which `command` was the mean payout's share of the command.

        `model` is the design's; `is_braked` : the payouts stay.
        """
        if model is not self._model:
            self._model, self._matrices = model, (np.ascontiguousarray(model.A), model.B[:, 0].copy())
            self._of_model = [matrix.ctypes.data for matrix in self._matrices]
        self.advanced(self._advance(*self._of_model, self.address, len(self._states), command, is_braked))

    def advanced(self, moved: int) -> None:
        """Take in that the core has advanced it by a tick, and which payouts have `moved`, bits of Moved."""
        if not moved:
            return
        if moved & Moved.MEAN_MOVED:
            self.mean.advanced(has_halted=bool(moved & Moved.HALT_ENDED))
        if moved & Moved.LEFT_OVER_MOVED:
            self.left_over.advanced()
        if moved & Moved.CARRIED_MOVED:
            self.carried.advanced()
