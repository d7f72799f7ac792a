"""Stand-ins for the sea and the controller of a loop with the real plant and the real winch.

Run as `python peer_program.py NODE --ros-args ...`. The controller asks for a constant payout rate and prints at the
end, as JSON, what it received.
"""

import json
import math
import os
import signal
import sys
from dataclasses import dataclass

import numpy as np
import rclpy
from cable_sim_node.conversions import point_motion_message
from heave_msgs.msg import TickStatus, WinchCommand, WinchState
from heave_msgs.srv import InjectFault
from heave_node.interface import sensors, topics
from heave_node.numerics.kinematics import PointMotion
from heave_node.parameters import parameter
from heave_node.ros.participant import ParticipantNode
from heave_node.ros.process import run_node
from heave_node.ros.transport.qos import qos_of
from heave_node.tick.tick import Tick, nanoseconds_of
from std_msgs.msg import Header

HEARD = (
    topics.CABLE_STATE,
    topics.UNIT_ODOMETRY,
    topics.UNIT_UNCOMPENSATED,
    topics.UNIT_PRESSURE,
    topics.UNIT_VELOCITY,
    sensors.IMU.topic,
    sensors.USBL.topic,
    topics.LOAD_CELL,
    topics.MARKERS,
    topics.WINCH_STATE,
)


@dataclass(frozen=True)
class SeaParameters:
    unused: bool = parameter(True, description="Nothing.")


@dataclass(frozen=True)
class ControllerParameters:
    rate: float = parameter(0.1, "m/s", description="Requested payout rate.")
    die_in_tick: int = parameter(0, description="Tick in which the controller is killed; 0: it lives.")
    inject: str = parameter("", description="NODE DEVICE KIND, ...: faults to ask for in tick 10.")


class Sea(ParticipantNode):
    name = "wave_vessel"
    parameters_type = SeaParameters

    def on_build(self) -> None:
        self.tip = self.add_output(topics.BOOM_TIP)
        self.winch = self.add_input(topics.WINCH_STATE)
        self.heard = []

    def on_tick(self, tick: Tick) -> None:
        t = tick.end_nanoseconds * 1e-9
        height, rate = 0.5 * (1.0 - math.cos(0.8 * t)), 0.4 * math.sin(0.8 * t)
        motion = PointMotion(t, np.array([0.0, 0.0, height]), np.array([0.0, 0.0, rate]))
        self.tip.publish(point_motion_message(motion, tick.end_nanoseconds))
        self.heard += self.take(self.winch)

    def on_run_ended(self, status: TickStatus) -> None:
        result = {
            "reason": status.reason,
            "times": [nanoseconds_of(m.header.stamp) * 1e-9 for m in self.heard],
            "rates": [m.payout_rate for m in self.heard],
            "faults": [m.fault for m in self.heard],
            "brakes": [m.brake for m in self.heard],
        }
        sys.stdout.write(json.dumps(result) + "\n")


class Controller(ParticipantNode):
    name = "winch_controller"
    parameters_type = ControllerParameters
    after = ("wave_vessel",)

    def on_build(self) -> None:
        self.command = self.add_output(topics.WINCH_COMMAND)
        self.ports = {topic.name: self.add_input(topic) for topic in HEARD}
        self.heard = {name: [] for name in self.ports}
        self.fault_answers = []
        faults = [words.split() for words in self.parameters.inject.split(",") if words]
        self.injected = [(self.create_client(InjectFault, f"{node}/inject_fault"), *fault) for node, *fault in faults]

    def on_tick(self, tick: Tick) -> None:
        if tick.number == self.parameters.die_in_tick:
            os.kill(os.getpid(), signal.SIGKILL)
        for name, port in self.ports.items():
            self.heard[name] += self.take(port)
        for client, device, kind in self.injected if tick.number == 10 else ():
            request = InjectFault.Request(device=device, kind=kind, duration=0.0, magnitude=1.0)
            client.call_async(request).add_done_callback(self._on_answer)
        self.command.publish(
            WinchCommand(header=Header(stamp=tick.stamp), sequence=tick.number, payout_rate=self.parameters.rate)
        )

    def _on_answer(self, future: object) -> None:
        self.fault_answers.append(future.result().message)

    def on_run_ended(self, status: TickStatus) -> None:
        cable, winch = self.heard["cable/state"], self.heard["winch/state"]
        pressure = self.heard["unit/pressure"]
        markers = self.heard["markers"]
        result = {
            "ended": status.state == TickStatus.ENDED,
            "counts": {name: len(messages) for name, messages in self.heard.items()},
            "cable_stamps": [nanoseconds_of(m.header.stamp) for m in cable],
            "winch_stamps": [nanoseconds_of(m.header.stamp) for m in winch],
            "pressure_stamps": [nanoseconds_of(m.header.stamp) for m in pressure],
            "pressure": [m.fluid_pressure for m in pressure],
            "top_tension": [m.top_tension for m in cable],
            "length": [m.unstretched_length for m in cable],
            "tip": [m.nodes[-1].z for m in cable],
            "unit": [m.pose.pose.position.z for m in self.heard["unit/odometry"]],
            "uncompensated": [m.position.z for m in self.heard["unit_uncompensated"]],
            "payout": [m.payout for m in winch],
            "power": [m.power for m in winch],
            "tension": [m.tension for m in winch],
            "brake": [m.brake for m in winch],
            "fault": [m.fault for m in winch],
            "imu": [m.linear_acceleration.z for m in self.heard["unit/imu"]],
            "markers": [[m.ns, m.type, len(m.points)] for m in markers[-1].markers] if markers else [],
            "cable_marker": [[p.x, p.y, p.z] for p in markers[-1].markers[0].points] if markers else [],
            "marker_stamp": nanoseconds_of(markers[-1].markers[0].header.stamp) if markers else 0,
            "cable_nodes": {str(nanoseconds_of(m.header.stamp)): [[p.x, p.y, p.z] for p in m.nodes] for m in cable},
            "answers": sorted(self.fault_answers),
        }
        sys.stdout.write(json.dumps(result) + "\n")


def run_hardware_winch() -> int:
    """Publish, until the run ends, a drum that lets out 0.1 m/s: an encoder only, stamps of the wall clock, 50 Hz."""
    rclpy.init(args=sys.argv)
    node = rclpy.create_node("hardware_winch")
    publisher = node.create_publisher(WinchState, "winch/state", qos_of(topics.WINCH_STATE.role))
    states: list[int] = []
    node.create_subscription(
        TickStatus, topics.TICK_STATUS.name, lambda m: states.append(m.state), qos_of(topics.TICK_STATUS.role)
    )
    began = None
    nan = math.nan
    while not states or states[-1] not in (TickStatus.ENDED, TickStatus.FAILED):
        rclpy.spin_once(node, timeout_sec=0.02)
        now = node.get_clock().now()
        if states and states[-1] == TickStatus.RUNNING and began is None:
            began = now
        running = 0.0 if began is None else (now - began).nanoseconds * 1e-9
        publisher.publish(
            WinchState(
                header=Header(stamp=now.to_msg()),
                payout=nan,
                payout_rate=nan,
                payout_acceleration=nan,
                encoder_payout=0.1 * running,
                encoder_payout_rate=0.0 if began is None else 0.1,
            )
        )
    return 0


if __name__ == "__main__":
    if sys.argv[1] == "hardware_winch":
        sys.exit(run_hardware_winch())
    nodes = {node.name: node for node in (Sea, Controller)}
    sys.exit(run_node(nodes[sys.argv[1]], sys.argv))
