"""The Kalman filter: several rates, late readings put where they belong in time, missing samples, gates, covariance.

A reading is used at the tick it was measured: the filter keeps its recent past, goes back to that tick, takes the
reading in, and runs forward again with everything it knew. The estimate is then what it would have been had the
reading come at once.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from operator import itemgetter
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from heave_core.filter import Drag, FilterModel, Gate, KalmanFilter, Slack, no_slack
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel

NO_REGRESSORS: Mapping[str, float] = MappingProxyType({})

MOST_REGRESSORS = 2
"""Most further weights of a reading."""

NO_WEIGHTS = (-1.0, 0.0, -1.0, 0.0)
"""Columns of the further weights of a reading that has none."""


@dataclass(frozen=True, eq=False)
class MeasurementModel:
    """One scalar measurement of the state: value = (1 + scale) row x + noise."""

    name: str  # of the measurement (row of the innovation arrays)
    sensor: str  # it belongs to
    row: Array  # shape (n,)
    sigma: float  # standard deviation of its noise, in its unit
    scale_state: int | None = None  # index of the state that is its relative scale error; None: no such state
    # False: never refused for being far off its prediction. It is for a sensor that is right where the model is not (an
    # encoder against a winch of unknown lags) and that has a gate of its own
    is_gated: bool = True


class Measurement(NamedTuple):
    """One reading for the filter."""

    name: str  # of a MeasurementModel
    value: float  # in its unit, about the same mean as the state
    tick: int  # at which it was measured (its stamp over the tick period, to the nearest tick)
    sigma: float | None = None  # stated standard deviation, in its unit; None: that of the model
    offset: float = 0.0  # how much later than that tick, -0.5 to 0.5 [ticks]
    # further weights of up to two states for this reading, by state name (lever arm: pitch and roll)
    regressors: Mapping[str, float] = NO_REGRESSORS


class Innovation(NamedTuple):
    """What a reading said against the prediction."""

    value: float  # measurement minus prediction, in its unit
    sigma: float  # predicted standard deviation of it, in its unit
    nis: float  # normalised innovation squared (value/sigma)^2 [-]
    accepted: bool  # it was used; refused readings lie outside the gate, or were too old


class RecordedTick(NamedTuple):
    """Inputs of the estimator at a tick."""

    number: int  # of the tick
    command: float  # of the tick before, in its unit
    readings: Sequence[Measurement]  # delivered at it


def begin_anew(covariance: Array, state: int, sigma: float) -> None:
    """Let a `state` be off by `sigma`, 1 standard deviation, in a `covariance`, shape (n, n), and go with no other."""
    covariance[state, :] = covariance[:, state] = 0.0
    covariance[state, state] = sigma**2


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
    drag : of the unit, whose damping then follows the speed it is seen to have; None: that of the model alone
    slack : of the cable, which then pulls the unit no further down than that sinks; None: it always pulls

    `estimate`, shape (n,), and `covariance`, shape (n, n), are those after the last step; `innovations` those of the
    readings given to it, by name (the newest of each).
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
        drag: Drag | None = None,
        slack: Slack | None = None,
    ) -> None:
        self._gate = Gate(gate, gate_limit, np.ascontiguousarray(initial_covariance, dtype=float))
        self._kept = largest_age + 1
        self.innovations: dict[str, Innovation] = {}
        self._refer_to(model, measurements, drag, slack)
        at = np.zeros(model.order), self._gate.added
        self.kalman = KalmanFilter(self._filter_model, self._gate, self._kept, *at)  # the filter of the core

    @property
    def estimate(self) -> Array:
        """State estimate, shape (n,)."""
        return self.kalman.x

    @property
    def covariance(self) -> Array:
        """Covariance of the estimate, shape (n, n)."""
        return self.kalman.P

    @property
    def missing_push(self) -> float:
        """How much further down the model pushes the unit at the estimate than a slack cable does [m]."""
        return self.kalman.missing_push

    @property
    def tick(self) -> int | None:
        """Tick of the estimate; None before the first."""
        return self.kalman.tick

    @property
    def streams(self) -> dict[str, float]:
        """Innovation of the last accepted reading, by name: a reading that continues it is accepted."""
        found = zip(self.measurements, self.kalman.streams.tolist(), strict=True)
        return {name: stream for name, stream in found if not math.isnan(stream)}

    @property
    def refusals(self) -> dict[str, int]:
        """Number of readings that were refused in a row, by name."""
        return dict(zip(self.measurements, self.kalman.refusals.tolist(), strict=True))

    def value(self, output: str) -> float:
        """Return the estimate of an output of the model."""
        return float(self.model.row(output) @ self.estimate)

    def _refer_to(
        self, model: LinearModel, measurements: Sequence[MeasurementModel], drag: Drag | None, slack: Slack | None
    ) -> None:
        self.model = model
        self.measurements = {measurement.name: measurement for measurement in measurements}
        self._which = {name: index for index, name in enumerate(self.measurements)}
        self._sigmas = [measurement.sigma for measurement in measurements]
        self._names = list(self.measurements)
        self._places = {name: index for index, name in enumerate(model.state_names)}
        differences = [row_with_differences(measurement.row, model) for measurement in measurements]
        rows, changes, bends = np.array(differences).reshape(-1, 3, model.order).transpose(1, 0, 2).copy()
        scale_states = [-1 if known.scale_state is None else known.scale_state for known in measurements]
        self._filter_model = FilterModel(
            F=model.A,
            B=model.B[:, 0],
            Q=model.noise_covariance,
            drag=drag or Drag(),
            slack=slack or no_slack(model.order, len(measurements)),
            rows=rows,
            changes=changes,
            bends=bends,
            scale_states=np.array(scale_states, dtype=np.int64),
            is_gated=np.array([known.is_gated for known in measurements], dtype=np.bool_),
        )

    @property
    def process_noise(self) -> Array:
        """Covariance of the process noise of a tick, shape (n, n)."""
        return self._filter_model.Q

    def set_process_noise(self, covariance: Array) -> None:
        """Use another covariance of the process noise of a tick, shape (n, n), until the next model."""
        self._filter_model = self._filter_model._replace(Q=covariance)
        self.kalman.set_noise(covariance)

    def reset(
        self,
        estimate: Array | None = None,
        covariance: Array | None = None,
        streams: Mapping[str, float] | None = None,
    ) -> None:
        """Restart at `estimate` (default: zero) with `covariance` (default: the initial one).

        `streams` are those of an estimator that this one takes the place of.
        """
        at = np.zeros(self.model.order) if estimate is None else estimate
        self.kalman.begin(at, self._gate.added if covariance is None else covariance)
        self.innovations = {}
        for name, stream in (streams or {}).items():
            if name in self._which:
                self.kalman.streams[self._which[name]] = stream

    def continue_at(
        self, tick: int, estimate: Array, covariance: Array, streams: Mapping[str, float] | None = None
    ) -> None:
        """Go on after `tick` from another `estimate`, shape (n,), and `covariance`, shape (n, n).

        `streams` are those of the estimator that this one takes the place of; None: its own.
        """
        self.reset(estimate, covariance, self.streams if streams is None else streams)
        self.step(tick, 0.0, [])

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
        self.follow([RecordedTick(tick, command, readings)])
        return self.estimate

    def follow(self, record: Sequence[RecordedTick]) -> list[dict[str, Innovation]]:
        """Step through a `record` of ticks; return the innovations of each, see `step`."""
        last = self.tick
        for tick in record:
            if last is not None and tick.number <= last:
                raise ValueError(f"estimator: tick {tick.number} is not after the last one, {last}")
            last = tick.number
        ticks: list[tuple[float, ...]] = []
        rows: list[tuple[float, ...]] = []
        for tick in record:
            rows += self._rows(tick)
            ticks.append((tick.number, tick.command, len(rows)))
        said = zip(rows, self.kalman.run(ticks, rows), strict=True)
        names = self._names
        followed = [
            {
                names[int(row[1])]: Innovation(value, sigma, nis, accepted > 0.0)
                for row, (value, sigma, nis, accepted) in islice(said, len(tick.readings))
            }
            for tick in record
        ]
        self.innovations = followed[-1] if followed else {}
        return followed

    def _rows(self, tick: RecordedTick) -> list[tuple[float, ...]]:
        """Return the readings of a `tick` as the filter takes them, by the ticks they were measured at."""
        which, sigmas, number = self._which, self._sigmas, tick.number
        rows = []
        for name, value, measured, sigma, offset, regressors in tick.readings:
            place = which[name]
            variance = (sigma or sigmas[place]) ** 2
            weights = self._weights(name, regressors) if regressors else NO_WEIGHTS
            rows.append((min(measured, number), place, value, offset, variance, *weights))
        rows.sort(key=itemgetter(0))
        return rows

    def _weights(self, name: str, regressors: Mapping[str, float]) -> tuple[float, ...]:
        """Return the `regressors` of the reading `name` that are weights of states, as its last columns."""
        places = self._places
        weights = [number for state in regressors if state in places for number in (places[state], regressors[state])]
        if len(weights) > 2 * MOST_REGRESSORS:
            raise ValueError(
                f"estimator: {name} has {len(weights) // 2} further weights; at most {MOST_REGRESSORS} fit"
            )
        return (*weights, *NO_WEIGHTS[len(weights) :])


def row_with_differences(row: Array, model: LinearModel) -> tuple[Array, Array, Array]:
    """Return a row on the state of a tick, and its first and second differences over the ticks of a `model`.

    Of a reading between two ticks they give the row by Newton's formula over two ticks ahead (filter.cpp).
    """
    change = row @ model.A - row
    return row, change, change @ model.A - change
