"""Controller and adviser over the ticks of a record."""

from __future__ import annotations

from winch_controller_node.adviser.component import Adviser
from winch_controller_node.beliefs.beliefs import Beliefs
from winch_controller_node.component import WinchController
from winch_controller_node.interface.readings import Measurements, Outputs, WinchOrder
from winch_controller_node.node_parameters import WinchControllerParameters

from heave_bringup.whatif.signals.record import SensorRecord


class Core:
    """A controller that steps where that of a `record` did, and gets answers of an adviser that came in time there.

    Parameters
    ----------
    record : whose ticks are stepped through
    parameters : nominal, of the controller
    has_adviser : it has one

    Attributes
    ----------
    beliefs : newest answer of the adviser that came in time
    """

    def __init__(self, record: SensorRecord, parameters: WinchControllerParameters, *, has_adviser: bool) -> None:
        dt, self._record = record.tick_period, record
        self._controller = WinchController(parameters, tick_period=dt)
        self._controller.skip_programme((record.first - 1) * dt)
        self._adviser = Adviser(parameters, tick_period=dt) if has_adviser else None
        self._outputs: Outputs | None = None
        self.beliefs = Beliefs(asked=-1)

    def step(self, index: int, given: Measurements) -> tuple[Outputs, WinchOrder | None]:
        """Do the tick of an `index` with what is `given`; return what came of it, and the order, None in one left out.

        What came of a tick that is left out is that of the tick before, without its alarms.
        """
        tick = self._record.first + index
        if self._outputs is not None and self._record.orders[index] is None:
            self._controller.leave_out(tick)
            self._outputs = self._outputs._replace(alarms=(), observations=None)
            return self._outputs, None
        self._outputs = outputs = self._controller.step(tick, given)
        observed = outputs.observations
        if observed is not None and self._adviser is not None:
            beliefs = self._adviser.advise(observed)
            if observed.last not in self._record.late:
                self.beliefs = beliefs
                self._controller.take(beliefs)
        return outputs, outputs.order
