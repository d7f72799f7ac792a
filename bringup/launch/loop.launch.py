"""Start the whole loop: ros2 launch heave_bringup loop.launch.py scenario:=b2_calm_300.

The nodes are those of `heave run`, each by the launch file of its own package, in the namespace of whoever includes
this file. The run ends when they do; a node that fails takes the others down.
"""

from heave_bringup.errors import CommandError
from heave_bringup.nodes import PROCESS_BY_NAME
from heave_bringup.run.launched import ARGUMENTS, prepare
from heave_node.parameters import ParameterError
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
from launch_ros.actions import PushRosNamespace
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    """Return the loop with its arguments."""
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=default, description=meaning)
                for name, (default, meaning) in ARGUMENTS.items()
            ),
            RegisterEventHandler(OnProcessExit(on_exit=end_with_the_first_failure)),
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
    given = {"scenario": str(folder.scenario)}
    nodes = [
        IncludeLaunchDescription(PythonLaunchDescriptionSource(launch_file_of(name)), launch_arguments=given.items())
        for name in names
    ]
    return [
        LogInfo(msg=f"bag folder: {folder.bag}"),
        GroupAction([PushRosNamespace(arguments["namespace"]), *nodes]),
    ]


def launch_file_of(node: str) -> PathJoinSubstitution:
    """Return the launch file of one node, in the package that has it."""
    package = PROCESS_BY_NAME[node].module.partition(".")[0]
    return PathJoinSubstitution([FindPackageShare(package), "launch", f"{node}.launch.py"])


def end_with_the_first_failure(event: ProcessExited, _: LaunchContext) -> Shutdown | None:
    """End the launch when a node ends with an error; nodes that are done end one by one."""
    return Shutdown(reason=f"{event.process_name} failed") if event.returncode else None
