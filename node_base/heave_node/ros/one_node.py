"""The launch file of one node by itself; needs ROS 2's packages launch and launch_ros, which nothing else here does."""

from launch import LaunchDescription  # type: ignore[attr-defined]  # mypy takes our folders launch for it
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from heave_node.ros.transport.parents_death import environment


def one_node(package: str, executable: str) -> LaunchDescription:
    """Return the node with the parameter file of the run, its argument `scenario`.

    Parameters
    ----------
    package : ROS package that installs it
    executable : its name there
    """
    return LaunchDescription(
        [
            DeclareLaunchArgument("scenario", description="Parameter file that all nodes of the run share."),
            Node(
                package=package,
                executable=executable,
                parameters=[LaunchConfiguration("scenario")],
                output="screen",
                additional_env=environment(),  # no node outlives its launch
            ),
        ]
    )
