"""The adviser that knows nothing: it answers that all is nominal."""

from __future__ import annotations

from winch_controller_node.beliefs.beliefs import Beliefs
from winch_controller_node.beliefs.observations import Observations
from winch_controller_node.node_parameters import WinchControllerParameters


class Adviser:
    """Answers every batch with the nominal.

    Parameters
    ----------
    parameters : nominal
    tick_period : [s]
    """

    def __init__(self, parameters: WinchControllerParameters, *, tick_period: float) -> None:
        self._nominal, self._dt = parameters, tick_period

    def advise(self, observations: Observations) -> Beliefs:
        """Return the answer to `observations`."""
        return Beliefs(asked=observations.last)

    def redesigned(self, parameters: WinchControllerParameters) -> None:
        """Take other nominal `parameters`."""
        self._nominal = parameters
