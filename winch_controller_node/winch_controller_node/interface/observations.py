"""What the core observed in a batch of ticks: orders, readings as gated, the winch's word; the adviser's question."""

from __future__ import annotations

from dataclasses import dataclass

from heave_node.numerics.arrays import Array

BATCH = 1.0
"""Length of a batch [s]."""

TICK_COLUMNS = (
    "command",  # compensating share of the command of the tick before, in the terms of the model
    "order_payout",  # payout set-point given at the tick before [m]
    "order_rate",  # payout-rate set-point given at the tick before [m/s]
    "sequence",  # number of that order
    "brake",  # of that order, 0 or 1
    "encoder",  # encoder reading at the tick, jumps taken off, as read (no scale) [m]; NaN: none
    "taken",  # number of the newest order in effect at the tick, as the winch says; NaN: no state came
    "limits_hit",  # heave_node.interface.codes.WinchLimit; 0: none
    "tension",  # at the top, the newest that the load cell read [N]; NaN: none yet
    "authority",  # authority of compensation [-]
    "compensates",  # mode compensating, 0 or 1
    "tip_heave",  # estimated heave of the boom tip [m]
    "tip_rate",  # and its rate [m/s]
    "unit_rate",  # estimated heave rate of the unit, without the mean payout's share [m/s]
    "missing_push",  # by how much more a linear cable would push the unit down than a slack one does [m]
)
"""Columns of the table of ticks."""

READING_COLUMNS = (
    "delivered",  # tick at which it was delivered
    "tick",  # to which it belongs
    "row",  # index in `rows`
    "value",  # as read about its zero, in the sign of the model; assumed corrections not applied
    "share",  # of it that the mean payout brings about
    "offset",  # how much later than its tick it was measured [ticks]
    "sigma",  # standard deviation of its noise
    "is_used",  # 1: the estimator took it; 0: a cross-check
    "nis",  # normalised innovation squared; NaN: not compared
)
"""Columns of the table of readings."""


@dataclass(frozen=True, eq=False)
class Observations:
    """A batch of ticks."""

    first: int  # number of its first tick
    ticks: Array  # table, a row a tick, shape (t, len(TICK_COLUMNS))
    rows: tuple[str, ...]  # names of the measurements that readings refer to
    readings: Array  # table, in the order of delivery, shape (m, len(READING_COLUMNS))
    epoch: int  # tick with which the record begins: the state jumped there, or the mean, or the controller was started
    beliefs: int  # number of the active beliefs at the end of the batch
    excluded: str = ""  # sensor that a reflex of the core has set aside; empty: none
    is_trusted: bool = True  # depth sensor and estimate agree, as the guard sees it
    # parameters that an operator's redesigns have restated since the start, by path
    restated: tuple[tuple[str, float], ...] = ()

    @property
    def last(self) -> int:
        """Number of its last tick."""
        return self.first + len(self.ticks) - 1
