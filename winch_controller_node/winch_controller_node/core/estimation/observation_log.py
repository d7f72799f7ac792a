"""Observations for the adviser, a batch a second: what was ordered, read and said in each tick."""

from __future__ import annotations

import math

import numpy as np
from heave_node.interface.codes import WinchFault
from heave_node.numerics.arrays import Array

from winch_controller_node.core.estimation.loop_tick import LoopTick
from winch_controller_node.core.estimation.observation import Observer
from winch_controller_node.core.estimation.sense_design import ROWS
from winch_controller_node.interface.observations import BATCH, READING_COLUMNS, TICK_COLUMNS, Observations
from winch_controller_node.interface.readings import WinchOrder, WinchReading


class ObservationLog:
    """Collects ticks into batches.

    `tick_period` : [s]
    """

    def __init__(self, tick_period: float) -> None:
        self._batch = max(1, round(BATCH / tick_period))
        self._ticks: list[tuple[float, ...]] = []
        self._readings: list[Array] = []
        # tick with which the record begins: readings before and after do not belong together, nor do those before and
        # after the controller was restarted
        self._first = self.epoch = 0
        self._is_broken = True

    def break_record(self) -> None:
        """Begin another record: the state has jumped, or counts from another mean."""
        self._is_broken = True
        self._ticks, self._readings = [], []

    def add(
        self,
        loop: LoopTick,
        observer: Observer,
        order: WinchOrder | None,
        winch: WinchReading | None,
        *,
        authority: float,
        compensates: bool,
    ) -> None:
        """Take a tick in.

        Parameters
        ----------
        loop : what is known of it; its command is that of the tick before
        observer : with the readings of the tick
        order : of the tick before; None: none yet
        winch : the winch's own report at the tick; None: nothing came
        authority : authority of compensation
        compensates : the mode is compensating
        """
        if not self._ticks:
            self._first = int(loop.number)
            self.epoch, self._is_broken = (self._first if self._is_broken else self.epoch), False
        sequence, payout, rate, brake, _ = WinchOrder(0, 0.0, 0.0, True) if order is None else order
        brake = brake or (winch is not None and (winch.brake or winch.fault != WinchFault.NONE))
        encoder = math.nan if math.isnan(loop.encoder_payout) else observer.encoder.as_read
        taken, limits = (math.nan, 0) if winch is None else (winch.command_sequence, winch.limits_hit)
        self._ticks.append(
            (
                *(loop.compensating, payout, rate, sequence, brake, encoder, taken, limits),
                *(
                    loop.tension,
                    authority,
                    compensates,
                    loop.tip,
                    loop.tip_rate,
                    loop.estimate[loop.rows.unit_states[1]],
                    loop.missing_push,
                ),
            )
        )
        self._readings.append(loop.observed[:, : len(READING_COLUMNS)])

    def batch(
        self, beliefs: int, *, excluded: str, is_trusted: bool, restated: tuple[tuple[str, float], ...] = ()
    ) -> Observations | None:
        """Return the batch that is complete, once; None: it is not.

        Parameters
        ----------
        beliefs : number of the active ones
        excluded : sensor that has been set aside
        is_trusted : depth sensor and estimate agree
        restated : parameters that an operator has restated
        """
        if len(self._ticks) < self._batch:
            return None
        ticks = np.array(self._ticks, dtype=float).reshape(-1, len(TICK_COLUMNS))
        readings = np.concatenate(self._readings)
        self._ticks, self._readings = [], []
        return Observations(self._first, ticks, ROWS, readings, self.epoch, beliefs, excluded, is_trusted, restated)
