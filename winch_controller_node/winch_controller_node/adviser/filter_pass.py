"""One pass of a linear filter over a record, for many versions of the record at once.

Covariance and gains of a linear Kalman filter do not depend on what was read, so that innovations are linear in the
readings: a column each for the record as it is, for what one sensor alone has read, for a step of it, goes through one
pass, and the innovations under any correction of the readings are a sum of columns.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from heave_core.filter import UNCERTAINTY, UNCERTAINTY_TIME, Drag, Slack, follow
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel, state_covariance
from numpy.typing import NDArray

from winch_controller_node.design.design import ControllerDesign, measurement_models, model_inputs
from winch_controller_node.interface.sensors import MRU_BIAS
from winch_controller_node.model.blocks import CableModel
from winch_controller_node.model.models import augmented_model
from winch_controller_node.model.simulated_unit import cable_slack, unit_drag
from winch_controller_node.node_parameters import WinchControllerParameters

SETTLING = 15.0
"""Time at the start of a record over which innovations are not judged [s]: the state is not known yet."""

STOPPED = 30.0
"""Exponent of drag that leaves nothing of a speed."""


@dataclass(frozen=True, eq=False)
class PassModel:
    """A sampled model as a pass needs it."""

    F: Array  # transition, shape (n, n)
    B: Array  # input, shape (n,)
    Q: Array  # covariance of the process noise of a tick, shape (n, n)
    start: Array  # covariance of the state at the start (n, n)
    # of each measurement on the state of its tick, and its first and second differences over ticks (3, k, n)
    rows: Array
    drag: Drag  # drag of the unit, which goes by the speed that was seen
    slack: Slack  # slack of the cable, as it was seen
    state_names: tuple[str, ...]  # of the n states


@dataclass(frozen=True, eq=False)
class PassInput:
    """A record in columns."""

    commands: Array  # in effect at each tick, (t, c)
    ends: NDArray[np.int64]  # where the readings of each tick end in the tables below, (t,)
    which: NDArray[np.int64]  # measurement of each reading (m,)
    offsets: Array  # how much later than its tick it was measured (m,) [ticks]
    variances: Array  # of its noise (m,)
    values: Array  # (m, c)
    unit_speed: Array  # absolute speed of the unit at each tick, by which its drag goes (t,) [m/s]
    missing_push: Array  # by how much a linear cable would push the unit more than it did, slack, at each tick (t,) [m]

    def among(self, columns: NDArray[np.int64]) -> PassInput:
        """Return it with some of its `columns` only."""
        return replace(
            self,
            commands=np.ascontiguousarray(self.commands[:, columns]),
            values=np.ascontiguousarray(self.values[:, columns]),
        )


@dataclass(frozen=True, eq=False)
class PassResult:
    """What a pass leaves."""

    innovations: Array  # of each reading in each column, over the standard deviation that the filter foresaw, (m, c)
    variances: Array  # that it foresaw (m,)
    state: Array  # at the end, shape (n, c)
    covariance: Array  # at the end, shape (n, n)


def run_pass(model: PassModel, record: PassInput, used: NDArray[np.bool_]) -> PassResult:
    """Go through a `record` with a `model`. Of measurements that are not `used`, (k,), innovations are noted only."""
    state, covariance = np.zeros((len(model.F), record.values.shape[1])), model.start.copy()
    readings = np.column_stack((record.which, record.offsets, record.variances, used[record.which]))
    innovations, variances = follow(
        (model.F, model.B, model.Q, model.slack.pull, model.drag.rate),
        _motion(model, record),
        record.commands,
        readings.astype(float, copy=False),
        model.rows,
        record.values,
        state,
        covariance,
    )
    return PassResult(innovations, variances, state, covariance)


def _motion(model: PassModel, record: PassInput) -> Array:
    """Return how the state of a `model` moves at the speed and the slack that a `record` has seen, tick by tick.

    Columns are the rows of PASS_TICK in `heave_core.filter_table`.
    """
    drag, slack, missing = model.drag, model.slack, record.missing_push
    excess = np.maximum(drag.quadratic * record.unit_speed - drag.damping, 0.0) / drag.inertia
    unknown = (UNCERTAINTY * excess * record.unit_speed) ** 2 + (UNCERTAINTY * missing / slack.inertia) ** 2
    kept = np.exp(-np.minimum(0.5 * excess * drag.tick_period, STOPPED))
    gives = np.where(missing > 0.0, missing / (missing + slack.largest), 0.0) * slack.tick_period / slack.inertia
    # beside the drag, which takes its share of the rate after it
    return np.column_stack((kept, gives / kept, unknown * UNCERTAINTY_TIME * drag.tick_period, record.ends))


START = {
    "payout": 10.0,
    "payout_rate": 1.0,
    "unit_heave": 10.0,
    "unit_heave_rate": 1.0,
    "depth_bias": 10.0,
    "mru_offset": 0.5,
    "mru_offset_rate": 0.5,
}
"""Standard deviation of a state at the start of a record, which may begin anywhere, in its unit."""

OTHER = 0.3
"""Standard deviation at the start of a record of a state that the active design does not have, in its unit."""


def pass_model(
    parameters: WinchControllerParameters,
    cable: CableModel,
    design: ControllerDesign,
    boom_tip: LinearModel | None = None,
) -> tuple[PassModel, LinearModel]:
    """Return the model of `parameters` with a two-state `cable` for a pass, and as it is sampled.

    The state at the start is as uncertain as in the active `design`, or as START says. `boom_tip` is another white
    noise to boom tip than that of the sea and vessel of the parameters, as of a sea that is tried; None: it is that.
    """
    inputs = replace(model_inputs(parameters, cable), boom_tip=boom_tip)
    model = augmented_model(inputs, design.tick_period)
    measurements = measurement_models(parameters, model, cable)
    rows = np.array([known.row for known in measurements])
    change = rows @ model.A - rows
    start = np.diag([START.get(name, OTHER) ** 2 for name in model.state_names])
    known = [name for name in model.state_names if design.model.has_state(name) and name not in START]
    new, old = [model.state(name) for name in known], [design.model.state(name) for name in known]
    start[np.ix_(new, new)] = design.initial_covariance[np.ix_(old, old)]
    if model.has_state(MRU_BIAS):
        # as large as assumed: a larger one would explain what is an offset
        bias = model.state(MRU_BIAS)
        start[bias, :] = start[:, bias] = 0.0
        start[bias, bias] = parameters.sensors.mru.bias_sigma**2
    if boom_tip is not None:
        of_tip = [model.state(name) for name in boom_tip.state_names]
        start[of_tip, :] = start[:, of_tip] = 0.0
        start[np.ix_(of_tip, of_tip)] = state_covariance(boom_tip)
    tables = np.array([rows, change, change @ model.A - change])
    drag, slack = unit_drag(model, cable), cable_slack(model, cable, measurements)
    noise = model.noise_covariance
    return PassModel(model.A, model.B[:, 0], noise, start, tables, drag, slack, model.state_names), model


def linear(parameters: WinchControllerParameters) -> WinchControllerParameters:
    """Return `parameters` whose model is linear in what is read: scale and lever arm of the MRU are known."""
    mru = replace(parameters.sensors.mru, scale_sigma=0.0, lever_arm_sigma=0.0)
    return replace(parameters, sensors=replace(parameters.sensors, mru=mru))
