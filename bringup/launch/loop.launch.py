"""Start the whole loop: ros2 launch heave_bringup loop.launch.py scenario:=b2_calm_300.

The nodes are those of `heave run`, each by the launch file of its own package. The run ends when they do; a node that
fails takes the others down.
"""

from pathlib import Path

from heave_bringup.nodes import PROCESS_BY_NAME
from heave_bringup.run.run import new_run_folder, nodes_to_start, store_scenario
from heave_bringup.scenarios import load_scenario
from heave_bringup.settings import Setting
from heave_node.scenario import WILDCARD
from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import (
    DeclareLaunchArgument,
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
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    """Return the loop with its arguments."""
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "scenario", default_value="b2_calm_300", description="Shipped scenario or parameter file."
            ),
            DeclareLaunchArgument(
                "folder", default_value="", description="Folder for the bag; empty: runs/SCENARIO-NNN."
            ),
            DeclareLaunchArgument(
                "pacing", default_value="", description="lockstep or realtime; empty: as in the scenario."
            ),
            DeclareLaunchArgument("external", default_value="", description="Nodes not to start, separated by commas."),
            RegisterEventHandler(OnProcessExit(on_exit=end_with_the_first_failure)),
            OpaqueFunction(function=start_nodes),
        ]
    )


def start_nodes(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    """Check the scenario, put the run's parameter file into its folder, and start every node with it."""
    scenario_name, folder_name, pacing, external = (
        LaunchConfiguration(name).perform(context) for name in ("scenario", "folder", "pacing", "external")
    )
    settings = []
    if pacing:
        settings.append(Setting(WILDCARD, "pacing", pacing, f"pacing:={pacing}"))
    if external:
        settings.append(Setting(WILDCARD, "external", external.split(","), f"external:={external}"))
    scenario = load_scenario(scenario_name, settings=settings)
    folder = new_run_folder(scenario.name, Path(folder_name) if folder_name else None)
    store_scenario(scenario, folder)
    arguments = {"scenario": str(folder.scenario)}
    nodes = [
        IncludeLaunchDescription(
            PythonLaunchDescriptionSource(launch_file_of(node)), launch_arguments=arguments.items()
        )
        for node in nodes_to_start(scenario)
    ]
    return [LogInfo(msg=f"bag folder: {folder.bag}"), *nodes]


def launch_file_of(node: str) -> PathJoinSubstitution:
    """Return the launch file of one node, in the package that has it."""
    package = PROCESS_BY_NAME[node].module.partition(".")[0]
    return PathJoinSubstitution([FindPackageShare(package), "launch", f"{node}.launch.py"])


def end_with_the_first_failure(event: ProcessExited, _: LaunchContext) -> Shutdown | None:
    """End the launch when a node ends with an error; nodes that are done end one by one."""
    return Shutdown(reason=f"{event.process_name} failed") if event.returncode else None
