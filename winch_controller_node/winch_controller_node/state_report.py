"""The report of a tick: what the controller believes and does."""

from __future__ import annotations

import math

import numpy as np
from heave_node.arrays import Array

from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.estimation.loop_estimation import LoopEstimation
from winch_controller_node.interface.readings import Report, WinchOrder
from winch_controller_node.laws.feedback import LawCommand
from winch_controller_node.laws.governor import GovernedCommand
from winch_controller_node.supervision.modes import ModeOutput


def state_report(
    tick: int,
    mode: ModeOutput,
    asked: LawCommand,
    governed: GovernedCommand,
    order: WinchOrder,
    estimate: Array,
    *,
    design: ControllerDesign,
    gain: Array,
    estimation: LoopEstimation,
    mean_set_point: float,
) -> Report:
    """Return the report of tick k.

    Parameters
    ----------
    tick : k
    mode, asked, governed, order, estimate : of the tick
    design : in force; gain : of its law, shape (n,) or empty
    estimation : for covariance, innovations and sensors
    mean_set_point : payout about which the winch works [m]
    """
    innovations = estimation.estimator.innovations
    names = tuple(estimation.estimator.measurements)
    rows = [innovations.get(name) for name in names]
    return Report(
        mode=mode.mode.value,
        law=design.parameters.law,
        reason=mode.reason,
        state_names=design.model.state_names,
        estimate=tuple(estimate.tolist()),
        covariance_diagonal=tuple(np.diagonal(estimation.estimator.covariance).tolist()),
        measurement_names=names,
        innovation=tuple(math.nan if row is None else row.value for row in rows),
        innovation_sigma=tuple(math.nan if row is None else row.sigma for row in rows),
        nis=tuple(math.nan if row is None else row.nis for row in rows),
        gain=tuple(gain.tolist()),
        predicted_unit_heave=estimation.unit_heave(estimate),
        predicted_boom_tip_heave=float(estimation.rows.tip[0] @ estimate),
        predicted_uncompensated_heave=float(estimation.uncompensated[0]),
        payout_set_point=order.payout,
        payout_rate_set_point=order.payout_rate,
        depth_set_point=mean_set_point,
        authority=mode.authority,
        active_limits=tuple(dict.fromkeys(governed.active + asked.active)),
        solver_status=asked.status,
        solver_iterations=asked.iterations,
        sensors=estimation.observer.states(tick),
    )
