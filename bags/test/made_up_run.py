"""Bags of a made-up run whose motions are sines, so that every figure of it is known in closed form."""

from __future__ import annotations

import math
import os
import sys
from dataclasses import dataclass
from pathlib import Path

os.environ.setdefault("AMENT_PREFIX_PATH", sys.prefix)

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import Point, Vector3
from heave_bags.mcap.bag_writer import Attachment, BagPolicy, BagWriter
from heave_bags.mcap.ros.qos import OfferedQos
from heave_bags.mcap.writer import ChunkPolicy
from heave_msgs.msg import (
    CableState,
    ControllerState,
    PointMotion,
    SeaState,
    SensorHealth,
    WinchState,
)
from nav_msgs.msg import Odometry
from rclpy.serialization import serialize_message
from std_msgs.msg import Header

SCENARIO = b"""
/**: {ros__parameters: {transient: 10.0, seed: 7, system: {winch: {speed_limit: 2.0, acceleration_limit: 1.2}}}}
/**/virtual_winch: {ros__parameters: {acceleration_limit: 1.5}}
/**/wave_vessel: {ros__parameters: {boom_tip_source: regular, period: 8.0}}
"""


@dataclass(frozen=True)
class MadeUpRun:
    """Amplitudes [m], tension [N], period [s]; the winch follows the boom tip, and the unit keeps a little of its
    motion.
    """

    duration: float = 60.0
    period: float = 8.0
    boom_tip: float = 1.0
    payout: float = 0.95
    unit: float = 0.05
    uncompensated: float = 1.1
    mean_tension: float = 36_000.0
    tension: float = 1_500.0
    nodes: int = 5
    tick: float = 0.05

    @property
    def omega(self) -> float:
        return 2.0 * math.pi / self.period


TYPES = {
    "/boom_tip": "heave_msgs/msg/PointMotion",
    "/cable/state": "heave_msgs/msg/CableState",
    "/controller/state": "heave_msgs/msg/ControllerState",
    "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
    "/sea_state": "heave_msgs/msg/SeaState",
    "/unit/odometry": "nav_msgs/msg/Odometry",
    "/unit_uncompensated": "heave_msgs/msg/PointMotion",
    "/winch/state": "heave_msgs/msg/WinchState",
}


def header(nanoseconds: int) -> Header:
    stamped = Header(frame_id="world")
    stamped.stamp.sec, stamped.stamp.nanosec = divmod(nanoseconds, 1_000_000_000)
    return stamped


def tick_messages(run: MadeUpRun, nanoseconds: int) -> dict[str, object]:
    """Return the messages of one tick by topic."""
    time = nanoseconds * 1e-9
    sine, cosine = math.sin(run.omega * time), math.cos(run.omega * time)
    head = header(nanoseconds)

    def point(amplitude: float, mean: float = 0.0) -> PointMotion:
        velocity = Vector3(z=amplitude * run.omega * cosine)
        return PointMotion(header=head, position=Point(z=mean + amplitude * sine), velocity=velocity)

    unit = Odometry(header=head, child_frame_id="unit")
    unit.pose.pose.position.z = -300.0 + run.unit * sine
    winch = WinchState(
        header=head,
        payout=run.payout * sine,
        payout_rate=run.payout * run.omega * cosine,
        payout_acceleration=-run.payout * run.omega**2 * sine,
        encoder_payout=run.payout * sine,
        limits_hit=WinchState.LIMIT_SPEED if 20.0 <= time < 22.0 else 0,
    )
    cable = CableState(
        header=head,
        nodes=[Point(z=-300.0 + 300.0 * index / (run.nodes - 1)) for index in range(run.nodes)],
        segment_tension=[run.mean_tension] * (run.nodes - 1),
        top_tension=run.mean_tension + run.tension * sine,
        bottom_tension=run.mean_tension,
    )
    controller = ControllerState(
        header=head,
        mode="standby" if time < 5.0 else "compensating",
        law="lqg",
        reason="waiting for the estimator" if time < 5.0 else "",
        measurement_names=["mru", "depth"],
        innovation=[0.01 * math.sin(37.0 * time), math.nan if round(time / run.tick) % 2 else 0.02 * sine],
        innovation_sigma=[0.01, 0.02],
        nis=[1.0, math.nan if round(time / run.tick) % 2 else 9.0],
        sensors=[SensorHealth(sensor="mru", level=2 if 30.0 <= time < 31.0 else 0)],
    )
    messages: dict[str, object] = {
        "/boom_tip": point(run.boom_tip),
        "/cable/state": cable,
        "/controller/state": controller,
        "/unit/odometry": unit,
        "/unit_uncompensated": point(run.uncompensated, -300.0),
        "/winch/state": winch,
    }
    if nanoseconds % 1_000_000_000 == 0:
        level = DiagnosticStatus.WARN if 40.0 <= time <= 42.0 else DiagnosticStatus.OK
        status = DiagnosticStatus(level=level, name="cable_sim: cable", message="touches ground")
        status.values = [KeyValue(key="largest strain", value=f"{1e-4 * time:.4f}")]
        messages["/diagnostics"] = DiagnosticArray(header=head, status=[status])
    return messages


def write_run(
    folder: Path,
    run: MadeUpRun | None = None,
    policy: BagPolicy | None = None,
    *,
    close: bool = True,
    offset: int = 0,
    scenario: bytes = SCENARIO,
) -> BagWriter:
    """Write a made-up run with a `scenario` to a bag, whose clock begins at `offset` [ns]; without `close`, the writer
    is left as a killed process would leave it.
    """
    run = run or MadeUpRun()
    description = {"scenario": "made_up", "seed": "7", "transient_s": "10.0", "pacing": "lockstep"}
    attachments = [Attachment("scenario.yaml", "application/yaml", scenario)]
    writer = BagWriter(
        folder,
        policy=policy or BagPolicy(ChunkPolicy(size=64 * 1024)),
        run=description,
        attachments=attachments,
        ros_distro="kilted",
    )
    for topic, message_type in TYPES.items():
        latched = topic == "/sea_state"
        writer.add_topic(topic, message_type, [OfferedQos(durability="transient_local" if latched else "volatile")])
    period = round(run.tick * 1e9)
    writer.write("/sea_state", period, bytes(serialize_message(SeaState(header=header(period), spectrum="regular"))))
    for number in range(1, round(run.duration / run.tick) + 1):
        for topic, message in tick_messages(run, offset + number * period).items():
            writer.write(topic, offset + number * period, bytes(serialize_message(message)))
    if close:
        outcome = {
            "ended": "complete",
            "real_time_factor": "50.0",
            "loop_age_p50_s": "0.001",
            "loop_age_p99_s": "0.002",
        }
        writer.close({**outcome, "loop_age_max_s": "0.01", "missed_deadlines": "0"})
    return writer
