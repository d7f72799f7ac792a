"""The launch file of one node by itself; needs ROS 2's packages launch and launch_ros, which nothing else here does."""

from __future__ import annotations

from typing import Any

from launch import LaunchContext, LaunchDescription  # type: ignore[attr-defined]  # mypy takes our folders launch for it
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import LifecycleNode

from heave_node.ros.node_parameters import launch_parameters
from heave_node.ros.transport.parents_death import environment

ARGUMENTS = {
    "params_file": ("", "Parameter file that goes before the scenario; empty: none."),
    "log_level": ("info", "debug, info, warn, error or fatal."),
    "autostart": ("", "false: a lifecycle manager configures and activates the node; empty: as in the scenario."),
    "respawn": ("false", "true: start the node again when it ends; in a run in real time it resumes its place."),
}
"""Default and meaning of each argument beside the scenario."""


def one_node(package: str, executable: str) -> LaunchDescription:
    """Return a node, named as its executable, with the parameter file of the run, its argument `scenario`.

    Parameters
    ----------
    package : ROS package that installs it
    executable : its name there
    """

    def start(context: LaunchContext) -> list[Any]:
        given = {name: LaunchConfiguration(name).perform(context) for name in ("scenario", *ARGUMENTS)}
        return [lifecycle_node(executable, given, package=package, executable=executable)]

    return LaunchDescription(
        [
            DeclareLaunchArgument("scenario", description="Parameter file that all nodes of the run share."),
            *(
                DeclareLaunchArgument(name, default_value=default, description=meaning)
                for name, (default, meaning) in ARGUMENTS.items()
            ),
            OpaqueFunction(function=start),
        ]
    )


def lifecycle_node(name: str, given: dict[str, str], **program: Any) -> LifecycleNode:
    """Return a node that events of launch can configure and activate, and that never outlives its launch.

    Parameters
    ----------
    name : of the node
    given : arguments of the launch, by name
    program : what runs it, as launch_ros has it
    """
    return LifecycleNode(
        name=name,
        namespace="",
        parameters=launch_parameters(given),
        ros_arguments=["--log-level", given["log_level"]],
        respawn=given["respawn"] == "true",
        respawn_delay=1.0,
        output="screen",
        additional_env=environment(),
        **program,
    )
