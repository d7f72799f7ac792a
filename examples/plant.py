"""A plant of your own, in lockstep: heave run b2_calm_300 --replace cable_sim=lockstep.

The load hangs on a cable that does not stretch; ship_clock leads the ticks. The contract is docs/contract.md.
"""

import sys
from dataclasses import dataclass

from heave_msgs.msg import LoadCell
from heave_node.interface import topics
from heave_node.parameters import parameter
from heave_node.ros.participant import ParticipantNode
from heave_node.ros.process import run_node
from heave_node.tick.tick import Tick
from nav_msgs.msg import Odometry
from sensor_msgs.msg import FluidPressure

AIR, DENSITY, GRAVITY = 101325.0, 1025.0, 9.80665  # [Pa], [kg/m^3], [m/s^2]
SIGMA = 0.01  # of the depth [m]


@dataclass(frozen=True)
class Parameters:
    length: float = parameter(300.0, "m", 1.0, 1e4, "Length of the cable.")
    mass: float = parameter(4000.0, "kg", 1.0, 1e6, "Mass less water of all that hangs.")


class Plant(ParticipantNode):
    name = "cable_sim"
    parameters_type = Parameters
    after = ("wave_vessel", "virtual_winch")

    def on_build(self) -> None:
        self.tip = self.add_input(topics.BOOM_TIP)
        self.winch = self.add_input(topics.WINCH_STATE)
        self.unit = self.add_output(topics.UNIT_ODOMETRY)
        self.pressure = self.add_output(topics.UNIT_PRESSURE)
        self.load = self.add_output(topics.LOAD_CELL)

    def on_reset(self) -> None:
        """Nothing is kept from one run to the next."""

    def on_tick(self, tick: Tick) -> None:
        """Publish, at the end of the tick, what the controller reads in the next one."""
        self.take(self.tip)
        self.take(self.winch)
        tip, state = self.tip.latest, self.winch.latest
        if tip is None or state is None:
            return
        depth = self.parameters.length + state.payout - tip.position.z
        acceleration = tip.acceleration.z - state.payout_acceleration
        unit = Odometry()
        unit.pose.pose.position.z, unit.twist.twist.linear.z = -depth, tip.velocity.z - state.payout_rate
        pressure = FluidPressure(fluid_pressure=AIR + DENSITY * GRAVITY * depth)
        pressure.variance = (DENSITY * GRAVITY * SIGMA) ** 2
        load = LoadCell(tension=max(0.0, self.parameters.mass * (GRAVITY + acceleration)), tension_sigma=200.0)
        for message, output in ((unit, self.unit), (pressure, self.pressure), (load, self.load)):
            message.header.stamp = tick.end_stamp
            output.publish(message)


sys.exit(run_node(Plant))
