"""A filter beside the active one that explains the same readings otherwise, and the evidence for either.

Both predict each reading. The mean squares of their innovations second by second, those within the noise left out, say
in nats which of them is right, where one of them explains what was read in that second. The second one costs a step of
the filter each tick, for as long as it is there.
"""

from __future__ import annotations

import math

from heave_core.library import fill, library, new
from heave_core.sense_table import SECOND
from heave_node.numerics.arrays import Array

from winch_controller_node.beliefs.beliefs import Adopted
from winch_controller_node.core.estimation.core_tick import CoreTick
from winch_controller_node.core.estimation.sense_design import INDEX, second_design
from winch_controller_node.design.design import ControllerDesign, carry_by_name
from winch_controller_node.model.estimator import KalmanEstimator

BLOCK = 1.0
"""Time of which the innovations of one measurement count as one independent one [s]."""

MEMORY = 20.0
"""Memory of the evidence [blocks]: a wave or two."""

SETTLING = 3.0
"""Time from the beginning of the second filter in which nothing is compared [s]."""

EXPLAINED = 4.0
"""Largest mean square of a block's innovations over their noise that a filter explains.

Of two filters that do not, the one that is nearer is not right: limits act, a sensor or a drive is at fault.
"""

CLEARLY = 1.0 / 16.0
"""One that leaves no more than this share of what the other leaves is right all the same [-]."""

LARGEST = 1e4
"""Largest mean square of a block that counts: a spike, or a jump to another belief, says no more."""


class RowEvidence:
    """Innovations of one measurement, of the active filter and of the second one.

    Attributes
    ----------
    nats : evidence for the second filter [nats]; negative: for the active one
    active, second : mean squares of the last block over their noise
    """

    def __init__(self) -> None:
        self.nats = self._blocks = 0.0
        self.active = self.second = 1.0

    def close(self, active: float, second: float, count: float) -> None:
        """End a block: it says who is right where one of the two explains what was read in it.

        Parameters
        ----------
        active, second : sums of the squared innovations of the two over their noise
        count : of readings in them
        """
        self.nats -= self.nats / MEMORY
        self._blocks -= self._blocks / MEMORY
        if count == 0:
            return
        self.active, self.second = (min(max(one / count, 1.0), LARGEST) for one in (active, second))
        nearer, other = sorted((self.active, self.second))
        if nearer <= max(EXPLAINED, CLEARLY * other):
            self.nats += 0.5 * math.log(self.active / self.second)
            self._blocks += 1.0

    @property
    def ratio(self) -> float:
        """How much nearer to the second filter's prediction the readings are than to the active one's [-]."""
        return math.exp(self.nats / max(self._blocks, 1.0))


class SecondFilter:
    """Runs beside the active filter, in the core (second.cpp).

    Parameters
    ----------
    design : by which it predicts
    was : design of the active filter
    active : that filter, from whose state it begins
    tick : the last one
    by_count : it takes the drum to be where it is counted, is as sure as the active one, and is not judged by the count
    """

    def __init__(
        self,
        design: ControllerDesign,
        was: ControllerDesign,
        active: KalmanEstimator,
        tick: int,
        *,
        by_count: bool = False,
    ) -> None:
        self.design = design
        self._estimator = design.make_estimator()
        start = carry_by_name(was, design) @ active.estimate
        covariance = active.covariance if by_count else design.initial_covariance
        self._estimator.continue_at(tick, start, covariance, active.streams)
        if by_count:
            self._estimator.set_process_noise(active.process_noise)
        self._settled = tick + (0 if by_count else round(SETTLING / design.tick_period))
        self._block = round(BLOCK / design.tick_period)
        self._rows = {name: RowEvidence() for name in self._estimator.measurements}
        self._record, self._by_count = new(SECOND), by_count
        fill(self._record[0], second_design(self._estimator, by_count=by_count))
        self._step, self._address = library().heave_core_second, self._record.ctypes.data

    def step(self, core: CoreTick, number: int, command: float, motion: int) -> None:
        """Take in a tick that has just been sensed.

        Parameters
        ----------
        core : that has it
        number : of it
        command : in the terms of this filter's model
        motion : address of the mean payout's
        """
        elapsed = number - self._settled
        self._step(*core.beside(*self._estimator.kalman.addresses, motion), command, elapsed > 0, self._address)
        if elapsed <= 0 or elapsed % self._block:
            return
        sums = self._record[0]
        for name, row in self._rows.items():
            place = INDEX[name]
            row.close(*(float(sums[field][place]) for field in ("active", "second", "count")))
        for field in ("active", "second", "count"):
            sums[field] = 0.0

    def carry(self, design: ControllerDesign, matrix: Array, added: Array | float = 0.0) -> None:
        """Go on with the `design` that the active filter goes on with: the block that this breaks says nothing.

        Parameters
        ----------
        design : its states are `matrix`, shape (n_new, n), times the present ones
        matrix : as said
        added : covariance that this adds, shape (n_new, n_new)
        """
        was, self.design, self._estimator = self._estimator, design, design.make_estimator()
        assert was.tick is not None
        covariance = matrix @ was.covariance @ matrix.T + added
        self._estimator.continue_at(was.tick, matrix @ was.estimate, covariance, was.streams)
        fill(self._record[0], second_design(self._estimator, by_count=self._by_count))

    @property
    def process_noise(self) -> Array:
        """Covariance of the process noise of a tick, shape (n, n)."""
        return self._estimator.process_noise

    def set_process_noise(self, covariance: Array) -> None:
        """Take the noise of another sea, as the active filter does: its `covariance`, shape (n, n)."""
        self._estimator.set_process_noise(covariance)

    @property
    def nats(self) -> float:
        """Evidence for this filter against the active one [nats]."""
        return sum(row.nats for row in self._rows.values())

    @property
    def witness_against(self) -> str:
        """Measurement that says most against it."""
        return min(self._rows, key=lambda name: self._rows[name].nats)

    @property
    def witness(self) -> tuple[str, float]:
        """Measurement that says most for it, and how much nearer its readings are to its prediction [-]."""
        name = max(self._rows, key=lambda name: self._rows[name].nats)
        return name, self._rows[name].ratio

    def state(self, tick: int) -> Adopted:
        """Return its state after `tick`, to go on from."""
        return Adopted(tick, self._estimator.estimate.copy(), self._estimator.covariance.copy())
