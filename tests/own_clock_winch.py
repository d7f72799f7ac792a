"""The virtual winch as hardware would be: a drive with a loop and a clock of its own, which knows nothing of /clock.

Run as `python own_clock_winch.py SCENARIO`. Its clock is OFFSET away from the machine's and runs DRIFT faster; its
stamps are of that clock, its truth is its own.
"""

import contextlib
import math
import sys
import time

import rclpy
from cable_sim_node.conversions import winch_state_message
from cable_sim_node.winch.component import VirtualWinch
from cable_sim_node.winch.component import WinchCommand as WinchOrder
from heave_bringup.scenarios import load_scenario
from heave_msgs.msg import WinchCommand, WinchState
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rclpy.serialization import deserialize_message

PERIOD = 0.01
"""Period of its own loop [s]; every second state is published."""
OFFSET, DRIFT = 12_345.678, 300e-6


class Drive(Node):
    def __init__(self, scenario: str) -> None:
        super().__init__("drive")
        self.winch = VirtualWinch(load_scenario(scenario).parameters["virtual_winch"], tick_period=PERIOD)
        self.began = time.monotonic()
        self.newest = None
        self.state = self.winch.state
        self.publisher = self.create_publisher(WinchState, "winch/state", qos_profile_sensor_data)
        self.create_subscription(WinchCommand, "winch/command", self.on_command, 10)
        self.create_timer(PERIOD, self.work)

    def on_command(self, message: WinchCommand) -> None:
        self.newest = WinchOrder(message.sequence, message.payout, message.payout_rate, message.brake)

    def work(self) -> None:
        elapsed = time.monotonic() - self.began
        while (self.winch.tick + 1) * PERIOD <= elapsed:
            self.state = self.winch.step(self.winch.tick, self.newest)
        if self.winch.tick % 2:
            return
        stamp = round((OFFSET + (1.0 + DRIFT) * elapsed) * 1e9)
        message = deserialize_message(winch_state_message(self.state, stamp), WinchState)
        message.payout = message.payout_rate = message.payout_acceleration = message.power = math.nan
        self.publisher.publish(message)


rclpy.init()
with contextlib.suppress(KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
    rclpy.spin(Drive(sys.argv[1]))
