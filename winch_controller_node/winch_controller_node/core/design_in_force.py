"""The active design with its law, and its successors: redesign, other beliefs, another length of cable."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from heave_node.numerics.arrays import Array

from winch_controller_node.design.design import (
    ControllerDesign,
    carry_by_name,
    carry_sea,
    design_controller,
    length_followed,
)
from winch_controller_node.laws.law import ControlLaw
from winch_controller_node.model.lqr import DesignError
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.model import WinchModelParameters


@dataclass(frozen=True)
class PreparedDesign:
    """A design that could be active."""

    parameters: WinchControllerParameters  # that it was made from
    design: ControllerDesign  # the active design
    law: ControlLaw  # its law at the initial state


class DesignInForce:
    """Design, its parameters and law.

    Parameters
    ----------
    parameters : to design from; then the active ones
    tick_period : [s]

    Raises DesignError where no controller can be designed from the parameters.
    """

    def __init__(self, parameters: WinchControllerParameters, *, tick_period: float) -> None:
        self._dt = tick_period
        self.parameters = parameters
        self.design = designed(parameters, 0.0, tick_period)  # the active one
        self.law = self.design.make_law()  # of the design, begun with it

    def prepared(self, parameters: WinchControllerParameters, payout: float) -> PreparedDesign:
        """Design again from `parameters` for a mean `payout` [m], changing nothing yet; takes longer than a tick.

        Raises DesignError where that cannot be designed or has other states.
        """
        design = designed(parameters, payout, self._dt)
        self._check_states(design)
        return PreparedDesign(parameters, design, design.make_law())

    def take(self, prepared: PreparedDesign) -> tuple[Array, Array]:
        """Activate a `prepared` design.

        Returns the matrix that takes a present state to one of the new design, and the covariance that this adds, both
        of shape (n, n).

        Raises DesignError where the states of the active design have changed meanwhile; that stays.
        """
        self._check_states(prepared.design)
        return self.take_design(prepared.parameters, prepared.design, prepared.law)

    def _check_states(self, design: ControllerDesign) -> None:
        old, new = self.design.model.state_names, design.model.state_names
        if old != new:
            changed = ", ".join(sorted(set(old) ^ set(new))) or "their order"
            raise DesignError(f"the redesign changes the states of the model ({changed}): restart the controller")

    def take_design(
        self, parameters: WinchControllerParameters, design: ControllerDesign, law: ControlLaw | None = None
    ) -> tuple[Array, Array]:
        """Activate a `design` for other `parameters`: another winch, cable, sensor or sea is assumed.

        Waves and vessel of another sea are carried by the boom-tip motion that they cause; every other state keeps its
        meaning, the chain of commands its newest.

        Returns the matrix that takes a present state to one of the new design, shape (n_new, n), and the covariance
        that this adds, shape (n_new, n_new). `law` is that of the design at its initial state; None: it is made.
        """
        old, before = self.design, self.parameters
        self.parameters, self.design, self.law = parameters, design, law or design.make_law()
        if (parameters.sea, parameters.vessel) != (before.sea, before.vessel):
            return carry_sea(old, design)
        return carry_by_name(old, design), np.zeros((design.model.order, design.model.order))

    def take_limits(self, winch: WinchModelParameters) -> None:
        """Keep limits and gain of another `winch`: model and gains stay what they are."""
        mine = self.parameters.winch
        kept = mine.with_limits_of(winch)
        if kept == mine:
            return
        self.parameters = replace(self.parameters, winch=kept)
        self.design = replace(self.design, parameters=self.parameters)
        self.law.take_limits(self.design.limits)


def designed(parameters: WinchControllerParameters, payout: float, tick_period: float) -> ControllerDesign:
    """Return the design from `parameters` for the cable that is out at a `payout` [m], with ticks of `tick_period` [s].

    Raises DesignError where that cannot be designed.
    """
    length = length_followed(parameters, payout, parameters.length)
    return design_controller(parameters, tick_period=tick_period, length=length)
