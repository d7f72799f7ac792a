"""The operator's wish along a run: where the programme of depth has the mean payout go."""

from __future__ import annotations

from winch_controller_node.motion.programme import Programme
from winch_controller_node.motion.trajectory import MeanPayout
from winch_controller_node.node_parameters import WinchControllerParameters

from heave_bringup.benchmark.interface import Target

AT_REST = Target()


class TargetProgramme:
    """Gives the target of each sample time, in order.

    Parameters
    ----------
    parameters : whose programme and bounds of a move hold
    sample_time : [s]
    """

    def __init__(self, parameters: WinchControllerParameters, *, sample_time: float) -> None:
        self._programme = Programme(parameters.programme)
        self._rests = not parameters.programme.move_times
        self._mean = MeanPayout(parameters.move, tick_period=sample_time)

    def at(self, time: float) -> Target:
        """Return the target at `time` [s]; call it once for each sample time."""
        if self._rests:
            return AT_REST
        for due in self._programme.due(time):
            if not due.mode:
                self._mean.move_to(due.payout, due.speed)
        point = self._mean.point
        target = Target(point.payout, point.rate)
        self._mean.advance()
        return target
