"""ROS shell of the envelope between any controller and any winch."""

from __future__ import annotations

from geometry_msgs.msg import TwistStamped
from heave_node.errors import NodeError
from heave_node.interface import topics
from heave_node.interface.codes import time_key
from heave_node.interface.sensors import SENSORS, Water
from heave_node.numerics.linear_model import ModelError
from heave_node.ros.diagnostics import Health, Level, alarm_health
from heave_node.ros.participant import ParticipantNode
from heave_node.ros.process import run_process
from heave_node.tick.tick import Tick
from std_srvs.srv import Trigger

from winch_controller_node.core.envelope_alone import EnvelopeAlone
from winch_controller_node.interface import conversions
from winch_controller_node.interface.readings import WinchOrder
from winch_controller_node.parameters.envelope_node import WinchEnvelopeParameters

CONTROLLER = "winch_controller"
SEEN = ("mru", "load_cell")
"""Sensors that it reads besides the state of the winch."""


class WinchEnvelopeNode(ParticipantNode):
    """Takes `winch/command` of tick k and publishes `winch/command_within`, for [t_k, t_{k+1}] too.

    It reads MRU, load cell, state of the winch, and `controller/operator_speed`. The service
    `winch_envelope/acknowledge` releases what it has latched.
    """

    name = "winch_envelope"
    parameters_type = WinchEnvelopeParameters
    after = ("wave_vessel", CONTROLLER)

    def on_build(self) -> None:
        """Make the envelope, its inputs and its output."""
        self.bounded = self._make()
        self.within = self.add_output(topics.WINCH_COMMAND_WITHIN)
        is_hardware = CONTROLLER in self.run.external
        self.command = self.add_input(topics.WINCH_COMMAND, WinchOrder._fields, holds_ahead=not is_hardware)
        self.sensors = {
            name: self.add_input(SENSORS[name].topic, SENSORS[name].values, check_stamps=False, holds_ahead=True)
            for name in SEEN
        }
        self.winch_state = self.add_input(
            topics.WINCH_STATE, conversions.WINCH_STATE, check_stamps=False, holds_ahead=True
        )
        self.create_subscription(TwistStamped, topics.OPERATOR_SPEED.name, self._take_operator_speed, 1)
        self.create_service(Trigger, "winch_envelope/acknowledge", self._serve_acknowledge)

    def on_reset(self) -> None:
        """Start again: nothing was read, nothing is latched."""
        self.bounded = self._make()

    def on_tick(self, tick: Tick) -> None:
        """Bound the command of a `tick`."""
        states, commands = self.take(self.winch_state), self.take(self.command)
        measurements = conversions.measurements(
            {name: self.take(port) for name, port in self.sensors.items()},
            conversions.winch_reading_of(states[-1]) if states else None,
            Water(self.parameters.water_density, self.parameters.gravity),
        )
        given = conversions.winch_order_of(commands[-1]) if commands else None
        sent, news = self.bounded.step(measurements, given, tick.time)
        if sent is not None:
            self.within.publish(conversions.command_message(sent, tick.start_nanoseconds))
        for alarm in news:
            self.get_logger().error(f"{time_key(tick.time)}: {alarm}")

    def diagnose(self) -> list[Health]:
        """Publish whether it has taken over, and the bounds of now."""
        reason, last = self.bounded.envelope.reason, self.bounded.envelope.last
        if reason is not None:
            return [alarm_health("envelope", reason)]
        text = f"within {last.rate_bound:.2f} m/s and {last.travel_bound:.2f} m about the requested move"
        return [Health("envelope", Level.OK, text)]

    def _make(self) -> EnvelopeAlone:
        try:
            return EnvelopeAlone(self.parameters, tick_period=self.run.tick_period)
        except (ModelError, ValueError) as error:
            raise NodeError(str(error)) from error

    def _take_operator_speed(self, twist: TwistStamped) -> None:
        """Take an operator's speed: linear.z, positive up as all heave [m/s]."""
        self.bounded.ask_speed(-twist.twist.linear.z)

    def _serve_acknowledge(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Release what is latched, where order and drum are at rest."""
        del request
        response.success = self.bounded.acknowledge()
        response.message = "released" if response.success else "the drum is not at rest yet: acknowledge again then"
        return response


def main() -> None:
    """Run the node until its run ends."""
    run_process(WinchEnvelopeNode)


if __name__ == "__main__":
    main()
