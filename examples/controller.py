"""A controller in place of the suite's: heave run b2_calm_300 --pacing realtime --replace winch_controller=external.

It pays out what the boom tip rises: a feed-forward of the MRU, extrapolated by the time a command takes to act, with a
weak pull towards the middle of the drum. The contract is docs/contract.md.
"""

import rclpy
from heave_msgs.msg import MruSample, WinchCommand, WinchState
from rclpy.node import Node
from rosgraph_msgs.msg import Clock

AHEAD, PULL, BRAKED, SILENCE = 0.4, 0.05, 2.0, 0.3  # [s], [1/s], [s], [s]


class Controller(Node):
    def __init__(self) -> None:
        super().__init__("my_controller")
        self.sequence = 0
        self.sample: MruSample | None = None
        self.state: WinchState | None = None
        self.publisher = self.create_publisher(WinchCommand, "winch/command", 10)
        self.create_subscription(MruSample, "mru", self.on_mru, 10)
        self.create_subscription(WinchState, "winch/state", self.on_state, 10)
        self.create_subscription(Clock, "clock", self.on_clock, 10)

    def on_mru(self, message: MruSample) -> None:
        self.sample = message if message.status == MruSample.STATUS_OK else None

    def on_state(self, message: WinchState) -> None:
        self.state = message

    def on_clock(self, message: Clock) -> None:
        now = seconds(message.clock)
        self.sequence += 1
        command = WinchCommand(sequence=self.sequence, brake=True)
        command.header.stamp = message.clock
        is_well = self.sample and self.state and now - seconds(self.sample.header.stamp) < SILENCE
        if is_well and not self.must_brake(now):
            command.brake = False
            command.payout = self.sample.heave
            command.payout_rate = self.sample.heave_rate + AHEAD * self.sample.heave_acceleration
            command.payout_rate -= PULL * self.state.encoder_payout
        self.publisher.publish(command)

    def must_brake(self, now: float) -> bool:
        """Brake at the start, and until a latched fault waits for the command that releases it."""
        return now < BRAKED or self.state.release in (WinchState.RELEASE_BRAKE_REQUEST, WinchState.RELEASE_STANDSTILL)


def seconds(stamp: object) -> float:
    return stamp.sec + 1e-9 * stamp.nanosec


rclpy.init()
try:
    rclpy.spin(Controller())
except (KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
    pass
