"""A stand-alone recorder: every topic that appears, on a ship or beside any other program, without the tick protocol.

Messages get the time of their arrival, by the host's clock or by `/clock` where `use_sim_time` is on.
"""

from __future__ import annotations

import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path
from types import FrameType

import rclpy
from heave_node.interface import topics
from heave_node.interface.messages import message_type
from heave_node.parameters import ParameterError
from heave_node.ros.diagnostics import diagnostic_array
from heave_node.ros.node import steady_clock
from heave_node.ros.node_parameters import read_parameters
from heave_node.ros.process import leave_ros
from heave_node.ros.release import DISTRIBUTION
from heave_node.ros.spin import spin
from heave_node.ros.transport.environment import prepare_environment
from heave_node.ros.transport.watchdog import watched_start
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future

from heave_bags.errors import BagError
from heave_bags.mcap.bag_writer import BagWriter
from heave_bags.mcap.files import COMPLETE
from heave_bags.mcap.storage import open_in_background
from heave_bags.record.parameters import RecorderParameters
from heave_bags.record.provenance import describe_run, scenario_attachments
from heave_bags.record.recorder_services import RecorderServices, recording_health
from heave_bags.record.sequence_gaps import SequenceGaps
from heave_bags.record.session import RecordingSession
from heave_bags.record.topic_watch import TopicWatch

LOOK_PERIOD = 0.2
"""Wall time between two looks for new topics [s]."""
DIAGNOSTICS_PERIOD = 1.0
TOO_LATE = "dropped by the middleware before the recorder took them"
"""Why messages are missing whose publisher counted on: this machine was too busy, or the recorder was stopped."""


class LiveRecorder(Node):
    """Records whatever is published. `finished` completes when it is asked to end."""

    def __init__(self) -> None:
        super().__init__("recorder", automatically_declare_parameters_from_overrides=True)
        _, self.parameters = read_parameters(self, RecorderParameters)
        self.finished: Future[None] = Future()
        self._sees_faults = self.parameters.snapshot_duration > 0.0
        self.session = RecordingSession(self._make_writer, self.parameters.ring(), survive=True)
        self.watch = TopicWatch(self, self.parameters.exclude)
        self._missed: dict[str, int] = {}
        self._gaps = SequenceGaps(self._note_gap)
        self.controls = RecorderServices(self, self.session, Path(self.parameters.directory))
        diagnostics = topics.DIAGNOSTICS
        self._diagnostics = self.create_publisher(message_type(diagnostics.type), diagnostics.name, 10)
        if self.parameters.record:
            self.session.start(Path(self.parameters.directory))
        steady = steady_clock()
        self.create_timer(LOOK_PERIOD, self._look, clock=steady)
        self.create_timer(DIAGNOSTICS_PERIOD, self._publish_diagnostics, clock=steady)

    def _make_writer(self, folder: Path) -> BagWriter:
        parameters = self.parameters
        now = self.get_clock().now().nanoseconds
        description = describe_run(
            scenario=parameters.scenario, seed=0, pacing="realtime", tick_period=0.0, transient=0.0
        )
        for key in ("tick_period_s", "seed", "transient_s", "composed", "replaced"):
            del description[key]
        return BagWriter(
            folder,
            policy=parameters.policy(),
            run={**description, "host_time_minus_log_time_ns": str(time.time_ns() - now)},
            attachments=scenario_attachments(parameters.scenario_file),
            ros_distro=DISTRIBUTION,
            opener=open_in_background,
        )

    def _look(self) -> None:
        for topic in [*self.watch.look(), *self.watch.outdated()]:
            self.watch.unsubscribe(topic)
            problem = self.session.add_topic(topic, self.watch.types[topic], self.watch.offers[topic])
            if problem:
                self.get_logger().warning(problem)
            self.watch.subscribe(topic, self._taker(topic))

    def _note_gap(self, topic: str, messages: int) -> None:
        """Note that a number of `messages` on a `topic` were dropped before they were taken."""
        self._missed[topic] = self._missed.get(topic, 0) + messages
        self.session.note_missed(messages, TOO_LATE)

    def _taker(self, topic: str) -> Callable[..., None]:
        write, clock = self.session.write, self.get_clock()
        watches = topic == self.resolve_topic_name(topics.DIAGNOSTICS.name) and self._sees_faults

        def take(data: bytes, _: object) -> None:
            write(topic, clock.now().nanoseconds, data)
            if watches:
                self.controls.watch_for_faults(data)

        return self._gaps.noting(topic, take)

    def _publish_diagnostics(self) -> None:
        stamp = self.get_clock().now().to_msg()
        health = recording_health(self.session, self.watch, self.problems())
        self._diagnostics.publish(diagnostic_array(self.get_name(), stamp, [health]))

    def problems(self) -> list[str]:
        """Return what went wrong, each in a line."""
        missed = ", ".join(f"{topic} {count}" for topic, count in sorted(self._missed.items()))
        late = [f"{sum(self._missed.values())} messages are missing, {TOO_LATE}: {missed}"] if missed else []
        return [*self.session.state.problems, *late]

    def close(self) -> list[str]:
        """End the bag, as whoever recorded wants it; return what went wrong."""
        if self.session.is_recording:
            try:
                self.session.stop({"ended": "; ".join(self.problems()) or COMPLETE})
            except BagError as error:
                self.session.state.problems.append(str(error))
        self.session.finish()
        return self.problems()


def record(args: list[str] | None = None) -> int:
    """Record until SIGINT or SIGTERM; return the exit status. `args` are ROS arguments: parameters, remaps.

    Raises BagError or ParameterError for what cannot be recorded as asked.
    """
    prepare_environment()
    with watched_start():
        rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
        recorder = LiveRecorder()

    def on_signal(_number: int, _frame: FrameType | None) -> None:
        if not recorder.finished.done():
            recorder.finished.set_result(None)

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, on_signal)
    try:
        spin(recorder, recorder.finished, recorder.session.acknowledge)
    finally:
        problems = recorder.close()
        written = recorder.session.state.written
        leave_ros(recorder)
    sys.stderr.write("".join(f"recorder: {line}\n" for line in [*problems, f"{written} messages recorded"]))
    return 1 if problems else 0


def main() -> None:
    """Record from the command line."""
    try:
        sys.exit(record(sys.argv))
    except (BagError, ParameterError, MemoryError) as error:
        sys.exit(f"recorder: {error}")


if __name__ == "__main__":
    main()
