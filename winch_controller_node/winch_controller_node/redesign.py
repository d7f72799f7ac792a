"""An operator's redesign beside the ticks: in a process that lives as long as it takes."""

from __future__ import annotations

import pickle

from winch_controller_node.advice.worker import Answer, Worker, WorkerError
from winch_controller_node.core.design_in_force import PreparedDesign, designed
from winch_controller_node.model.lqr import DesignError
from winch_controller_node.node_parameters import WinchControllerParameters


class Redesign:
    """A design that is being made.

    Parameters
    ----------
    parameters : to design from
    payout : mean payout to design for [m]
    tick_period : [s]
    """

    def __init__(self, parameters: WinchControllerParameters, payout: float, tick_period: float) -> None:
        self._parameters = parameters
        self._worker = Worker(make_designer, tick_period)
        self._worker.ask(pickle.dumps((parameters, payout)))

    def take(self) -> PreparedDesign | None:
        """Return the design once it is there; None before.

        Raises DesignError, once, where it cannot be made.
        """
        try:
            answers = self._worker.answers()
        except WorkerError as error:
            self.close()
            raise DesignError(str(error)) from error
        if not answers:
            return None
        self.close()
        found = pickle.loads(answers[0])
        if isinstance(found, str):
            raise DesignError(found)
        return PreparedDesign(self._parameters, found, found.make_law())

    def close(self) -> None:
        """End the process."""
        self._worker.close()


def make_designer(tick_period: float) -> Answer:
    """Return what designs, in the process, at a `tick_period` [s]."""

    def design(question: bytes) -> bytes:
        parameters, payout = pickle.loads(question)
        try:
            return pickle.dumps(designed(parameters, payout, tick_period))
        except ValueError as error:
            return pickle.dumps(str(error))

    return design
