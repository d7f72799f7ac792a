"""A record in columns: as read, and what each sensor alone has read, stepped or changed by, from some onsets on."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from heave_node.numerics.arrays import Array

from winch_controller_node.adviser.filter_pass import PassInput
from winch_controller_node.adviser.record import OFFSET, ROW, SHARE, SIGMA, TICK, Excerpt, SensorHistory
from winch_controller_node.beliefs.quantities import DEPTH_SCALE, ENCODER_SCALE, MRU_DELAY, MRU_OFFSET, MRU_SCALE
from winch_controller_node.model.estimator import MeasurementModel

ONSETS = (42.0, 29.0, 20.0, 14.0, 10.0, 7.0, 5.0)
"""Times before the end of the record, beside all of it, since when a sensor may be at fault [s]: fine, for its size."""

FACTOR, STEP, DELAY = "scale", "offset", "delay"
"""Kinds of column: what a sensor alone has read (its size is a factor on it less 1), 1 (an offset that is taken off),
and the slope of what it has read (a delay that is made up for)."""

SLOPE_OVER = 0.4
"""Time over which readings tell by how much they change [s]: a small part of a wave."""

TINY = 1e-12
"""Least divisor: readings of one and the same moment tell no slope, a column without information no weight."""

JUDGED = {
    "mru": {FACTOR: MRU_SCALE, STEP: MRU_OFFSET, DELAY: MRU_DELAY},
    "depth": {FACTOR: DEPTH_SCALE},
    "encoder": {FACTOR: ENCODER_SCALE},
}
"""Kinds of column of each sensor, with the quantity that it shows."""


@dataclass(frozen=True)
class Columns:
    """A record in columns."""

    data: PassInput  # as a pass takes it
    index: dict[tuple[str, str, int], int]  # of the column of a sensor, a kind and an onset
    onsets: tuple[int, ...]  # first tick of each onset


def in_columns(
    excerpt: Excerpt,
    measurements: tuple[MeasurementModel, ...],
    history: SensorHistory,
    onsets: tuple[float, ...] = ONSETS,
    judged: Mapping[str, Iterable[str]] = JUDGED,
) -> Columns:
    """Return a record in columns.

    Parameters
    ----------
    excerpt : with the readings of `measurements` only, numbered as there
    measurements : of the model
    history : assumed corrections of the sensors over the record; present delays are compensated
    onsets : times before its end [s]
    judged : kinds of column of each sensor; without any there is the record as it is alone
    """
    readings, dt = excerpt.readings, excerpt.dt
    value = excerpt.corrected(history)
    time = readings[:, TICK] + readings[:, OFFSET]
    delays = np.zeros(len(readings))
    for sensor, since, correction in history.corrections:
        delays[excerpt.is_of(sensor) & (readings[:, TICK] >= since)] = correction.delay / dt
    firsts = (excerpt.first, *(excerpt.last - round(onset / dt) for onset in onsets))
    firsts = tuple(dict.fromkeys(max(first, excerpt.first) for first in firsts))
    as_read = value - readings[:, SHARE]
    columns, index = [as_read + delays * _slope(excerpt, value, time) if np.any(delays) else as_read], {}
    for sensor, kinds in judged.items():
        mine = excerpt.is_of(sensor)
        if not np.any(mine):
            continue
        for kind in kinds:
            alone = np.where(mine, _column(excerpt, kind, value, time), 0.0)
            # one that changes on the way is seen by the drum, which was not ordered to jump
            for first in firsts[:1] if sensor == "encoder" else firsts:
                late = mine & (readings[:, TICK] >= first)
                # a scale of the encoder counts from where the drum stood when it began
                begin = alone[late][0] if sensor == "encoder" and np.any(late) else 0.0
                index[sensor, kind, first] = len(columns)
                columns.append(np.where(late, alone - begin, 0.0))
    values = np.ascontiguousarray(np.array(columns).T)
    commands = np.zeros((len(excerpt.ticks), values.shape[1]))
    commands[1:, 0] = excerpt.tick_column("command")[1:]
    numbers = np.arange(excerpt.first, excerpt.last + 1)
    sigmas = np.array([known.sigma for known in measurements])[readings[:, ROW].astype(np.int64)]
    sigmas = np.where(np.isfinite(readings[:, SIGMA]), readings[:, SIGMA], sigmas)
    data = PassInput(
        commands=commands,
        ends=np.searchsorted(readings[:, TICK], numbers, side="right").astype(np.int64),
        which=readings[:, ROW].astype(np.int64),
        offsets=readings[:, OFFSET].copy(),
        variances=sigmas**2,
        values=values,
        unit_speed=np.abs(_before(excerpt.tick_column("unit_rate"))),
        missing_push=_before(excerpt.tick_column("missing_push")),
    )
    return Columns(data, index, firsts)


def _before(column: Array) -> Array:
    """Return a `column` as it was a tick before: a step goes by the state that it begins with."""
    return np.concatenate([column[:1], column[:-1]])


def _column(excerpt: Excerpt, kind: str, value: Array, time: Array) -> Array:
    if kind == FACTOR:
        return value
    if kind == DELAY:
        return _slope(excerpt, value, time)
    return np.where(excerpt.is_row("mru_heave"), 1.0, 0.0)


def _slope(excerpt: Excerpt, value: Array, time: Array) -> Array:
    """Return by how much each measurement changes in a tick at each of its readings: of a line through those about it.

    The difference of two readings would have more of their noise than of the motion.
    """
    slope, about = np.zeros(len(value)), np.ones(1 + 2 * round(0.5 * SLOPE_OVER / excerpt.dt))
    for row in range(len(excerpt.rows)):
        mine = excerpt.readings[:, ROW] == row
        if np.count_nonzero(mine) < len(about):
            continue
        t, z = time[mine] - time[mine][0], value[mine] - value[mine][0]
        count, mean_t, mean_z, squares, products = (
            np.convolve(one, about, mode="same") for one in (np.ones(len(t)), t, z, t * t, t * z)
        )
        slope[mine] = (count * products - mean_t * mean_z) / np.maximum(count * squares - mean_t**2, TINY)
    return slope
