"""The design in force, and how the loop goes on with another one: redesign, gain schedule, a winch that was learnt."""

from __future__ import annotations

from winch_controller_node.design.design import ControllerDesign, carry_by_name, carry_over, design_controller
from winch_controller_node.design.schedule import FOLLOW, GainSchedule, design_schedule, is_scheduled
from winch_controller_node.estimation.loop_estimation import LoopEstimation
from winch_controller_node.model.estimator import KalmanEstimator
from winch_controller_node.parameters.controller import WinchControllerParameters


class DesignInForce:
    """Design, its parameters, and the schedule over length where there is one.

    Parameters
    ----------
    parameters : to design from
    tick_period : [s]

    Raises DesignError where no controller can be designed from the parameters.

    Attributes
    ----------
    parameters, design : in force
    """

    def __init__(self, parameters: WinchControllerParameters, *, tick_period: float) -> None:
        self._dt = tick_period
        self.parameters = parameters
        self._schedule, self.design = self._designed(parameters, 0.0)

    def redesign(self, parameters: WinchControllerParameters, payout: float, estimator: KalmanEstimator) -> None:
        """Design again for a mean payout [m] and let the estimator go on with it; states must be the same.

        Raises DesignError or ValueError, the old design then stays.
        """
        schedule, design = self._designed(parameters, payout)
        estimator.set_model(design.model, design.measurements, carry_over(self.design, design))
        self.parameters, self._schedule, self.design = parameters, schedule, design

    def follow_length(self, payout: float, estimator: KalmanEstimator) -> bool:
        """Take the scheduled design of the length that is out at a mean payout [m], when it has changed enough.

        Tells whether it has.
        """
        if self._schedule is None:
            return False
        length = max(self.parameters.length + payout, 1.0)
        if abs(length / self.design.length - 1.0) < FOLLOW:
            return False
        design = self._schedule.design_at(length)
        estimator.set_model(design.model, design.measurements)
        self.design = design
        return True

    def believe(self, parameters: WinchControllerParameters, estimation: LoopEstimation, tick: int) -> None:
        """Go on after `tick` with a design of another winch.

        Every state keeps its meaning, the chain of commands its newest.
        """
        design = design_controller(parameters, tick_period=self._dt, cable=self.design.cable)
        estimation.carry(design, carry_by_name(self.design, design), tick)
        self.parameters, self.design = parameters, design

    def _designed(
        self, parameters: WinchControllerParameters, payout: float
    ) -> tuple[GainSchedule | None, ControllerDesign]:
        """Return the schedule, where one is asked for, and the design at the mean payout [m]."""
        if not is_scheduled(parameters):
            return None, design_controller(parameters, tick_period=self._dt)
        schedule = design_schedule(parameters, tick_period=self._dt)
        return schedule, schedule.design_at(parameters.length + payout)
