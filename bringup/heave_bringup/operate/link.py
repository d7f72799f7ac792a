"""The way to a run over ROS: what its nodes publish, taken as a `Situation`; their services, action and joystick."""

from __future__ import annotations

import os
import time
from dataclasses import fields
from operator import attrgetter
from typing import Any

from action_msgs.msg import GoalStatus
from action_msgs.srv import CancelGoal
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TwistStamped
from heave_bags.analyse.events import MODE_PART
from heave_msgs.action import MoveToDepth
from heave_msgs.msg import CompensationKpi, ControllerState, LoadCell, TickStatus, WinchState
from heave_node.interface import topics
from heave_node.ros.process import leave_ros, node_beside
from heave_node.ros.spin import Spinner
from heave_node.ros.transport.environment import prepare_environment
from heave_node.ros.transport.qos import qos_of
from heave_node.tick.tick import seconds_of
from rclpy.action import ActionClient
from rclpy.client import Client
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.task import Future

from heave_bringup.errors import NoRunError
from heave_bringup.operate.requests import (
    ANSWER_TIME,
    CONTROLLER,
    NODE_OF_DEVICE,
    Answer,
    Request,
    Task,
    refusal,
    request_fault,
    request_mode,
)
from heave_bringup.operate.situation import ControllerStatus, Figures, RunStatus, Situation, WinchStatus
from heave_bringup.replacements import FROM_BAG

MEETING_TIME = 6.0
"""Wall time in which a service of a run that was found must show itself [s]."""
MOVE = "controller/move_to_depth"


class ServiceCall:
    """A `request` to a service, sent by its `client` as soon as the service is met."""

    def __init__(self, client: Client[Any, Any], request: Request) -> None:
        self._client, self._request = client, request
        self._began = time.monotonic()
        self._future: Future[Any] | None = None
        self._send()

    def _send(self) -> None:
        if self._client.service_is_ready():
            self._future = self._client.call_async(self._request.message)

    def poll(self) -> Answer | None:
        """See `tasks.Task`."""
        request, waited = self._request, time.monotonic() - self._began
        if self._future is None:
            self._send()
            if self._future is None and waited > MEETING_TIME:
                return refusal(
                    f"{request.service}: nobody serves it: {request.node} has no part in the run, or has ended"
                )
            return None
        if self._future.done():
            return request.judge(self._future.result())
        if waited > request.bound:
            return refusal(f"{request.service}: {request.node} has not answered within {request.bound:g} s")
        return None

    def cancel(self) -> None:
        """See `tasks.Task`: a service that was called does its work."""


class DepthMove:
    """A move of the unit by the action of the controller.

    Parameters
    ----------
    link : to the run
    mover : client of the action
    depth : mean depth to go to, positive down [m]
    speed : largest mean speed [m/s]; 0: the controller's own

    Attributes
    ----------
    is_under_way : the controller has begun it
    progress : mean depth [m], rate [m/s] and time to go [s], newest; None before the first
    """

    def __init__(self, link: RunLink, mover: ActionClient[Any, Any, Any], depth: float, speed: float) -> None:
        self._link, self._mover = link, mover
        self._goal = MoveToDepth.Goal(depth=depth, speed=speed)
        self._began = link.wall_time
        self._sent: Future[Any] | None = None
        self._result: Future[Any] | None = None
        self._handle: Any = None
        self.is_under_way = False
        self.progress: tuple[float, float, float] | None = None

    def _on_feedback(self, message: Any) -> None:
        feedback = message.feedback
        self.is_under_way = True
        self.progress = (feedback.depth, feedback.rate, feedback.time_to_go)

    def poll(self) -> Answer | None:
        """See `tasks.Task`."""
        waited = self._link.wall_time - self._began
        if self._sent is None:
            if self._mover.server_is_ready():
                self._sent = self._mover.send_goal_async(self._goal, feedback_callback=self._on_feedback)
            elif waited > MEETING_TIME:
                return refusal(f"{MOVE}: nobody serves it: {CONTROLLER} has no part in the run, or has ended")
            return None
        if self._result is None:
            return self._take_acceptance(waited)
        if self._result.done():
            return self._words(self._result.result())
        if self._link.situation.is_over:
            return refusal("the run ended before the move was complete")
        return None

    def _take_acceptance(self, waited: float) -> Answer | None:
        assert self._sent is not None
        if self._sent.done():
            self._handle = self._sent.result()
            if not self._handle.accepted:
                return refusal(
                    "the controller takes no move now: another one is under way (hold ends it) or it is inactive"
                )
            self._result = self._handle.get_result_async()
        elif waited > ANSWER_TIME:
            return refusal(f"{MOVE}: {CONTROLLER} has not answered within {ANSWER_TIME:g} s")
        return None

    @staticmethod
    def _words(ended: Any) -> Answer:
        result = ended.result
        if ended.status == GoalStatus.STATUS_SUCCEEDED:
            return Answer(f"{result.message}: mean depth {result.depth:.2f} m")
        return refusal(f"refused: {result.message}; mean depth {result.depth:.2f} m")

    def cancel(self) -> None:
        """End the move smoothly."""
        if self._handle is not None:
            self._handle.cancel_goal_async()


