"""The Kalman filter: several rates, late readings put where they belong in time, missing samples, gates, covariance.

A reading is used at the tick it was measured: the filter keeps its recent past, goes back to that tick, takes the
reading in, and runs forward again with everything it knew. The estimate is then what it would have been had the
reading come at once. The filter of one step is one of `kalman`.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel

from winch_controller_node.model.kalman import IMPLEMENTATIONS, StepFilter


@dataclass(frozen=True)
class MeasurementModel:
    """One scalar measurement of the state: value = (1 + scale) row x + noise.

    Attributes
    ----------
    name : of the measurement (row of the innovation arrays); sensor : it belongs to
    row : shape (n,)
    sigma : standard deviation of its noise
    scale_state : index of the state that is its relative scale error; None: no such state
    is_gated : False: never refused for being far off its prediction. It is for a sensor that is right where the model
        is not (an encoder against a winch of unknown lags) and that has a gate of its own
    """

    name: str
    sensor: str
    row: Array
    sigma: float
    scale_state: int | None = None
    is_gated: bool = True


@dataclass(frozen=True, slots=True)
class Measurement:
    """One reading for the filter.

    Attributes
    ----------
    name : of a MeasurementModel
    value : in its unit, about the same mean as the state
    tick : at which it was measured (its stamp over the tick period, to the nearest tick)
    offset : how much later than that tick, in ticks, -0.5 to 0.5
    sigma : stated standard deviation; None: that of the model
    regressors : further weights of states for this reading, by state name (lever arm: pitch and roll)
    """

    name: str
    value: float
    tick: int
    sigma: float | None = None
    offset: float = 0.0
    regressors: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Innovation:
    """What a reading said against the prediction.

    Attributes
    ----------
    value : measurement minus prediction; sigma : predicted standard deviation of it
    nis : normalised innovation squared (value/sigma)^2
    accepted : it was used; refused readings lie outside the gate, or were too old
    """

    value: float
    sigma: float
    nis: float
    accepted: bool


@dataclass
class _Tick:
    """What the filter keeps of one tick: the prediction for it, the readings used, the command that followed."""

    tick: int
    x: Array
    P: Array
    readings: list[Measurement]
    command: float = 0.0


_Linear = tuple[Measurement, Array, float]
"""A reading, its row and its prediction at the estimate that it was linearised at."""


class KalmanEstimator:
    """Estimates the state of a sampled model at every tick.

    Parameters
    ----------
    model : sampled model with one input; its noise covariance is that of a tick
    measurements : what can be measured
    initial_covariance : shape (n, n)
    gate : normalised innovation squared above which a reading of a gated measurement is refused
    gate_limit : refusals in a row after which the next reading is taken, and the initial covariance added
    largest_age : ticks; older readings are refused
    implementation : of the filter of one step: "compiled", or "filterpy" for the reference

    `estimate`, shape (n,), and `covariance`, shape (n, n), are those after the last step; `innovations` those of the
    readings given to it, by name (the newest of each); `streams` the innovation of the last accepted reading, by name:
    what continues it is believed.
    """

    def __init__(
        self,
        model: LinearModel,
        measurements: Sequence[MeasurementModel],
        initial_covariance: Array,
        *,
        gate: float = 25.0,
        gate_limit: int = 100,
        largest_age: int = 20,
        implementation: str = "compiled",
    ) -> None:
        self.model = model
        self.measurements = {measurement.name: measurement for measurement in measurements}
        self._initial_covariance = initial_covariance
        self._gate = gate
        self._gate_limit = gate_limit
        self._past: deque[_Tick] = deque(maxlen=largest_age + 1)
        self._filter: StepFilter = IMPLEMENTATIONS[implementation](model.order)
        self.innovations: dict[str, Innovation] = {}
        self.refusals: dict[str, int] = dict.fromkeys(self.measurements, 0)
        self.streams: dict[str, float] = {}
        self.set_model(model)
        self.reset()

    @property
    def estimate(self) -> Array:
        """State estimate, shape (n,)."""
        return self._filter.x

    @property
    def covariance(self) -> Array:
        """Covariance of the estimate, shape (n, n)."""
        return self._filter.P

    @property
    def tick(self) -> int | None:
        """Tick of the estimate; None before the first."""
        return self._past[-1].tick if self._past else None

    def value(self, output: str) -> float:
        """Return the estimate of an output of the model."""
        return float(self.model.row(output) @ self.estimate)

    def row_of(self, reading: Measurement) -> Array:
        """Return the row of a reading, shape (n,), on the state of its tick: by the model where it lies between ticks.

        Newton's formula over two ticks ahead; what a command changes within them is left to its delay.
        """
        known, offset = self.measurements.get(reading.name), reading.offset
        # what is only witnessed is an output of the model
        row = self.model.row(reading.name) if known is None else known.row
        if offset == 0.0:
            return row
        change = row @ self.model.A - row
        bend = change @ self.model.A - change
        return np.asarray(row + offset * change + 0.5 * offset * (offset - 1.0) * bend)

    def set_model(self, model: LinearModel, measurements: Sequence[MeasurementModel] | None = None) -> None:
        """Go on with another model of the same states (gain schedule); the estimate stays.

        `measurements` of the new model; None: the present ones.

        Raises ValueError for a model with other states.
        """
        if model.state_names != self.model.state_names:
            raise ValueError("a model with different states needs a new estimator")
        self.model = model
        if measurements is not None:
            self.measurements = {measurement.name: measurement for measurement in measurements}
        self._filter.set_model(model.A, model.B, model.noise_covariance)

    def set_process_noise(self, covariance: Array) -> None:
        """Use another covariance of the process noise of a tick, shape (n, n), until the next model."""
        self._filter.set_model(self.model.A, self.model.B, covariance)

    def set_step(self, transition: Array, command: Array, covariance: Array) -> None:
        """Take ticks with other matrices than the model's, until the next model or process noise.

        `transition` and `covariance` of the process noise of a tick, shape (n, n); `command` multiplies the input,
        shape (n, 1).
        """
        self._filter.set_model(transition, command, covariance)

    def reset(
        self,
        estimate: Array | None = None,
        covariance: Array | None = None,
        streams: Mapping[str, float] | None = None,
    ) -> None:
        """Begin anew at `estimate` (default: zero) with `covariance` (default: the initial one).

        `streams` are those of an estimator that this one takes the place of.
        """
        n = self.model.order
        self._filter.set_state(
            np.zeros(n) if estimate is None else np.array(estimate, dtype=float),
            np.array(self._initial_covariance if covariance is None else covariance, dtype=float),
        )
        self._past.clear()
        self.innovations = {}
        self.refusals = dict.fromkeys(self.measurements, 0)
        self.streams = dict(streams or {})

    def step(self, tick: int, command: float, readings: Sequence[Measurement]) -> Array:
        """Advance to `tick` and take in the readings delivered at it; return the estimate, shape (n,).

        Parameters
        ----------
        tick : of the estimate; ticks left out are predicted over
        command : given at the tick before (and held, should ticks be left out)
        readings : delivered at this tick, of this tick or an earlier one; a value that is not finite is refused

        Raises
        ------
        ValueError : `tick` is not after the last one.
        KeyError : a reading of an unknown name.
        """
        self._advance(tick, command)
        self.innovations = {}
        by_tick: dict[int, list[Measurement]] = {}
        for reading in readings:
            by_tick.setdefault(min(reading.tick, tick), []).append(reading)
        for measured in sorted(by_tick):
            self._take(measured, by_tick[measured])
        return self.estimate

    def _advance(self, tick: int, command: float) -> None:
        if self._past:
            last = self._past[-1]
            if tick <= last.tick:
                raise ValueError(f"estimator: tick {tick} is not after the last one, {last.tick}")
            for between in range(last.tick + 1, tick + 1):
                self._past[-1].command = command
                self._filter.predict(command)
                self._past.append(_Tick(between, self._filter.x, self._filter.P, []))
            return
        self._past.append(_Tick(tick, self._filter.x, self._filter.P, []))

    def _take(self, tick: int, readings: Sequence[Measurement]) -> None:
        """Take in the readings measured at `tick`, and run forward again to the present."""
        age = self._past[-1].tick - tick
        if age >= len(self._past) or age < 0:
            for reading in readings:
                self.innovations[reading.name] = Innovation(math.nan, math.nan, math.nan, False)
            return
        index = len(self._past) - 1 - age
        entry = self._past[index]
        if age > 0:
            self._filter.set_state(entry.x, entry.P)
            self._update(self._linearised(entry.readings))
        accepted = [linear for linear in self._linearised(readings) if self._passes(*linear)]
        self._update(accepted)
        entry.readings.extend(reading for reading, _, _ in accepted)
        for i in range(index + 1, len(self._past)):
            self._filter.predict(self._past[i - 1].command)
            self._past[i].x, self._past[i].P = self._filter.x, self._filter.P
            self._update(self._linearised(self._past[i].readings))

    def _passes(self, reading: Measurement, row: Array, predicted: float) -> bool:
        """Compare a reading with its prediction, note the innovation, and say whether it may be used."""
        measurement = self.measurements[reading.name]
        variance = float(row @ self._filter.P @ row) + (reading.sigma or measurement.sigma) ** 2
        innovation = reading.value - predicted
        nis = innovation * innovation / variance  # a power would raise OverflowError for a number that is absurd
        # a stream that goes on where its last reading was says something of the model, not of the sensor
        step = innovation - self.streams.get(reading.name, 0.0)
        is_stream = reading.name in self.streams and step * step <= 2.0 * self._gate * variance
        accepted = bool(nis <= self._gate) or ((is_stream or not measurement.is_gated) and math.isfinite(nis))
        self.innovations[reading.name] = Innovation(innovation, math.sqrt(variance), nis, accepted)
        if accepted:
            self.streams[reading.name] = innovation
        self.refusals[reading.name] = 0 if accepted else self.refusals[reading.name] + 1
        if self.refusals[reading.name] > self._gate_limit and math.isfinite(nis):
            # that many in a row: it is the filter that is wrong, and its covariance must be large enough to come back
            self._filter.set_state(self._filter.x, self._filter.P + self._initial_covariance)
            self.refusals[reading.name] = 0
            self.streams[reading.name] = innovation
            return True
        return accepted

    def _linearised(self, readings: Sequence[Measurement]) -> list[_Linear]:
        """Return each of the readings with its row at the present estimate, and with its prediction."""
        return [(reading, *self._linearise(reading)) for reading in readings]

    def _linearise(self, reading: Measurement) -> tuple[Array, float]:
        measurement, x = self.measurements[reading.name], self._filter.x
        row = self.row_of(reading)
        if measurement.scale_state is None and not reading.regressors:
            return row, float(row @ x)
        row = row.copy()
        for name, weight in reading.regressors.items():
            if self.model.has_state(name):
                row[self.model.state(name)] += weight
        plain = float(row @ x)
        if measurement.scale_state is None:
            return row, plain
        scale = 1.0 + float(x[measurement.scale_state])
        row *= scale
        row[measurement.scale_state] += plain
        return row, scale * plain

    def _update(self, readings: Sequence[_Linear]) -> None:
        """Take in readings of one tick together, each with its row and prediction at the present estimate."""
        if not readings:
            return
        kalman = self._filter
        # the filter predicts H x; a bilinear measurement predicts something else
        z = [reading.value - predicted + float(row @ kalman.x) for reading, row, predicted in readings]
        variances = [(reading.sigma or self.measurements[reading.name].sigma) ** 2 for reading, _, _ in readings]
        kalman.correct(np.array(z), np.array([row for _, row, _ in readings]), np.array(variances))
