"""Observations for the adviser, a batch a second: what was ordered, read and said in each tick."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache

import numpy as np
from heave_node.numerics.arrays import Array

from winch_controller_node.core.estimation.sense_design import ROWS
from winch_controller_node.interface.observations import BATCH, READING_COLUMNS, TICK_COLUMNS, Observations


class ObservationLog:
    """Collects ticks into batches.

    `tick_period` : [s]
    """

    def __init__(self, tick_period: float) -> None:
        self._batch = max(1, round(BATCH / tick_period))
        self._ticks: list[Sequence[float]] = []
        self._readings: list[Array] = []
        # tick with which the record begins: readings before and after do not belong together, nor do those before and
        # after the controller was restarted
        self._first = self.epoch = 0
        self._is_broken = True

    def break_record(self) -> None:
        """Begin another record: the state has jumped, or counts from another mean."""
        self._is_broken = True
        self._ticks, self._readings = [], []

    def add(self, number: int, row: Sequence[float], readings: Array) -> None:
        """Take a tick in: its `number`, its `row` by TICK_COLUMNS, and its `readings`, by rows of OBSERVED."""
        if not self._ticks:
            self._first = number
            self.epoch, self._is_broken = (self._first if self._is_broken else self.epoch), False
        self._ticks.append(row)
        self._readings.append(readings[:, : len(READING_COLUMNS)])

    @property
    def is_complete(self) -> bool:
        """Tell whether a batch is."""
        return len(self._ticks) >= self._batch

    def batch(
        self, beliefs: int, *, excluded: str, is_trusted: bool, restated: tuple[tuple[str, float], ...] = ()
    ) -> Callable[[], Observations]:
        """Return what makes the batch that is complete, when it is read; the next one begins.

        Parameters
        ----------
        beliefs : number of the active ones
        excluded : sensor that has been set aside
        is_trusted : depth sensor and estimate agree
        restated : parameters that an operator has restated
        """
        first, epoch, ticks, readings = self._first, self.epoch, self._ticks, self._readings
        self._ticks, self._readings = [], []

        @cache
        def batch() -> Observations:
            table, read = np.array(ticks).reshape(-1, len(TICK_COLUMNS)), np.concatenate(readings)
            return Observations(first, table, ROWS, read, epoch, beliefs, excluded, is_trusted, restated)

        return batch
