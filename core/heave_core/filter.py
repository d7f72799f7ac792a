"""The Kalman filter of the loop: `src/filter.cpp` on arrays that Python and C++ share; and a pass, `src/pass.cpp`.

It estimates x[k+1] = F x[k] + B u[k] + w, w of covariance Q, from readings that are judged, and taken in at the tick
they were measured at. A pass is one linear filter over a record in many columns, for searches.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from heave_core.filter_table import (
    FILTER,
    FILTER_STATE,
    MEASUREMENTS,
    PASS,
    PAST,
    PAST_TICKS,
    READING,
    SAID,
    STATES,
    USED,
)
from heave_core.library import library, new

Array = NDArray[np.float64]

STREAM_FACTOR = 2.0
"""The step between two innovations has the variance of both."""

UNCERTAINTY = 0.3
"""Standard deviation of the drag that is more than the design's damping, as a share of it: coefficients of bodies that
oscillate are known to a third. So it is with the push of a slack cable that is missing: shocks catch it again."""

UNCERTAINTY_TIME = 1.0
"""Time over which it errs in one direction [s]: a fraction of a wave."""

LEAST_USED = 4
"""Readings of a tick, over the number of measurements, for which there must be a place."""

TOO_MANY = "{count} {what}, and at most {most} fit: {remedy}"


class Drag(NamedTuple):
    """The drag of the unit in a model, by the rows of DRAG in `filter_table`; without any values there is none."""

    rate: int = 0
    inertia: float = 1.0
    damping: float = 0.0
    quadratic: float = 0.0
    tick_period: float = 0.0


class Slack(NamedTuple):
    """When the cable is slack, by the rows of SLACK in `filter_table`: `pull` (n,), `reads` (m,)."""

    pull: Array
    reads: Array
    rate: int = 0
    inertia: float = 1.0
    largest: float = math.inf
    tick_period: float = 0.0


def no_slack(order: int, measurements: int) -> Slack:
    """Return that of a cable that always pulls, for a state of an `order` and a number of `measurements`."""
    return Slack(np.zeros(order), np.zeros(measurements))


class FilterModel(NamedTuple):
    """Model and measurements.

    Attributes
    ----------
    F, B, Q : transition (n, n), input (n,) and covariance of the process noise (n, n) of a tick
    drag, slack : of the unit, and of the cable
    rows, changes, bends : of the measurements at a tick, and their first and second differences over ticks, (m, n)
    scale_states : index of the state that is the relative scale error, (m,); -1: none
    is_gated : refused where it is far off its prediction, (m,)
    """

    F: Array
    B: Array
    Q: Array
    drag: Drag
    slack: Slack
    rows: Array
    changes: Array
    bends: Array
    scale_states: NDArray[np.int64]
    is_gated: NDArray[np.bool_]


class Gate(NamedTuple):
    """When a reading is refused.

    Attributes
    ----------
    threshold : normalised innovation squared above which a reading of a gated measurement is
    limit : refusals in a row after which the next reading is taken
    added : covariance that is added then (n, n)
    """

    threshold: float
    limit: int
    added: Array


def check_states(count: int, where: str) -> None:
    """Refuse a model of more states than fit, `count`, in one line that says `where`."""
    if count > STATES:
        remedy = "use longer ticks, a shorter winch.command_delay or fewer sensors"
        raise ValueError(f"{where}: {TOO_MANY.format(count=count, what='states', most=STATES, remedy=remedy)}")


def check_sizes(states: int, measurements: int, kept: int) -> None:
    """Refuse a model that does not fit, in one line: `states`, `measurements`, and ticks that are `kept`."""
    check_states(states, "estimator")
    most_kept = min(PAST_TICKS, 2 * PAST // (states * (states + 3)), USED // (LEAST_USED * max(measurements, 1)))
    for count, what, most, remedy in (
        (measurements, "measurements", MEASUREMENTS, "use fewer sensors"),
        (kept, f"ticks of {states} states are kept", most_kept, "lower estimator.largest_age"),
    ):
        if count > most:
            raise ValueError(f"estimator: {TOO_MANY.format(count=count, what=what, most=most, remedy=remedy)}")


class KalmanFilter:
    """The filter with its memory; its estimate is that of its newest tick.

    Parameters
    ----------
    model : of the state and its measurements; another one of the same sizes may be set
    gate : for the readings
    kept : number of ticks that it can go back over, with the present one
    x, P : estimate (n,) and covariance (n, n) to begin with

    Attributes
    ----------
    design, state : structured arrays of one element, on the memory that C++ reads and writes; a copy of the state is
        the filter at that tick
    streams : innovation of the last accepted reading by measurement, (m,); NaN: none
    refusals : in a row, by measurement (m,)
    addresses : of design and state

    Raises ValueError for a model that does not fit.
    """

    def __init__(self, model: FilterModel, gate: Gate, kept: int, x: Array, P: Array) -> None:
        n, m = len(x), len(model.rows)
        check_sizes(n, m, kept)
        loaded = library()
        self.design, self.state = new(FILTER), new(FILTER_STATE)
        design, state = self.design[0], self.state[0]
        design["states"], design["measurements"], design["kept"] = n, m, kept
        design["gate"], design["gate_limit"], design["stream_factor"] = gate.threshold, gate.limit, STREAM_FACTOR
        design["drag_error"], design["drag_error_time"] = UNCERTAINTY, UNCERTAINTY_TIME
        design["added"][: n * n] = gate.added.ravel()
        self._noise = design["Q"][: n * n].reshape(n, n)
        self._x: Array = state["x"][:n]
        self._P: Array = state["P"][: n * n].reshape(n, n)
        self.streams, self.refusals = state["streams"][:m], state["refusals"][:m]
        self.set_model(model)
        self._call = loaded.heave_core_filter
        self.addresses: tuple[int, int] = (self.design.ctypes.data, self.state.ctypes.data)
        self._make_room(1, 2 * m)
        self._begin = loaded.heave_core_filter_begin
        self.begin(x, P)

    def begin(self, x: Array, P: Array) -> None:
        """Begin again at an estimate (n,) and its covariance (n, n): no reading has been taken in."""
        self._begin(*self.addresses)
        self._x[:], self._P[:] = x, P

    def set_model(self, model: FilterModel) -> None:
        """Go on with another `model` of the same sizes."""
        design, (n, m) = self.design[0], (len(self._x), len(model.rows))
        design["F"][: n * n], design["B"][:n] = model.F.ravel(), model.B
        for name in ("rows", "changes", "bends"):
            design[name][: m * n] = getattr(model, name).ravel()
        design["scale_states"][:m], design["is_gated"][:m] = model.scale_states, model.is_gated
        design["drag"] = tuple(model.drag)
        slack = design["slack"]
        slack["pull"][:n], slack["reads"][:m] = model.slack.pull, model.slack.reads
        slack["rate"], slack["inertia"], slack["largest"], slack["tick_period"] = model.slack[2:]
        self.set_noise(model.Q)

    def set_noise(self, covariance: Array) -> None:
        """Use another `covariance` of the process noise of a tick, shape (n, n)."""
        self._noise[:] = covariance

    @property
    def x(self) -> Array:
        """Estimate, shape (n,): a copy."""
        return self._x.copy()

    @property
    def P(self) -> Array:
        """Covariance of the estimate, shape (n, n): a copy."""
        return self._P.copy()

    @property
    def tick(self) -> int | None:
        """Newest tick; None before the first."""
        return int(self.state["newest"][0]) if self.state["held"][0] else None

    @property
    def missing_push(self) -> float:
        """How much further down the model pushes the unit than a slack cable does, at the estimate [m]."""
        return float(self.state["missing_push"][0])

    def run(self, ticks: Sequence[tuple[float, ...]], readings: Sequence[tuple[float, ...]]) -> list[list[float]]:
        """Go through a run of ticks; return what each reading said, by the rows of SAID in `filter_table`.

        Parameters
        ----------
        ticks : by the rows of FILTER_TICK; numbers grow
        readings : by the rows of READING, those delivered at a tick sorted by the ticks that they belong to
        """
        count = len(readings)
        if not ticks:
            return []
        if len(ticks) > len(self._ticks) or count > len(self._readings):
            self._make_room(len(ticks), count)
        self._ticks[: len(ticks)] = ticks
        if count:
            self._readings[:count] = readings
        self._call(*self.addresses, self._addresses[0], len(ticks), *self._addresses[1:])
        said: list[list[float]] = self._said[:count].tolist()
        return said

    def _make_room(self, ticks: int, readings: int) -> None:
        """Have place for a run of so many `ticks` and `readings`."""
        widths = [len(kind.rows) for kind in (READING, SAID)]
        self._ticks = np.zeros((ticks, 3))
        self._readings, self._said = (np.zeros((readings, width)) for width in widths)
        self._addresses: tuple[Any, ...] = tuple(one.ctypes.data for one in (self._ticks, self._readings, self._said))


Motion = tuple[Array, Array, Array, Array, int]
"""F (n, n), B (n,), Q (n, n) of a tick, pull of the cable on the unit by state (n,), index of the unit's heave rate."""


