"""A wave radar that predicts the boom tip's heave, once a second, beside vessel.py, whose swell it sees come.

heave run b2_calm_300 --pacing realtime --replace wave_vessel=external --set winch_controller.mpc.preview_time=4
The contract is docs/contract.md.
"""

import math

import rclpy
from heave_msgs.msg import HeavePreview
from rclpy.node import Node
from rosgraph_msgs.msg import Clock

AMPLITUDE, PERIOD, RAMP = 0.5, 8.0, 10.0  # of the swell, as in vessel.py [m], [s], [s]
LENGTH, STEP = 6.0, 0.25  # of the preview [s]


class Radar(Node):
    def __init__(self) -> None:
        super().__init__("my_radar")
        self.scanned = -1
        self.preview = self.create_publisher(HeavePreview, "vessel/heave_preview", 10)
        self.create_subscription(Clock, "clock", self.on_clock, 10)

    def on_clock(self, message: Clock) -> None:
        if message.clock.sec == self.scanned:
            return
        self.scanned = message.clock.sec
        now = message.clock.sec + 1e-9 * message.clock.nanosec
        ahead = [STEP * step for step in range(1, round(LENGTH / STEP) + 1)]
        preview = HeavePreview(ahead=ahead, heave=[heave(now + time) for time in ahead], heave_sigma=0.01)
        preview.header.stamp = message.clock
        self.preview.publish(preview)


def heave(time: float) -> float:
    """Return heave, positive up [m]; the swell grows over RAMP."""
    share = min(time / RAMP, 1.0)
    return AMPLITUDE * share * share * (3.0 - 2.0 * share) * math.sin(2.0 * math.pi / PERIOD * time)


rclpy.init()
try:
    rclpy.spin(Radar())
except (KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
    pass
