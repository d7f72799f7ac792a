"""Start cable_sim alone: ros2 launch cable_sim_node cable_sim.launch.py scenario:=FILE."""

from heave_node.ros.transport.parents_death import environment
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def generate_launch_description() -> LaunchDescription:
    """Return the node with the parameter file of the run."""
    return LaunchDescription(
        [
            DeclareLaunchArgument("scenario", description="Parameter file that all nodes of the run share."),
            Node(
                package="cable_sim_node",
                executable="cable_sim",
                parameters=[LaunchConfiguration("scenario")],
                output="screen",
                additional_env=environment(),  # no node outlives its launch
            ),
        ]
    )
