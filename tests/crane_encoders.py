"""The encoders of a crane: `python crane_encoders.py pencr PORT` or `... joint_states`, until it is ended.

It follows `clock`, which stands for the crane itself: at START its slew begins, by TURN in LASTING, a quintic ramp from
the slew of the scenario `crane_slew`. It says so five times a second (simulated) as the line `$PENCR`, anticlockwise
from 0 to a turn, or as sensor_msgs/JointState with stamps of the clock. It shares no code with the suite.
"""

import math
import socket
import sys

import rclpy
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

START, LASTING, TURN = 14.0, 20.0, 1.0472
SLEW, LUFF, KNUCKLE = 1.5708, 0.9, -0.9
EVERY = 4
"""Ticks from one pose to the next."""


def slew_at(time: float) -> float:
    s = min(max((time - START) / LASTING, 0.0), 1.0)
    return SLEW + TURN * s**3 * (10.0 - 15.0 * s + 6.0 * s**2)


def encoded(angle: float) -> str:
    """Return an angle [rad] as the number of the line: a turn is 65536."""
    return f"{round(angle / math.tau * 65536) % 65536:04X}"


def main() -> None:
    rclpy.init()
    node = rclpy.create_node("crane_encoders")
    line = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    is_line = sys.argv[1] == "pencr"
    states = None if is_line else node.create_publisher(JointState, "/crane/joint_states", 10)
    heard = 0

    def on_clock(clock: Clock) -> None:
        nonlocal heard
        heard += 1
        if heard % EVERY:
            return
        slew = slew_at(clock.clock.sec + 1e-9 * clock.clock.nanosec)
        if states is None:
            angles = ",".join(encoded(angle) for angle in (slew, LUFF, KNUCKLE))
            line.sendto(f"$PENCR,{angles},0000,0000\r\n".encode(), ("127.0.0.1", int(sys.argv[2])))
            return
        state = JointState(name=["luff", "slew", "knuckle"], position=[LUFF, slew, KNUCKLE])
        state.header.stamp = clock.clock
        states.publish(state)

    node.create_subscription(Clock, "clock", on_clock, 10)
    rclpy.spin(node)


if __name__ == "__main__":
    main()
