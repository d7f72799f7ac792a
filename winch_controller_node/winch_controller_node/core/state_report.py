"""The report of a tick."""

from __future__ import annotations

import math
from typing import NamedTuple

from winch_controller_node.core.estimation.loop_tick import LoopTick
from winch_controller_node.core.loop_command import TickCommand
from winch_controller_node.core.supervision.supervisor import Decision
from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.interface.readings import Report, SensorState, WinchOrder
from winch_controller_node.laws.law import ControlLaw
from winch_controller_node.model.estimator import Innovation, KalmanEstimator

NOT_READ = Innovation(math.nan, math.nan, math.nan, accepted=False)
"""Innovation of a measurement in a tick without a reading of it."""


class Known(NamedTuple):
    """What a report is made of beside the tick.

    Attributes
    ----------
    design, law : the active ones
    estimator : of the loop
    depth_set_point : payout about which the winch works [m]
    sensors : how each is seen
    """

    design: ControllerDesign
    law: ControlLaw
    estimator: KalmanEstimator
    depth_set_point: float
    sensors: tuple[SensorState, ...]


def state_report(loop: LoopTick, decision: Decision, command: TickCommand, order: WinchOrder, known: Known) -> Report:
    """Return the report of a tick.

    Parameters
    ----------
    loop, decision, command, order : of the tick
    known : beside it
    """
    mode, measurements = decision.mode, tuple(known.estimator.measurements)
    innovations = [loop.sensed.innovations.get(name, NOT_READ) for name in measurements]
    return Report(
        mode=mode.mode.value,
        law=known.law.name,
        reason=mode.reason,
        state_names=known.design.model.state_names,
        estimate=tuple(loop.estimate.tolist()),
        covariance_diagonal=tuple(known.estimator.covariance.diagonal().tolist()),
        measurement_names=measurements,
        innovation=tuple([row.value for row in innovations]),
        innovation_sigma=tuple([row.sigma for row in innovations]),
        nis=tuple([row.nis for row in innovations]),
        gain=tuple(known.law.gain.tolist()),
        predicted_unit_heave=loop.motions.unit,
        predicted_boom_tip_heave=loop.motions.tip,
        predicted_uncompensated_heave=loop.motions.free,
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
