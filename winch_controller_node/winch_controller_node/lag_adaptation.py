"""Adaptation to the winch's true lag: how late the drum follows, learnt from the encoder while the loop runs.

A drum that follows its command later than believed by d trails the believed payout by d times its rate. The
regression of that difference on the rate gives d; a wrong delay and a wrong servo constant look alike at the
frequencies of a sea, and do the same harm, so that one number stands for both. The design is then made anew with
the delay that fits.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from winch_controller_node.design import ControllerDesign
from winch_controller_node.law_parameters import LagParameters
from winch_controller_node.linear_model import Array
from winch_controller_node.parameters import WinchControllerParameters

SMALLEST_MOTION = 0.05
"""Standard deviation of the rate [m/s] below which nothing is learnt."""


class LagTracker:
    """Compares the encoder with the believed winch under the commands given.

    Parameters
    ----------
    parameters : memory, patience, range
    design : the believed winch
    """

    def __init__(self, parameters: LagParameters, design: ControllerDesign) -> None:
        self._parameters = parameters
        self._found = 0.0
        self.refer_to(design, np.zeros(design.model.order))

    def refer_to(self, design: ControllerDesign, state: Array) -> None:
        """Compare with another belief from now on; `state` holds payout, rate and past commands as they are."""
        model = design.model
        self._dt = design.tick_period
        self._A, self._B = model.A, model.B[:, 0]
        self._payout, self._rate = model.row("payout"), model.row("payout_rate")
        winch = [i for i, name in enumerate(model.state_names) if name.startswith("payout")]
        self._state = np.zeros(model.order)
        self._state[winch] = state[winch]
        self._sums = np.zeros(5)
        self._seen = 0.0

    def advance(self, command: float) -> None:
        """Advance the believed winch by a tick under the command [m/s] given for it."""
        self._state = self._A @ self._state + self._B * command

    def compare(self, payout: float) -> None:
        """Take in the encoder's payout [m] of the tick the believed winch stands at."""
        rate = float(self._rate @ self._state)
        error = payout - float(self._payout @ self._state)
        self._seen += self._dt
        self._sums *= 1.0 - self._dt / self._parameters.memory
        self._sums += (1.0, rate, error, rate * rate, rate * error)

    @property
    def lag_error(self) -> float:
        """How much later than believed the drum follows [s]; 0 until enough was seen."""
        if self._seen < self._parameters.patience:
            return 0.0
        count, rate, error, squares, products = self._sums
        variance = squares / count - (rate / count) ** 2
        if variance < SMALLEST_MOTION**2:
            return 0.0
        return float(-(products / count - rate * error / count**2) / variance)

    def better_belief(self, parameters: WinchControllerParameters) -> WinchControllerParameters | None:
        """Return parameters with the delay that fits what was seen, or None where the present one does."""
        error = self.lag_error
        if abs(error) < self._parameters.step:
            return None
        largest = self._parameters.largest
        wanted = min(max(self._found + error, -largest), largest)
        delay = max(parameters.winch.command_delay + wanted - self._found, 0.0)
        change = delay - parameters.winch.command_delay
        if abs(change) < 0.5 * self._parameters.step:
            return None
        self._found += change
        return replace(parameters, winch=replace(parameters.winch, command_delay=delay))


def carry_by_name(old: ControllerDesign, new: ControllerDesign) -> Array:
    """Return the matrix that takes a state of `old` to one of `new`, shape (n_new, n_old).

    States of one name are the same; a longer chain of past commands repeats its oldest.
    """
    chain = old.delay_states
    matrix = np.zeros((new.model.order, old.model.order))
    for row, name in enumerate(new.model.state_names):
        if old.model.has_state(name):
            matrix[row, old.model.state(name)] = 1.0
        elif chain:
            matrix[row, old.model.state(chain[-1])] = 1.0
    return matrix
