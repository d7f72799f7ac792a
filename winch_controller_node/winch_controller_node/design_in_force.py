"""The design in force with its law, and its successors: redesign, gain schedule, a winch that was identified."""

from __future__ import annotations

from heave_node.arrays import Array

from winch_controller_node.design.design import ControllerDesign, carry_by_name, carry_over, design_controller
from winch_controller_node.design.schedule import FOLLOW, GainSchedule, design_schedule, is_scheduled
from winch_controller_node.model.lqr import DesignError
from winch_controller_node.parameters.controller import WinchControllerParameters


class DesignInForce:
    """Design, its parameters and law, and the schedule over length where there is one.

    Parameters
    ----------
    parameters : to design from
    tick_period : [s]

    Raises DesignError where no controller can be designed from the parameters.

    Attributes
    ----------
    parameters, design : in force
    law : of the design, begun with it
    """

    def __init__(self, parameters: WinchControllerParameters, *, tick_period: float) -> None:
        self._dt = tick_period
        self.parameters = parameters
        self._schedule, self.design = self._designed(parameters, 0.0)
        self.law = self.design.make_law()

    def redesign(self, parameters: WinchControllerParameters, payout: float) -> Array:
        """Design again for a mean payout [m]; the states must stay the same.

        Returns by what each state estimated so far is to be multiplied, shape (n,).

        Raises DesignError where that cannot be designed or has other states; the old design then stays.
        """
        schedule, design = self._designed(parameters, payout)
        old, new = self.design.model.state_names, design.model.state_names
        if old != new:
            changed = ", ".join(sorted(set(old) ^ set(new))) or "their order"
            raise DesignError(f"the redesign changes the states of the model ({changed}): restart the controller")
        factors, law = carry_over(self.design, design), design.make_law()
        self.parameters, self._schedule, self.design, self.law = parameters, schedule, design, law
        return factors

    def follow_length(self, payout: float) -> bool:
        """Take the scheduled design of the length that is out at a mean payout [m], when it has changed enough.

        Tells whether it has.
        """
        if self._schedule is None:
            return False
        length = max(self.parameters.length + payout, 1.0)
        if abs(length / self.design.length - 1.0) < FOLLOW:
            return False
        self.design = self._schedule.design_at(length)
        self.law = self.design.make_law()
        return True

    def take_winch(self, parameters: WinchControllerParameters) -> Array:
        """Design for another winch.

        Returns the matrix that takes a present state to one of the new design, shape (n_new, n): every state keeps its
        meaning, the chain of commands its newest.
        """
        design = design_controller(parameters, tick_period=self._dt, cable=self.design.cable)
        matrix = carry_by_name(self.design, design)
        self.parameters, self.design, self.law = parameters, design, design.make_law()
        return matrix

    def _designed(
        self, parameters: WinchControllerParameters, payout: float
    ) -> tuple[GainSchedule | None, ControllerDesign]:
        """Return the schedule, where one is asked for, and the design at the mean payout [m]."""
        if not is_scheduled(parameters):
            return None, design_controller(parameters, tick_period=self._dt)
        schedule = design_schedule(parameters, tick_period=self._dt)
        return schedule, schedule.design_at(parameters.length + payout)
