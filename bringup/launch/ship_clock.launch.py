"""Start the clock of a run whose plant is the ship: ros2 launch heave_bringup ship_clock.launch.py scenario:=FILE."""

from heave_node.ros.one_node import one_node
from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    """Return the node with the parameter file of the run."""
    return one_node("heave_bringup", "ship_clock")
