"""Every topic of a run as Foxglove takes it: messages as they are, their definitions, and a frame that is the unit."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable
from pathlib import Path

from foxglove import Schema, start_server
from foxglove.channels import FrameTransformChannel
from foxglove.messages import FrameTransform, Quaternion, Timestamp, Vector3
from foxglove.websocket import Capability, WebSocketServer
from heave_bags.mcap.ros.ros_qos import request_for
from heave_bags.record.topic_watch import TopicWatch
from heave_bringup.errors import CommandError, NoRunError
from heave_node.cdr.definitions import DefinitionError, schema_text
from heave_node.interface import topics
from heave_node.interface.messages import message_type
from heave_node.ros.process import leave_ros, node_beside
from heave_node.ros.spin import Spinner
from heave_node.ros.transport.environment import prepare_environment
from nav_msgs.msg import Odometry
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message

from heave_panel.view.shown_topic import ShownTopic

FINDING_TIME = 4.0
"""Wall time in which a run that is under way is found [s]."""
LOOK_PERIOD = 1.0
"""Wall time between two looks for new topics [s]."""
QUEUE = 10
LAYOUT = Path("share/heave_bags/config/heave.foxglove.json")
WORLD, UNIT = "world", "unit"
"""Frames; the camera of the layout follows the unit."""
FRAME_TOPIC = "/unit_frame"


class Stream:
    """Serves what a run or a replayed bag in this ROS domain publishes; takes no part in it and holds nothing up.

    Parameters
    ----------
    namespace : of the run; "" for none. The topics are served without it, so that one layout fits all
    port : on localhost

    Raises NoRunError where there is no run, CommandError where the port is taken.
    """

    def __init__(self, namespace: str, port: int) -> None:
        prepare_environment()
        self._prefix = f"/{namespace.strip('/')}" if namespace.strip("/") else ""
        simulated_time = Parameter("use_sim_time", value=True)
        self._node = node_beside(f"heave_view_{os.getpid()}", namespace, parameter_overrides=[simulated_time])
        self._watch = TopicWatch(self._node, exclude=("/rosout", "/parameter_events", "*/transition_event"))
        self._spinner = Spinner(self._node)
        self._shown: list[ShownTopic] = []
        self._server: WebSocketServer | None = None
        self._complaints: set[str] = set()
        try:
            self._find()
            self._frame = FrameTransformChannel(FRAME_TOPIC)
            while self._look():  # what is there already is there for the first viewer
                self._spinner.spin_for(LOOK_PERIOD)
            self._server = start_server(
                name="heave", host="127.0.0.1", port=port, capabilities=[Capability.Time], supported_encodings=["cdr"]
            )
        except (RuntimeError, OSError) as error:
            self._leave()
            raise CommandError(f"port {port}: cannot be served: {error}; see --port") from None
        except BaseException:
            self._leave()
            raise

    def serve(self) -> None:
        """Serve until Ctrl-C."""
        try:
            while True:
                self._look()
                self._spinner.spin_for(LOOK_PERIOD)
                for shown in self._shown:
                    shown.repeat(self._node.get_clock().now().nanoseconds)
        except KeyboardInterrupt:
            pass  # the way to end it
        finally:
            if self._server is not None:
                self._server.stop()
            self._leave()

    def _find(self) -> None:
        deadline = time.monotonic() + FINDING_TIME
        while self._node.count_publishers(topics.CLOCK.name) == 0:  # of a run, or of a bag that is replayed
            if time.monotonic() > deadline:
                domain = os.environ.get("ROS_DOMAIN_ID", "0")
                where = f"ROS domain {domain}{self._prefix and ', namespace '}{self._prefix}"
                raise NoRunError(
                    f"no run and no replayed bag in {where}: start one with heave run or heave replay, or "
                    "set ROS_DOMAIN_ID to the one of the run"
                )
            self._spinner.spin_for(0.1)

    def _look(self) -> bool:
        """Show the topics that have appeared since the last look; tell whether there were any."""
        found = self._watch.look()
        for name in found:
            type_name = self._watch.types[name]
            shown = name.removeprefix(self._prefix) if name.startswith(f"{self._prefix}/") else name
            try:
                schema = Schema(name=type_name, encoding="ros2msg", data=schema_text(type_name).encode())
            except DefinitionError as error:
                self._complain(f"{shown} is not shown: {error}")
                continue
            self._subscribe(name, shown, schema)
        return bool(found)

    def _subscribe(self, name: str, shown: str, schema: Schema) -> None:
        offered = request_for(self._watch.offers[name])
        is_latched = offered.durability == DurabilityPolicy.TRANSIENT_LOCAL
        topic = ShownTopic(shown, schema, is_latched=is_latched, is_late=self._server is not None)
        self._shown.append(topic)
        # nobody waits for a viewer: what it does not take in time is lost to it alone
        newest = QoSProfile(depth=QUEUE, reliability=ReliabilityPolicy.BEST_EFFORT)
        kind = message_type(self._watch.types[name])
        self._node.create_subscription(kind, name, self._taker(topic), offered if is_latched else newest, raw=True)

    def _taker(self, topic: ShownTopic) -> Callable[[bytes], None]:
        clock = self._node.get_clock()
        is_clock = topic.name == f"/{topics.CLOCK.name}"
        is_unit = topic.name == f"/{topics.UNIT_ODOMETRY.name}"

        def take(data: bytes) -> None:
            now = clock.now().nanoseconds
            topic.show(data, now)
            if is_clock and self._server is not None:
                self._server.broadcast_time(now)
            elif is_unit:
                self._show_frame(deserialize_message(data, Odometry), now)

        return take

    def _show_frame(self, unit: Odometry, now: int) -> None:
        place, turn = unit.pose.pose.position, unit.pose.pose.orientation
        frame = FrameTransform(
            timestamp=Timestamp(unit.header.stamp.sec, unit.header.stamp.nanosec),
            parent_frame_id=WORLD,
            child_frame_id=UNIT,
            translation=Vector3(x=place.x, y=place.y, z=place.z),
            rotation=Quaternion(x=turn.x, y=turn.y, z=turn.z, w=turn.w),
        )
        self._frame.log(frame, log_time=now)

    def _complain(self, text: str) -> None:
        if text not in self._complaints:
            self._complaints.add(text)
            sys.stderr.write(f"{text}\n")

    def _leave(self) -> None:
        self._spinner.close()
        leave_ros(self._node)


def layout_file() -> Path | None:
    """Return the layout for Foxglove that is installed with the suite; None where there is none."""
    prefixes = os.environ.get("AMENT_PREFIX_PATH", sys.prefix).split(os.pathsep)
    return next((Path(prefix) / LAYOUT for prefix in prefixes if (Path(prefix) / LAYOUT).exists()), None)
