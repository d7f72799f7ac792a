"""The estimator's terms: a gated reading about its zero, corrected, without what the mean payout brings about."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

from heave_node.numerics.arrays import Array

from winch_controller_node.beliefs.corrections import AS_READ, Correction
from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.interface.sensors import MeasurementRow, SensorModelParameters, SensorsModelParameters, Zero
from winch_controller_node.model.estimator import KalmanEstimator, Measurement

ON_TICK = 1e-4
"""A stamp that is off its tick by a smaller share of the tick period is on it."""

REMEMBERED = 64
"""Ticks for which the mean payout's share is kept, for readings that come late."""

HAS_OFFSET = "mru_heave"
"""Measurement of which an offset is taken off: that of a motion reference unit is in its heave alone."""


class SensorsWatched(NamedTuple):
    """The sensors that have a gate, by name.

    Attributes
    ----------
    in_use : whose readings the estimator takes
    watched : these, and those that are always watched
    rows_of : measurements that the estimator takes of each
    row, sensor_of : each row by its name, and its sensor
    """

    in_use: dict[str, SensorModelParameters]
    watched: dict[str, SensorModelParameters]
    rows_of: dict[str, tuple[MeasurementRow, ...]]
    row: dict[str, MeasurementRow]
    sensor_of: dict[str, str]

    @classmethod
    def of(cls, sensors: SensorsModelParameters) -> SensorsWatched:
        """Return those of the controller's parameters of its `sensors`."""
        in_use = sensors.in_use()
        watched = {name: one for name, one in sensors.by_name().items() if name in in_use or one.is_always_watched}
        rows_of = {name: one.rows() for name, one in watched.items()}
        named = [(name, row) for name, rows in rows_of.items() for row in rows]
        return cls(
            in_use, watched, rows_of, {row.name: row for _, row in named}, {row.name: name for name, row in named}
        )


class ReadingTerms:
    """Puts readings into the estimator's terms.

    Parameters
    ----------
    design : the active one, for its cable
    sensors : that are watched

    Attributes
    ----------
    stretch_per_payout : how much further than paid out the unit goes down at rest: stretch of the new cable [-]
    """

    def __init__(self, design: ControllerDesign, sensors: SensorsWatched) -> None:
        self._dt = design.tick_period
        self._sensors = sensors
        self._corrections: dict[str, Correction] = {}
        self._zeros: dict[str, float] = {}
        self._first_heave = 0.0
        self._shares: deque[tuple[int, Array]] = deque(maxlen=REMEMBERED)
        self.take_design(design)

    def take_design(self, design: ControllerDesign) -> None:
        """Refer to the cable of a design from now on."""
        cable = design.cable
        self._static_tension = cable.static_tension
        self.stretch_per_payout = cable.static_tension / (cable.stiffness * design.length)

    def begin_at(self, payout: float) -> None:
        """Take the unit to have hung on a `payout` [m] that is not 0 when its depth was first read."""
        self.reset_shares()
        self._first_heave = -payout * (1.0 + self.stretch_per_payout)
        for name, zero in self._zeros.items():
            self._zeros[name] = self._zero_from(zero, self._sensors.watched[name])

    def correct(self, corrections: dict[str, Correction]) -> None:
        """Correct readings by `corrections`, by sensor, from now on."""
        self._corrections = corrections

    def remember_share(self, tick: int, mean_state: Array) -> None:
        """Note the state of the mean payout's own motion at `tick`, `mean_state`, shape (n,)."""
        self._shares.append((tick, mean_state))

    def reset_shares(self) -> None:
        """Discard the shares noted so far: the states are counted otherwise from now on."""
        self._shares.clear()

    @property
    def depth_zero(self) -> float | None:
        """Depth that counts as heave zero [m]; None before the first reading."""
        return self._zeros.get("depth")

    def zero(self, name: str, value: float) -> float:
        """Return what the sensor `name` counts from where it reads `value`, in its unit."""
        sensor = self._sensors.watched[name]
        if sensor.zero is Zero.FIRST_READING:
            return self._zeros.setdefault(name, self._zero_from(value, sensor))
        return self._static_tension if sensor.zero is Zero.STATIC_TENSION else 0.0

    def _zero_from(self, first: float, sensor: SensorModelParameters) -> float:
        """Return what the readings of a `sensor` count from, of which this is the `first`."""
        return first - sensor.sign * self._first_heave

    def corrected(self, reading: Measurement, share: float) -> Measurement:
        """Return a `reading` about its zero with what is wrong with it and the mean payout's `share` taken off."""
        correction = self._corrections.get(self._sensors.sensor_of[reading.name], AS_READ)
        offset = correction.offset if reading.name == HAS_OFFSET else 0.0
        value = (reading.value - offset) / correction.scale - share
        if correction.delay == 0.0:
            return reading._replace(value=value)
        tick, ahead = tick_of((reading.tick + reading.offset) * self._dt - correction.delay, self._dt)
        return reading._replace(value=value, tick=tick, offset=ahead)

    def share_of(self, reading: Measurement, estimator: KalmanEstimator) -> float:
        """Return the mean payout's share in a reading, at its time, by the rows of the `estimator`."""
        sensor = self._sensors.sensor_of[reading.name]
        if not self._shares or self._sensors.watched[sensor].sees == "boom_tip":
            return 0.0
        newest, state = self._shares[-1]
        if newest > reading.tick:
            noted = (share for tick, share in reversed(self._shares) if tick <= reading.tick)
            state = next(noted, self._shares[0][1])
        share = float(estimator.row_of(reading) @ state)
        if self._sensors.row[reading.name].output == "unit_heave":
            share -= self.stretch_per_payout * float(estimator.model.row("payout") @ state)
        return share


def tick_of(time: float, tick_period: float) -> tuple[int, float]:
    """Return the tick nearest to a `time` [s], and how much later than it that is, in ticks of a `tick_period` [s]."""
    tick = round(time / tick_period)
    offset = time / tick_period - tick
    return tick, offset if abs(offset) > ON_TICK else 0.0
