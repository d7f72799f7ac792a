"""A filter beside the active one that explains the same readings otherwise, and the evidence for either.

Both predict each reading. The mean squares of their innovations over the last waves, those within the noise left out,
say in nats which of them is right. The second one costs a step of the filter each tick, for as long as it is there.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence

from winch_controller_node.beliefs.beliefs import Adopted
from winch_controller_node.design.design import ControllerDesign, carry_by_name
from winch_controller_node.model.estimator import Innovation, KalmanEstimator, Measurement

MEMORY = 20.0
"""Memory of the mean squares [s]: a wave or two. One independent innovation a second counts."""

SETTLING = 3.0
"""Time from the beginning of the second filter in which nothing is compared [s]."""

LARGEST = 1e4
"""Largest square of one innovation over its noise: a spike says no more."""


class RowEvidence:
    """Mean squares of the innovations of one measurement, of the active filter and of the second one."""

    def __init__(self) -> None:
        self._count = 0
        self._time = self.active = self.second = 0.0

    def add(self, active: Innovation, second: Innovation, elapsed: float) -> None:
        """Take in a reading by the `active` filter and by the `second` one, `elapsed` since the first [s]."""
        self._count += 1
        self._time = elapsed
        weight = max(elapsed / MEMORY, 1.0) / self._count
        noise = max(active.sigma, second.sigma) ** 2
        self.active += weight * (min(active.value**2 / noise, LARGEST) - self.active)
        self.second += weight * (min(second.value**2 / noise, LARGEST) - self.second)

    @property
    def nats(self) -> float:
        """Evidence for the second filter [nats]; negative: for the active one."""
        seconds = min(self._time, MEMORY)
        return 0.5 * seconds * math.log(max(self.active, 1.0) / max(self.second, 1.0))


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
        elapsed = (tick - self._first) * self._dt - self._settling
        if elapsed <= 0.0:
            return
        for name, mine in self._estimator.innovations.items():
            other = said.get(name)
            if name in unjudged or other is None or not math.isfinite(mine.nis + other.nis):
                continue
            self._rows.setdefault(name, RowEvidence()).add(other, mine, elapsed)

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
        return name, math.sqrt(max(self._rows[name].active, 1.0) / max(self._rows[name].second, 1.0))

    def state(self, tick: int) -> Adopted:
        """Return its state after `tick`, to go on from."""
        return Adopted(tick, self._estimator.estimate.copy(), self._estimator.covariance.copy())
