"""What is asked of a run over ROS and answered later: a call of a service, and a move by the controller's action."""

from __future__ import annotations

import time
from typing import Any

from action_msgs.msg import GoalStatus
from heave_msgs.action import MoveToDepth
from rclpy.action import ActionClient
from rclpy.client import Client
from rclpy.task import Future

from heave_bringup.operate.requests import ANSWER_TIME, CONTROLLER, Answer, Request, refusal
from heave_bringup.operate.tasks import Link

MEETING_TIME = 6.0
"""Wall time in which a service of a run that was found must show itself [s]."""
MOVE = "controller/move_to_depth"


class ServiceCall:
    """A request to a service, sent as soon as the service is met.

    Parameters
    ----------
    client : of the service
    request : what is asked
    """

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

    def __init__(self, link: Link, mover: ActionClient[Any, Any, Any], depth: float, speed: float) -> None:
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
            return refusal("the run ended before the move had arrived")
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
