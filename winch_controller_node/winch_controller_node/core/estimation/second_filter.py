"""A filter beside the active one that explains the same readings otherwise, and the evidence for either.

Both predict each reading. The mean squares of their innovations second by second, those within the noise left out, say
in nats which of them is right, where one of them explains what was read in that second. The second one costs a step of
the filter each tick, for as long as it is there.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence

from winch_controller_node.beliefs.beliefs import Adopted
from winch_controller_node.design.design import ControllerDesign, carry_by_name
from winch_controller_node.model.estimator import Innovation, KalmanEstimator, Measurement

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
        self._sums, self._count = (0.0, 0.0), 0

    def add(self, active: Innovation, second: Innovation) -> None:
        """Take in a reading by the `active` filter and by the `second` one."""
        noise = max(active.sigma, second.sigma) ** 2
        self._sums = self._sums[0] + active.value**2 / noise, self._sums[1] + second.value**2 / noise
        self._count += 1

    def close(self) -> None:
        """End a block: it says who is right where one of the two explains what was read in it."""
        self.nats -= self.nats / MEMORY
        self._blocks -= self._blocks / MEMORY
        if self._count == 0:
            return
        self.active, self.second = (min(max(one / self._count, 1.0), LARGEST) for one in self._sums)
        self._sums, self._count = (0.0, 0.0), 0
        nearer, other = sorted((self.active, self.second))
        if nearer <= max(EXPLAINED, CLEARLY * other):
            self.nats += 0.5 * math.log(self.active / self.second)
            self._blocks += 1.0

    @property
    def ratio(self) -> float:
        """How much nearer to the second filter's prediction the readings are than to the active one's [-]."""
        return math.exp(self.nats / max(self._blocks, 1.0))


class SecondFilter:
    """Runs beside the active filter.

    Parameters
    ----------
    design : by which it predicts
    was : design of the active filter
    active : that filter, from whose state it begins
    tick : the last one
    settling : time from its beginning in which nothing is compared [s]; 0: it is as sure as the active one
    """

    def __init__(
        self,
        design: ControllerDesign,
        was: ControllerDesign,
        active: KalmanEstimator,
        tick: int,
        settling: float = SETTLING,
    ) -> None:
        self.design = design
        self._dt = design.tick_period
        self._estimator = design.make_estimator()
        start = carry_by_name(was, design) @ active.estimate
        covariance = design.initial_covariance if settling > 0.0 else active.covariance
        self._estimator.continue_at(tick, start, covariance, active.streams)
        self._settling = settling
        self._first = tick
        self._block = round(BLOCK / self._dt)
        self._rows: dict[str, RowEvidence] = {}

    def step(
        self,
        tick: int,
        command: float,
        readings: Sequence[Measurement],
        said: Mapping[str, Innovation],
        *,
        unjudged: Collection[str] = (),
    ) -> None:
        """Take in a tick.

        Parameters
        ----------
        tick : number
        command : of the tick before, in the terms of its model, without the mean payout's share
        readings : in its terms
        said : innovations of the active filter in this tick
        unjudged : measurements that say nothing of who is right
        """
        known = self._estimator.measurements
        self._estimator.step(tick, command, [reading for reading in readings if reading.name in known])
        elapsed = tick - self._first - round(self._settling / self._dt)
        if elapsed <= 0:
            return
        for name, mine in self._estimator.innovations.items():
            other = said.get(name)
            if name in unjudged or other is None or not math.isfinite(mine.nis + other.nis):
                continue
            self._rows.setdefault(name, RowEvidence()).add(other, mine)
        if elapsed % self._block == 0:
            for row in self._rows.values():
                row.close()

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
