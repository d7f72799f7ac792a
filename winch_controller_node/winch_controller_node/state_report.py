"""One tick of the controller as a value, and the report that is made of it."""

from __future__ import annotations

import math
from typing import NamedTuple

from winch_controller_node.design_in_force import DesignInForce
from winch_controller_node.estimation.loop_estimation import LoopEstimation
from winch_controller_node.estimation.loop_tick import LoopTick
from winch_controller_node.interface.readings import Report, WinchOrder
from winch_controller_node.loop_command import TickCommand
from winch_controller_node.model.estimator import Innovation
from winch_controller_node.supervision.supervisor import Decision

NOT_READ = Innovation(math.nan, math.nan, math.nan, accepted=False)
"""What a measurement says in a tick without a reading of it."""


class ControllerTick(NamedTuple):
    """One tick of the controller.

    Attributes
    ----------
    loop : what was known
    decision : of the supervision
    command : of the laws
    order : to the winch
    """

    loop: LoopTick
    decision: Decision
    command: TickCommand
    order: WinchOrder


def state_report(tick: ControllerTick, estimation: LoopEstimation, in_force: DesignInForce) -> Report:
    """Return the report of a `tick`, with the `estimation` and the design `in_force` at its end."""
    loop, mode, command, order = tick.loop, tick.decision.mode, tick.command, tick.order
    estimator = estimation.estimator
    names = tuple(estimator.measurements)
    innovations = [loop.sensed.innovations.get(name, NOT_READ) for name in names]
    return Report(
        mode=mode.mode.value,
        law=in_force.parameters.law,
        reason=mode.reason,
        state_names=in_force.design.model.state_names,
        estimate=tuple(loop.estimate.tolist()),
        covariance_diagonal=tuple(estimator.covariance.diagonal().tolist()),
        measurement_names=names,
        innovation=tuple([row.value for row in innovations]),
        innovation_sigma=tuple([row.sigma for row in innovations]),
        nis=tuple([row.nis for row in innovations]),
        gain=tuple(in_force.law.gain.tolist()),
        predicted_unit_heave=loop.unit.heave,
        predicted_boom_tip_heave=loop.boom_tip.heave,
        predicted_uncompensated_heave=loop.free_unit.heave,
        payout_set_point=order.payout,
        payout_rate_set_point=order.payout_rate,
        depth_set_point=estimation.motion.set_point,
        authority=mode.authority,
        active_limits=tuple(dict.fromkeys(command.governed.active + command.asked.active)),
        solver_status=command.asked.status,
        solver_iterations=command.asked.iterations,
        sensors=estimation.observer.states(loop.number),
        is_inhibited=tick.decision.is_inhibited,
    )
