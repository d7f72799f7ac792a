"""The model of a pass: the augmented one under some beliefs, from a start that may be anywhere."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from heave_node.numerics.linear_model import LinearModel, state_covariance

from winch_controller_node.adviser.filter_pass import PassModel
from winch_controller_node.design.design import ControllerDesign, measurement_models, model_inputs
from winch_controller_node.interface.sensors import MRU_BIAS
from winch_controller_node.model.blocks import CableModel
from winch_controller_node.model.models import augmented_model
from winch_controller_node.model.simulated_unit import cable_slack, unit_drag
from winch_controller_node.node_parameters import WinchControllerParameters

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
