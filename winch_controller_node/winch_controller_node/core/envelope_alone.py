"""The envelope between any controller and any winch: a command in, the command that leaves out. No ROS, no estimate.

Of the controller it knows the command alone: without a brake it counts as compensation. A move that an operator asks
for is the speed of `controller/operator_speed`, within the operator's share of the winch.
"""

from __future__ import annotations

import math
from typing import cast

from heave_node.interface.alarm import Alarm

from winch_controller_node.core.envelope import Asked, OrderEnvelope
from winch_controller_node.core.supervision.modes import Mode
from winch_controller_node.design.design import assumed_cable
from winch_controller_node.interface.readings import Measurements, WinchOrder
from winch_controller_node.motion.trajectory import MoveRequest
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.envelope_node import WinchEnvelopeParameters

AT_REST = WinchOrder(0, 0.0, 0.0, True)
"""Command before the first one."""


class EnvelopeAlone:
    """The envelope of somebody else's controller.

    Parameters
    ----------
    parameters : nominal winch, cable and unit, margins
    tick_period : [s]
    """

    def __init__(self, parameters: WinchEnvelopeParameters, *, tick_period: float) -> None:
        self._dt, self._operator = tick_period, parameters.operator
        # it has the groups that the envelope looks at, by the same names
        nominal = cast(WinchControllerParameters, parameters)
        cable = assumed_cable(nominal, parameters.length)
        self.envelope = OrderEnvelope(nominal, cable, tick_period)
        self._largest_speed = parameters.operator.speed_share * parameters.winch.speed_limit
        self._acceleration = parameters.operator.acceleration_share * parameters.winch.acceleration_limit
        self._command, self._sequence = AT_REST, 0
        self._move, self._age = MoveRequest(), math.inf

    def ask_speed(self, speed: float) -> None:
        """Take the operator's `speed`, positive lowers [m/s]; it lapses after `operator.timeout`."""
        if math.isfinite(speed):
            speed = min(max(speed, -self._largest_speed), self._largest_speed)
            self._move = MoveRequest(self._move.number + 1, "drive", speed=speed, acceleration=self._acceleration)
            self._age = 0.0

    def acknowledge(self) -> bool:
        """Release what is latched; return whether it could be: order and drum are at rest."""
        self.envelope.acknowledge()
        return self.envelope.reason is None

    def step(
        self, measurements: Measurements, command: WinchOrder | None, time: float = math.nan
    ) -> tuple[WinchOrder | None, list[Alarm]]:
        """Do a tick: return the command that leaves, and what is new.

        Parameters
        ----------
        measurements : delivered at the tick
        command : of the controller; None: none came, and none leaves unless the envelope makes the order itself
        time : of the tick [s]; NaN: readings are taken to be as new
        """
        self._age += self._dt
        if self._age > self._operator.timeout and self._move.kind == "drive":
            self._move = MoveRequest(self._move.number + 1, "stop", acceleration=self._acceleration)
        self._command = self._command if command is None else command
        mode = Mode.STANDBY if self._command.brake else Mode.COMPENSATING
        sent, news = self.envelope.step(measurements, Asked(mode, self._move, time=time), self._command)
        if command is None and self.envelope.reason is None:
            return None, news  # the winch's own watchdog is to see that the controller is silent
        self._sequence = max(self._sequence + 1, self._command.sequence)
        return sent._replace(sequence=self._sequence), news
