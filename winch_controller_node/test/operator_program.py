"""An operator as a program: waits for compensation, asks for modes, a redesign and moves; prints what came of it."""

import json
import sys
import time

import rclpy
from heave_msgs.action import MoveToDepth
from heave_msgs.msg import ControllerState
from heave_msgs.srv import Redesign, SetMode
from rclpy.action import ActionClient


class Operator:
    """Calls services and the action of the controller, one after the other."""

    def __init__(self) -> None:
        self.node = rclpy.create_node("operator")
        self.state = ControllerState()
        self.feedback: list[MoveToDepth.Feedback] = []
        self.node.create_subscription(ControllerState, "controller/state", self._on_state, 10)
        self.set_mode = self.node.create_client(SetMode, "controller/set_mode")
        self.redesign = self.node.create_client(Redesign, "controller/redesign")
        self.move = ActionClient(self.node, MoveToDepth, "controller/move_to_depth")

    def _on_state(self, message: ControllerState) -> None:
        self.state = message

    def wait(self, future: rclpy.Future, seconds: float = 60.0) -> object:
        """Spin until `future` is done and return its result."""
        rclpy.spin_until_future_complete(self.node, future, timeout_sec=seconds)
        assert future.done(), "no answer"
        return future.result()

    def wait_for_mode(self, mode: str, seconds: float = 90.0) -> None:
        """Spin until the controller is in `mode`."""
        end = time.monotonic() + seconds
        while self.state.mode != mode:
            assert time.monotonic() < end, f"mode {self.state.mode}, not {mode}"
            rclpy.spin_once(self.node, timeout_sec=0.1)

    def start_move(self, depth: float, speed: float) -> object:
        """Send a goal and return its handle."""
        goal = MoveToDepth.Goal(depth=depth, speed=speed)
        return self.wait(self.move.send_goal_async(goal, feedback_callback=lambda m: self.feedback.append(m.feedback)))


def main() -> None:
    """Do the round."""
    rclpy.init()
    operator = Operator()
    operator.wait_for_mode("compensating")
    assert operator.move.wait_for_server(30.0)
    refused = operator.wait(operator.set_mode.call_async(SetMode.Request(mode="dance")))
    redesigned = operator.wait(operator.redesign.call_async(Redesign.Request(significant_wave_height=2.0)))
    as_assumed = operator.wait(operator.redesign.call_async(Redesign.Request()))
    base = float(sys.argv[1])
    handle = operator.start_move(base + 1.0, 0.3)
    moved = operator.wait(handle.get_result_async()).result
    end = time.monotonic() + 10.0
    while operator.feedback[-1].time_to_go > 0.0 and time.monotonic() < end:  # DDS keeps no order of two topics
        rclpy.spin_once(operator.node, timeout_sec=0.1)
    arrived = operator.feedback[-1]
    too_deep = operator.wait(operator.start_move(base + 500.0, 0.3).get_result_async()).result
    handle = operator.start_move(base + 20.0, 0.5)
    operator.wait(handle.cancel_goal_async())
    cancelled = operator.wait(handle.get_result_async()).result
    stop = operator.wait(operator.set_mode.call_async(SetMode.Request(mode="emergency_stop")))
    operator.wait_for_mode("emergency_stop")
    sys.stdout.write(
        json.dumps(
            {
                "refused": [refused.success, refused.message],
                "redesigned": [redesigned.success, redesigned.message, redesigned.predicted_unit_sigma],
                "moved": [moved.success, moved.message, moved.depth],
                "as_assumed": [as_assumed.success, as_assumed.message],
                "feedback": [[f.depth, f.rate, f.time_to_go] for f in operator.feedback],
                "arrived": [arrived.depth, arrived.rate, arrived.time_to_go],
                "too_deep": [too_deep.success, too_deep.message],
                "cancelled": [cancelled.success, cancelled.message, cancelled.depth],
                "stopped": [stop.success, stop.message],
            }
        )
        + "\n"
    )


if __name__ == "__main__":
    main()
