"""The services of a recorder: start, stop, split, snapshot; and snapshots taken by themselves when something fails."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from heave_msgs.srv import SaveSnapshot, StartRecording
from heave_node.ros.diagnostics import Health, Level, alarm_health
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from std_srvs.srv import Trigger

from heave_bags.errors import BagError
from heave_bags.record.session import ALARMS, RecordingSession
from heave_bags.record.topic_watch import TopicWatch


def recording_health(session: RecordingSession, watch: TopicWatch, problems: Sequence[str]) -> Health:
    """Return what the `session` and `watch` of a recorder record and cannot record, and its other `problems`, each in a
    line.
    """
    values = {"written": str(session.state.written), "not_written": str(session.state.unwritten)}
    for code, found in (("RECORDING_FAILED", problems), ("TOPIC_UNREADABLE", watch.unreadable.values())):
        if found:
            return alarm_health("recording", ALARMS.alarm(code, problem="; ".join(found)), values)
    return Health("recording", Level.OK, str(session.folder or "stopped"), values)


def next_free(folder: Path) -> Path:
    """Return `folder`, or the first of `folder-2`, `folder-3` ... that does not exist."""
    number, free = 2, folder
    while free.exists():
        free = folder.with_name(f"{folder.name}-{number}")
        number += 1
    return free


class RecorderServices:
    """Offers the controls of a `session` as services under the name of its `node`; bags go into a `directory` where a
    request names none.
    """

    def __init__(self, node: Node, session: RecordingSession, directory: Path) -> None:
        self._session = session
        self._directory = directory
        self._node = node
        self._was_in_error = False
        name = node.get_name()
        node.create_service(StartRecording, f"{name}/start", self._start)
        node.create_service(Trigger, f"{name}/stop", self._stop)
        node.create_service(Trigger, f"{name}/split", self._split)
        node.create_service(SaveSnapshot, f"{name}/snapshot", self._snapshot)

    def _start(self, request: StartRecording.Request, response: StartRecording.Response) -> StartRecording.Response:
        folder = Path(request.directory) if request.directory else next_free(self._directory)

        def work() -> str:
            self._session.start(folder)
            return str(folder)

        return _answer(response, work)

    def _stop(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        return _answer(response, self._session.stop)

    def _split(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        def work() -> str:
            self._session.split()
            return str(self._session.folder)

        return _answer(response, work)

    def _snapshot(self, request: SaveSnapshot.Request, response: SaveSnapshot.Response) -> SaveSnapshot.Response:
        folder = Path(request.directory) if request.directory else self._snapshot_folder()

        def work() -> str:
            response.messages = self._session.save_snapshot(folder, round(max(request.seconds, 0.0) * 1e9))
            return str(folder)

        return _answer(response, work)

    def _snapshot_folder(self) -> Path:
        return next_free(self._directory.with_name(f"{self._directory.name}-snapshot"))

    def watch_for_faults(self, diagnostics: bytes) -> None:
        """Take a snapshot when a message of /diagnostics is the first to report an error."""
        message: DiagnosticArray = deserialize_message(diagnostics, DiagnosticArray)
        errors = [status for status in message.status if status.level == DiagnosticStatus.ERROR]
        if errors and not self._was_in_error:
            folder = self._snapshot_folder()
            try:
                count = self._session.save_snapshot(folder)
            except BagError as error:
                self._node.get_logger().error(f"no snapshot taken at the fault: {error}")
            else:
                text = f"{errors[0].name}: {errors[0].message}"
                self._node.get_logger().warning(f"{text}: the last {count} messages are in {folder}")
        self._was_in_error = bool(errors)


def _answer(response: Any, work: Callable[[], str]) -> Any:
    """Do the work of a service; its answer is the work's, or why it could not be done."""
    try:
        response.message = work()
        response.success = True
    except BagError as error:
        response.message = str(error)
        response.success = False
    return response
