"""Start the whole loop: ros2 launch heave_bringup loop.launch.py scenario:=b2_calm_300.

The nodes are those of `heave run`, each by the launch file of its own package, in the namespace of whoever includes
this file. The run ends when they do; a node that fails takes the others down.
"""

import sys

from heave_bringup.errors import CommandError
from heave_bringup.nodes import PROCESS_BY_NAME
from heave_bringup.run.composed import program
from heave_bringup.run.launched import ARGUMENTS, RESPAWNED, prepare
from heave_node.parameters import ParameterError
from heave_node.ros.transport.parents_death import environment
from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import (
    DeclareLaunchArgument,
    GroupAction,
    IncludeLaunchDescription,
    LogInfo,
    OpaqueFunction,
    RegisterEventHandler,
    Shutdown,
)
from launch.event_handlers import OnProcessExit
from launch.events.process import ProcessExited
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node, PushRosNamespace
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    """Return the loop with its arguments."""
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=default, description=meaning)
                for name, (default, meaning) in ARGUMENTS.items()
            ),
            OpaqueFunction(function=start_nodes),
        ]
    )


def start_nodes(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    """Check the scenario, put the run's parameter file into its folder, and start every node with it."""
    arguments = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    try:
        folder, names = prepare(arguments)
    except (ParameterError, CommandError) as error:
        return [LogInfo(msg=f"heave: {error}"), Shutdown(reason=str(error))]
    given = {"scenario": str(folder.scenario), "log_level": arguments["log_level"]}
    respawned = RESPAWNED if arguments["respawn"] == "true" else ()
    if arguments["composed"] == "true":
        nodes: list[LaunchDescriptionEntity] = [all_in_one(names, given)]
    else:
        nodes = [
            IncludeLaunchDescription(
                PythonLaunchDescriptionSource(launch_file_of(name)),
                launch_arguments={**given, "respawn": str(name in respawned).lower()}.items(),
            )
            for name in names
        ]
    return [
        LogInfo(msg=f"bag folder: {folder.bag}"),
        end_with_the_first_failure_of_others(respawned),
        GroupAction([PushRosNamespace(arguments["namespace"]), *nodes]),
    ]


def all_in_one(names: list[str], given: dict[str, str]) -> Node:
    """Return one process with all nodes of these `names`, by the arguments that are `given` to each of them."""
    module, *own = program(names, is_public=True)
    return Node(
        executable=sys.executable,
        arguments=["-m", module, *own],
        parameters=[given["scenario"]],
        ros_arguments=["--log-level", given["log_level"]],
        output="screen",
        additional_env=environment(),
    )


def launch_file_of(node: str) -> PathJoinSubstitution:
    """Return the launch file of one node, in the package that has it."""
    package = PROCESS_BY_NAME[node].module.partition(".")[0]
    return PathJoinSubstitution([FindPackageShare(package), "launch", f"{node}.launch.py"])


def end_with_the_first_failure_of_others(respawned: tuple[str, ...]) -> RegisterEventHandler:
    """End the launch when a node ends with an error, but for `respawned` ones; nodes that are done end one by one."""

    def on_exit(event: ProcessExited, _: LaunchContext) -> Shutdown | None:
        is_respawned = event.process_name.rpartition("-")[0] in respawned
        return Shutdown(reason=f"{event.process_name} failed") if event.returncode and not is_respawned else None

    return RegisterEventHandler(OnProcessExit(on_exit=on_exit))
