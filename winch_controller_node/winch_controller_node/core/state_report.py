"""One tick of the controller as a value, and its report."""

from __future__ import annotations

from typing import NamedTuple

from heave_node.numerics.arrays import Array

from winch_controller_node.core.estimation.loop_tick import LoopTick
from winch_controller_node.core.loop_command import TickCommand
from winch_controller_node.core.supervision.supervisor import Decision
from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.interface.readings import Report, SensorState, WinchOrder


class ControllerTick(NamedTuple):
    """One tick of the controller: values that later ticks do not change.

    Attributes
    ----------
    loop : what was known
    decision : of the supervision
    command : of the laws
    order : to the winch
    design : the active one
    measurements : names of what the estimator takes
    law, gain : name of the active law, and its gain, shape (n,)
    covariance : of the estimate, shape (n, n)
    depth_set_point : payout about which the winch works [m]
    sensors : how each is seen
    """

    loop: LoopTick
    decision: Decision
    command: TickCommand
    order: WinchOrder
    design: ControllerDesign
    measurements: tuple[str, ...]
    law: str
    gain: Array
    covariance: Array
    depth_set_point: float
    sensors: tuple[SensorState, ...]


def state_report(tick: ControllerTick) -> Report:
    """Return the report of a `tick`."""
    loop, mode, command, order = tick.loop, tick.decision.mode, tick.command, tick.order
    innovation, innovation_sigma, nis, _ = loop.said.T.tolist()
    return Report(
        mode=mode.mode.value,
        law=tick.law,
        reason=mode.reason,
        state_names=tick.design.model.state_names,
        estimate=tuple(loop.estimate.tolist()),
        covariance_diagonal=tuple(tick.covariance.diagonal().tolist()),
        measurement_names=tick.measurements,
        innovation=tuple(innovation),
        innovation_sigma=tuple(innovation_sigma),
        nis=tuple(nis),
        gain=tuple(tick.gain.tolist()),
        predicted_unit_heave=loop.unit,
        predicted_boom_tip_heave=loop.tip,
        predicted_uncompensated_heave=loop.free,
        payout_set_point=order.payout,
        payout_rate_set_point=order.payout_rate,
        depth_set_point=tick.depth_set_point,
        authority=mode.authority,
        active_limits=tuple(dict.fromkeys(command.governed.active + command.asked.active)),
        solver_status=command.asked.status,
        solver_iterations=command.asked.iterations,
        sensors=tick.sensors,
        is_inhibited=tick.decision.is_inhibited,
    )
