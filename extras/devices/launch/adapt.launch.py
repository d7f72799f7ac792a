"""Put devices into a run by their maps: ros2 launch heave_devices adapt.launch.py maps:='my_mru.yaml my_winch.yaml'."""

from heave_node.ros.transport.parents_death import environment
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, OpaqueFunction
from launch.substitutions import LaunchConfiguration


def generate_launch_description() -> LaunchDescription:
    """Return `heave adapt` with the maps, the namespace and the network option that are given."""
    return LaunchDescription(
        [
            DeclareLaunchArgument("maps", description="Map files, or names of shipped maps, with spaces between them."),
            DeclareLaunchArgument("namespace", default_value="", description="Namespace of the run."),
            DeclareLaunchArgument("network", default_value="false", description="true: nodes on other hosts join."),
            OpaqueFunction(function=_adapter),
        ]
    )


def _adapter(context: object) -> list[ExecuteProcess]:
    maps, namespace, network = (LaunchConfiguration(name).perform(context) for name in ("maps", "namespace", "network"))
    options = ["--namespace", namespace] if namespace else []
    options += ["--network"] if network == "true" else []
    command = ["heave", "adapt", *maps.split(), *options]
    return [ExecuteProcess(cmd=command, output="screen", additional_env=environment())]
