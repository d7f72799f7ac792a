"""The action `controller/move_to_depth`: accepted, fed back and ended from the tick, so that nothing blocks."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from heave_msgs.action import MoveToDepth
from heave_node.ros.node import HeaveNode
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.task import Future

from winch_controller_node.core.component import WinchController
from winch_controller_node.core.supervision.modes import Mode, ModeError

FEEDBACK_PERIOD = 0.5
"""Simulated time between two feedback messages [s]."""


class MoveAction:
    """Serves one move at a time.

    Parameters
    ----------
    node : that owns the action
    controller : returns the present controller component
    """

    def __init__(self, node: HeaveNode, controller: Callable[[], WinchController]) -> None:
        self._node = node
        self._controller = controller
        self._goal: Any = None
        self._ended: Any = None
        self._next_feedback = 0.0
        self._server = ActionServer(
            node,
            MoveToDepth,
            "controller/move_to_depth",
            execute_callback=self._execute,
            goal_callback=self._consider,
            cancel_callback=_accept_cancel,
        )

    def on_tick(self, time: float) -> None:
        """Feed back at `time` [s], and end the move when it has arrived, was cancelled, or cannot go on."""
        goal = self._goal
        if goal is None:
            return
        controller = self._controller()
        if goal.is_cancel_requested:
            controller.cancel_move()
            if not controller.mean.is_moving:
                self._end("canceled", "stopped smoothly")
            return
        if controller.mode is not Mode.COMPENSATING:
            self._end("aborted", f"mode {controller.mode.value}: {controller.modes.reason}")
        elif controller.is_operated:
            self._end("aborted", "the operator's speed has taken over")
        elif not controller.mean.is_moving:
            self._feed_back()  # its time to go is 0
            self._end("succeeded", "arrived")
        elif time >= self._next_feedback:
            self._next_feedback = time + FEEDBACK_PERIOD
            self._feed_back()

    def _feed_back(self) -> None:
        controller = self._controller()
        feedback = MoveToDepth.Feedback()
        feedback.depth = controller.depth
        feedback.rate = controller.mean.point.rate
        feedback.time_to_go = controller.mean.time_to_go
        self._goal.publish_feedback(feedback)

    def abort(self, reason: str) -> None:
        """End the move that is under way, if any, for a `reason`."""
        if self._goal is not None:
            self._end("aborted", reason)

    def _consider(self, goal: MoveToDepth.Goal) -> GoalResponse:
        is_sound = math.isfinite(goal.depth) and math.isfinite(goal.speed) and goal.speed >= 0.0
        is_free = self._node.is_active and self._goal is None
        return GoalResponse.ACCEPT if is_sound and is_free else GoalResponse.REJECT

    async def _execute(self, goal: Any) -> MoveToDepth.Result:
        result = MoveToDepth.Result()
        try:
            self._controller().move_to_depth(goal.request.depth, goal.request.speed)
        except ModeError as error:
            goal.abort()
            result.message, result.depth = str(error), self._controller().depth
            return result
        self._goal, self._ended = goal, Future()
        how, result.message = await self._ended
        result.success = how == "succeeded"
        result.depth = self._controller().depth
        {"succeeded": goal.succeed, "canceled": goal.canceled, "aborted": goal.abort}[how]()
        return result

    def _end(self, how: str, message: str) -> None:
        ended, self._goal, self._ended = self._ended, None, None
        ended.set_result((how, message))


def _accept_cancel(_goal: Any) -> CancelResponse:
    return CancelResponse.ACCEPT
