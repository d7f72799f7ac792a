"""A vessel with its MRU in place of the simulated one.

heave run b2_calm_300 --pacing realtime --replace wave_vessel=external

The sea is a swell of one sine. The contract is docs/contract.md.
"""

import math

import rclpy
from heave_msgs.msg import MruSample, PointMotion
from rclpy.node import Node
from rosgraph_msgs.msg import Clock

AMPLITUDE, PERIOD, RAMP = 0.5, 8.0, 10.0  # [m], [s], [s]


class Vessel(Node):
    def __init__(self) -> None:
        super().__init__("my_vessel")
        self.samples = 0
        self.mru = self.create_publisher(MruSample, "mru", 10)
        self.boom_tip = self.create_publisher(PointMotion, "boom_tip", 10)
        self.create_subscription(Clock, "clock", self.on_clock, 10)

    def on_clock(self, message: Clock) -> None:
        heave, rate, acceleration = motion(message.clock.sec + 1e-9 * message.clock.nanosec)
        self.samples += 1
        sample = MruSample(sequence=self.samples, status=MruSample.STATUS_OK)
        sample.header.stamp = message.clock
        sample.heave, sample.heave_rate, sample.heave_acceleration = heave, rate, acceleration
        sample.heave_sigma, sample.heave_rate_sigma = 0.01, 0.01
        self.mru.publish(sample)
        tip = PointMotion()
        tip.header.stamp = message.clock
        tip.position.z, tip.velocity.z, tip.acceleration.z = heave, rate, acceleration
        self.boom_tip.publish(tip)


def motion(time: float) -> tuple[float, float, float]:
    """Return heave, its rate and acceleration, positive up [m], [m/s], [m/s^2]; the swell grows over RAMP."""
    omega = 2.0 * math.pi / PERIOD
    share = min(time / RAMP, 1.0)
    size = AMPLITUDE * share * share * (3.0 - 2.0 * share)
    sine, cosine = math.sin(omega * time), math.cos(omega * time)
    return size * sine, size * omega * cosine, -size * omega * omega * sine


rclpy.init()
try:
    rclpy.spin(Vessel())
except (KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
    pass
