"""The report of a tick."""

from __future__ import annotations

from typing import NamedTuple

from winch_controller_node.core.estimation.loop_tick import LoopTick
from winch_controller_node.core.loop_command import TickCommand
from winch_controller_node.core.supervision.supervisor import Decision
from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.interface.readings import Report, SensorState, WinchOrder
from winch_controller_node.laws.law import ControlLaw
from winch_controller_node.model.estimator import KalmanEstimator


class Known(NamedTuple):
    """What a report is made of beside the tick."""

    design: ControllerDesign  # the active design
    law: ControlLaw  # the active law
    estimator: KalmanEstimator  # of the loop
    depth_set_point: float  # payout about which the winch works [m]
    sensors: tuple[SensorState, ...]  # how each is seen
    reason: str  # why the mode is what it is


def state_report(loop: LoopTick, decision: Decision, command: TickCommand, order: WinchOrder, known: Known) -> Report:
    """Return the report of a tick: `loop`, `decision`, `command`, `order` of it, and what is `known` beside it."""
    mode, measurements = decision.mode, tuple(known.estimator.measurements)
    innovation, innovation_sigma, nis, _ = loop.said.T.tolist()
    return Report(
        mode=mode.mode.value,
        law=known.law.name,
        reason=known.reason,
        state_names=known.design.model.state_names,
        estimate=tuple(loop.estimate.tolist()),
        covariance_diagonal=tuple(known.estimator.covariance.diagonal().tolist()),
        measurement_names=measurements,
        innovation=tuple(innovation),
        innovation_sigma=tuple(innovation_sigma),
        nis=tuple(nis),
        gain=tuple(known.law.gain.tolist()),
        predicted_unit_heave=loop.unit,
        predicted_boom_tip_heave=loop.tip,
        predicted_uncompensated_heave=loop.free,
        payout_set_point=order.payout,
        payout_rate_set_point=order.payout_rate,
        depth_set_point=known.depth_set_point,
        authority=mode.authority,
        active_limits=tuple(dict.fromkeys(command.governed.active + command.asked.active)),
        solver_status=command.asked.status,
        solver_iterations=command.asked.iterations,
        sensors=known.sensors,
        is_inhibited=decision.is_inhibited,
    )
