"""A winch drive in place of the virtual one: heave run b2_calm_300 --pacing realtime --replace virtual_winch=external.

It follows the payout rate that it is commanded, within its limits; it stops and brakes by itself when commands stop,
and says so. The contract is docs/contract.md.
"""

import math

import rclpy
from heave_msgs.msg import WinchCommand, WinchState
from rclpy.node import Node
from rosgraph_msgs.msg import Clock

WATCHDOG, SPEED, ACCELERATION, LAG = 0.5, 2.0, 1.5, 0.15  # [s], [m/s], [m/s^2], [s]


class Winch(Node):
    def __init__(self) -> None:
        super().__init__("my_winch")
        self.payout = self.rate = 0.0
        self.command = WinchCommand(brake=True)
        self.fault, self.is_acknowledged = WinchState.FAULT_NONE, False
        self.time = self.heard_at = 0.0
        self.publisher = self.create_publisher(WinchState, "winch/state", 10)
        self.create_subscription(WinchCommand, "winch/command", self.on_command, 1)
        self.create_subscription(Clock, "clock", self.on_clock, 10)

    def on_command(self, message: WinchCommand) -> None:
        is_resync = self.fault and message.brake and message.sequence != self.command.sequence
        if message.sequence <= self.command.sequence and not is_resync:
            return  # old news
        self.command, self.heard_at = message, self.time
        if not (math.isfinite(message.payout) and math.isfinite(message.payout_rate)):
            self.trip(WinchState.FAULT_INVALID_COMMAND)
        elif self.fault and message.brake:
            self.is_acknowledged = True
        elif self.fault and self.is_acknowledged and self.rate == 0.0:
            self.fault = WinchState.FAULT_NONE

    def release(self) -> int:
        """Return what a latched fault waits for."""
        if not self.fault:
            return WinchState.RELEASE_NONE
        if not self.is_acknowledged:
            return WinchState.RELEASE_BRAKE_REQUEST
        return WinchState.RELEASE_STANDSTILL if self.rate else WinchState.RELEASE_COMMAND

    def trip(self, fault: int) -> None:
        self.fault, self.is_acknowledged = self.fault or fault, False

    def on_clock(self, message: Clock) -> None:
        now = message.clock.sec + 1e-9 * message.clock.nanosec
        step, self.time = max(now - self.time, 0.0) if self.time else 0.0, now
        if not self.command.brake and not self.fault and now - self.heard_at > WATCHDOG:
            self.trip(WinchState.FAULT_COMMAND_TIMEOUT)
        stops = self.command.brake or bool(self.fault)
        wanted = 0.0 if stops else min(max(self.command.payout_rate, -SPEED), SPEED)
        change = wanted - self.rate if stops else (wanted - self.rate) * min(step / LAG, 1.0)
        self.rate += min(max(change, -ACCELERATION * step), ACCELERATION * step)
        self.payout += self.rate * step
        state = WinchState(command_sequence=self.command.sequence, fault=self.fault, brake=stops and self.rate == 0.0)
        state.header.stamp, state.release = message.clock, self.release()
        state.payout = state.payout_rate = state.payout_acceleration = state.tension = state.power = math.nan
        state.encoder_payout, state.encoder_payout_rate = self.payout, self.rate
        self.publisher.publish(state)


rclpy.init()
try:
    rclpy.spin(Winch())
except (KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
    pass