FINDING_TIME = 4.0
"""Wall time in which a run that is under way is found [s]."""
LOOK_PERIOD = 0.02
"""Wall time between two looks at a task [s]."""
LETTING_GO_TIME = 15.0
"""Wall time that a task has to end smoothly after Ctrl-C [s]."""
SURVEY_PERIOD = 2.0
"""Wall time between two looks at which devices are simulated [s]."""
_of_run = attrgetter("state", "reason", "tick", "simulated_time", "real_time_factor", "missed_deadlines")
_of_controller = attrgetter(
    *("mode", "law", "reason", "authority"),
    *("predicted_unit_heave", "predicted_boom_tip_heave", "predicted_uncompensated_heave", "depth_set_point"),
)
_of_winch = attrgetter("encoder_payout", "encoder_payout_rate", "tension", "brake", "fault")
_figures = attrgetter(*(one.name for one in fields(Figures)))
NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
"""Quality of service where only the newest message matters: a screen never delays a run."""


class RunLink:
    """The way to the run in this ROS domain and in a namespace.

    It takes no part in the run: it reads, calls services, and publishes on the joystick's topic alone.

    Parameters
    ----------
    namespace : of the run; "" for none

    Attributes
    ----------
    situation : the newest that is known of the run
    heard_at : when the clock master last said how the run goes, monotonic wall time [s]

    Raises NoRunError where there is none.
    """

    def __init__(self, namespace: str = "") -> None:
        prepare_environment()
        self._namespace = namespace.strip("/")
        self._node = node_beside(f"heave_operate_{os.getpid()}", namespace)
        self.situation = Situation()
        self.heard_at = self.wall_time
        self._surveyed_at = self.wall_time
        self._clients: dict[str, Client[Any, Any]] = {}
        self._subscribe()
        self._joystick = self._node.create_publisher(TwistStamped, "controller/operator_speed", 1)
        self._mover: ActionClient[Any, Any, Any] = ActionClient(self._node, MoveToDepth, MOVE)
        self._spinner = Spinner(self._node)
        for request in (request_mode("emergency_stop"), request_fault("winch", "emergency_stop")):
            self._client(request.kind, request.service)  # met beforehand: an emergency stop does not wait for that
        try:
            self._find()
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Leave ROS."""
        self._spinner.close()
        self._mover.destroy()
        leave_ros(self._node)

    @property
    def place(self) -> str:
        """ROS domain and namespace, in words."""
        domain = f"ROS domain {os.environ.get('ROS_DOMAIN_ID', '0')}"
        return f"{domain}, namespace /{self._namespace}" if self._namespace else domain

    @property
    def wall_time(self) -> float:
        """Monotonic wall time [s]."""
        return time.monotonic()

    def spin(self, seconds: float) -> None:
        """Listen for `seconds` of wall time."""
        self._spinner.spin_for(seconds)

    def listen(self, seconds: float) -> None:
        """Listen until controller and winch have spoken, or for `seconds` of wall time."""
        deadline = self.wall_time + seconds
        while (self.situation.controller is None or self.situation.winch is None) and self.wall_time < deadline:
            self.spin(LOOK_PERIOD)
        self._survey()

    def finish(self, task: Task) -> Answer:
        """Look at a `task` until it has its answer; Ctrl-C lets it go, smoothly."""
        try:
            while (answer := task.poll()) is None:
                self.spin(LOOK_PERIOD)
        except KeyboardInterrupt:
            task.cancel()
            deadline = self.wall_time + LETTING_GO_TIME
            while (answer := task.poll()) is None:
                if self.wall_time > deadline:
                    return refusal("interrupted; what was asked for may go on: see status")
                self.spin(LOOK_PERIOD)
        return answer

    # what can be requested

    def start(self, request: Request) -> ServiceCall:
        """Send a `request`; the task has the answer."""
        return ServiceCall(self._client(request.kind, request.service), request)

    def start_move(self, depth: float, speed: float) -> DepthMove:
        """Request a move to a mean `depth` [m] at no more than `speed` [m/s]; 0 is the controller's own."""
        return DepthMove(self, self._mover, depth, speed)

    def cancel_moves(self) -> ServiceCall:
        """Let the controller end the move that is under way, smoothly, whoever has asked for it."""

        def judge(response: Any) -> Answer:
            if response.return_code == CancelGoal.Response.ERROR_NONE and response.goals_canceling:
                return Answer("the move ends smoothly; compensation goes on")
            return refusal("no move is under way")

        return self.start(
            Request(CancelGoal, f"{MOVE}/_action/cancel_goal", CancelGoal.Request(), CONTROLLER, judge=judge)
        )

    def ask_speed(self, speed: float) -> None:
        """Ask for a `speed` of the mean payout now, positive lowers [m/s]; a joystick's is positive up."""
        message = TwistStamped()
        message.twist.linear.z = -speed
        self._joystick.publish(message)

    def _client(self, kind: type[Any], service: str) -> Client[Any, Any]:
        if service not in self._clients:
            self._clients[service] = self._node.create_client(kind, service)
        return self._clients[service]

    # finding the run

    def _find(self) -> None:
        self._listen(FINDING_TIME)
        # on a busy machine a run may be seen before it is heard
        if self.situation.run is None and self._node.count_publishers(topics.TICK_STATUS.name):
            self._listen(MEETING_TIME)
        if self.situation.run is None or self.situation.is_over:
            raise NoRunError(self._no_run())

    def _listen(self, longest: float) -> None:
        """Wait until a run is heard, at most so long [s]."""
        deadline = self.wall_time + longest
        while self.situation.run is None and self.wall_time < deadline:
            self.spin(LOOK_PERIOD)

    def _no_run(self) -> str:
        where = self.place
        ending = f"/{topics.TICK_STATUS.name}"
        names = [
            name.removesuffix(ending) for name, _ in self._node.get_topic_names_and_types() if name.endswith(ending)
        ]
        others = [
            name for name in names if name.strip("/") != self._namespace and self._node.count_publishers(name + ending)
        ]
        if others:
            options = [f"--namespace {name}" if name else "without --namespace" for name in others]
            return f"no run in {where}; there is one {' and one '.join(options)}"
        return (
            f"no run in {where} was heard within {FINDING_TIME:g} s: start one with heave run, set ROS_DOMAIN_ID to "
            "that of the run, or try again on a busy machine"
        )

    # what is heard

    def _subscribe(self) -> None:
        subscribe = self._node.create_subscription
        subscribe(TickStatus, topics.TICK_STATUS.name, self._on_status, qos_of(topics.TICK_STATUS.role))
        subscribe(ControllerState, topics.CONTROLLER_STATE.name, self._on_controller, NEWEST)
        subscribe(WinchState, topics.WINCH_STATE.name, self._on_winch, NEWEST)
        subscribe(LoadCell, topics.LOAD_CELL.name, self._on_load_cell, NEWEST)
        subscribe(CompensationKpi, topics.CONTROLLER_KPI.name, self._on_figures, NEWEST)
        subscribe(DiagnosticArray, topics.DIAGNOSTICS.name, self._on_diagnostics, qos_of(topics.DIAGNOSTICS.role))

    def _on_status(self, message: TickStatus) -> None:
        self.heard_at = self.wall_time
        self.situation.run = RunStatus(*_of_run(message))
        if self.heard_at - self._surveyed_at > SURVEY_PERIOD:
            self._surveyed_at = self.heard_at
            self._survey()

    def _survey(self) -> None:
        """See which devices are simulated, as hardware does not let faults be injected, and which nodes a bag plays."""
        serving = {
            node for node in set(NODE_OF_DEVICE.values()) if self._node.count_services(f"{node}/inject_fault") > 0
        }
        self.situation.simulated = tuple(device for device, node in NODE_OF_DEVICE.items() if node in serving)
        nodes = self._node.get_node_names_and_namespaces()
        own = [name for name, namespace in nodes if namespace.strip("/") == self._namespace]
        self.situation.played = tuple(name.removesuffix(FROM_BAG) for name in own if name.endswith(FROM_BAG))

    def _on_load_cell(self, message: LoadCell) -> None:
        self.situation.load_cell = message.tension

    def _on_controller(self, message: ControllerState) -> None:
        newest = ControllerStatus(seconds_of(message.header.stamp), *_of_controller(message))
        newest.limits = tuple(message.active_limits)
        self.situation.controller = newest

    def _on_winch(self, message: WinchState) -> None:
        newest = WinchStatus(seconds_of(message.header.stamp), *_of_winch(message))
        self.situation.winch = newest.since(self.situation.winch)

    def _on_figures(self, message: CompensationKpi) -> None:
        self.situation.figures = Figures(*_figures(message))

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for part in message.status:
            self.situation.note(part.name, int.from_bytes(part.level, "little"), part.message)
            if part.name == MODE_PART:
                reported = {value.key: value.value for value in part.values}
                self.situation.depth = float(reported.get("mean depth [m]", "nan"))
