"""Start cable_sim alone: ros2 launch cable_sim_node cable_sim.launch.py scenario:=FILE."""

from heave_node.ros.one_node import one_node
from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    """Return the node with the parameter file of the run."""
    return one_node("cable_sim_node", "cable_sim")