def follow(
    motion: Motion,
    ticks: Array,
    commands: Array,
    readings: Array,
    rows: Array,
    values: Array,
    state: Array,
    covariance: Array,
) -> tuple[Array, Array]:
    """Go through a record; `state` (n, c) and `covariance` (n, n) are changed in place.

    Parameters
    ----------
    motion : of the state
    ticks, readings : by the rows of PASS_TICK (t, 4) and PASS_READING (m, 4) in `filter_table`
    commands : in effect at each tick, (t, c)
    rows : of the measurements on the state of a tick, and their first and second differences over ticks (3, k, n)
    values : of the readings (m, c)

    Returns the innovations over the standard deviation that was predicted (m, c), and its square (m,). Raises
    ValueError for a model that does not fit.
    """
    n, c = state.shape
    check_states(n, "pass")
    F, B, Q, pull, rate = motion
    model = new(PASS)
    one = model[0]
    one["states"], one["measurements"], one["columns"] = n, rows.shape[1], c
    one["ticks"], one["rate"] = len(ticks), rate
    one["F"][: n * n], one["B"][:n], one["Q"][: n * n], one["pull"][:n] = F.ravel(), B, Q.ravel(), pull
    given = [np.ascontiguousarray(array, dtype=float) for array in (ticks, commands, readings, rows, values)]
    made = [np.empty(n * c + 2 * n * n), np.empty((len(values), c)), np.empty(len(values))]
    arrays = (model, *given, state, covariance, *made)
    library().heave_core_pass(*(array.ctypes.data for array in arrays))
    return made[1], made[2]
