"""Start winch_envelope alone: ros2 launch winch_controller_node winch_envelope.launch.py scenario:=FILE."""

from heave_node.ros.one_node import one_node
from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    """Return the node with the parameter file of the run."""
    return one_node("winch_controller_node", "winch_envelope")
