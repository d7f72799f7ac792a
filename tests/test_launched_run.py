"""The launch file's part that is not launch's, and what launch does to a node: it puts it into a namespace, no more."""

import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest
from domain_coordinator import domain_id
from heave_bags.mcap.reader import Bag
from heave_bringup.run.launched import prepare, settings_of
from heave_bringup.scenarios import load_scenario
from heave_node.parameters import ParameterError
from heave_node.ros.node_parameters import launch_parameters

from tests.loop_runs import environment

LOOP = Path(__file__).parents[1] / "node_base" / "test" / "loop_program.py"
PEERS = ("wave_vessel", "winch_controller", "virtual_winch")
LAUNCH = shutil.which("ros2") if find_spec("launch_ros") and find_spec("ros2launch") else None


def needs_launch(test):
    """Mark a `test` that starts the whole loop by `ros2 launch`.

    Of launch there is no wheel: it comes with an installed ROS 2 alone, and where there is none the test is skipped. It
    takes a minute, so that it is one of the long tests. What does not need launch itself, the arguments and the
    namespace, is tested above in every run.
    """
    reason = "ros2 launch is not installed: docs/guide/install.md says how"
    return pytest.mark.slow(pytest.mark.long(pytest.mark.skipif(LAUNCH is None, reason=reason)(test)))


def test_arguments_change_the_scenario_as_the_options_of_the_command_do(tmp_path):
    arguments = {
        "scenario": "b2_calm_300",
        "folder": str(tmp_path / "run"),
        "pacing": "realtime",
        "duration": "30",
        "seed": "7",
        "set": "winch_controller.law=lqg 'system.sea.peak_period=7.5'",
        "replace": "virtual_winch=external wave_vessel=external",
    }
    folder, names = prepare(arguments)
    assert names == ["cable_sim", "winch_controller", "winch_adviser", "recorder"]
    stored = load_scenario(str(folder.scenario))
    assert (stored.run.duration, stored.run.seed, stored.run.pacing) == (30.0, 7, "realtime")
    assert stored.parameters["winch_controller"].law == "lqg"
    assert stored.parameters["wave_vessel"].peak_period == 7.5


def test_a_parameter_file_and_autostart_go_before_the_scenario_and_options_before_both(tmp_path):
    changes = tmp_path / "changes.yaml"
    changes.write_text(
        "/**:\n  ros__parameters:\n    duration: 40.0\n    seed: 5\n"
        "/**/winch_controller:\n  ros__parameters:\n    law: lqg\n"
    )
    given = {"params_file": str(changes), "autostart": "false", "seed": "7"}
    folder, _ = prepare({"scenario": "b2_calm_300", "folder": str(tmp_path / "run"), **given})
    stored = load_scenario(str(folder.scenario))
    assert (stored.run.duration, stored.run.seed, stored.run.autostart) == (40.0, 7, False)
    assert stored.parameters["winch_controller"].law == "lqg"


def test_arguments_of_one_node_are_its_parameters_the_last_ones_before_the_first():
    given = {"scenario": "run.yaml", "params_file": "mine.yaml", "autostart": "false"}
    assert launch_parameters(given) == ["run.yaml", "mine.yaml", {"autostart": False}]
    assert launch_parameters({**given, "params_file": "", "autostart": ""}) == ["run.yaml"]


def test_arguments_that_are_empty_change_nothing():
    assert settings_of({"pacing": "", "duration": "", "seed": "", "set": "", "replace": ""}) == []


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"seed": "seven"}, "seed:=seven"),
        ({"set": "winch_controller.lawn=lqg"}, "lawn"),
        ({"set": "a='b"}, "set:="),
        ({"duration": "-1"}, "duration:=-1"),
        ({"respawn": "true"}, "respawn:=true needs pacing:=realtime"),
        ({"params_file": "none.yaml"}, "none.yaml: cannot be read"),
        ({"replace": "wave_vessel"}, "replace:=wave_vessel"),
        ({"replace": "wave_vessel=bag:bag"}, "external, lockstep, none"),
    ],
)
def test_a_wrong_argument_is_refused_in_one_line(tmp_path, arguments, words):
    with pytest.raises(ParameterError) as refused:
        prepare({"scenario": "b2_calm_300", "folder": str(tmp_path / "run"), **arguments})
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_namespace_alone_is_enough_for_nodes_to_find_each_other_and_be_recorded(tmp_path):
    """No remapping of /clock or /diagnostics: PushRosNamespace gives none."""
    given = (f"participants:=[{', '.join((*PEERS, 'recorder'))}]", "duration:=2.0", f"directory:={tmp_path / 'bag'}")
    programs = {name: [str(LOOP), name] for name in (*PEERS, "cable_sim")}
    programs["recorder"] = ["-m", "heave_bags.record.recorder_node"]
    with domain_id() as domain:
        started = {}
        for name, program in programs.items():
            parameters = given if name == "recorder" else given[:2]
            ros = ["-r", "__ns:=/ship", *(part for text in parameters for part in ("-p", text))]
            command = [sys.executable, *program, "--ros-args", *ros]
            started[name] = subprocess.Popen(command, env=environment(domain), stdout=subprocess.DEVNULL)
        try:
            ended = {name: process.wait(60.0) for name, process in started.items()}
        finally:
            for process in started.values():
                process.kill()
    assert set(ended.values()) == {0}, ended
    topics = Bag(tmp_path / "bag").topics
    assert all(name.startswith("/ship/") for name in topics)
    assert {"/ship/clock", "/ship/diagnostics"} <= set(topics)
    assert topics["/ship/clock"].message_count == 40, "2 s of 0.05 s"


INCLUDING = """
from launch import LaunchDescription
from launch.actions import GroupAction, IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import PathJoinSubstitution
from launch_ros.actions import PushRosNamespace
from launch_ros.substitutions import FindPackageShare

def generate_launch_description():
    loop = PathJoinSubstitution([FindPackageShare("heave_bringup"), "launch", "loop.launch.py"])
    given = {"duration": "5", "seed": "3", "folder": "FOLDER", "set": "winch_controller.law=feedforward"}
    source = PythonLaunchDescriptionSource(loop)
    include = IncludeLaunchDescription(source, launch_arguments=given.items())
    return LaunchDescription([GroupAction([PushRosNamespace("ship"), include])])
"""


@needs_launch
def test_the_launch_file_is_included_within_a_namespace(tmp_path):
    file = tmp_path / "fleet.launch.py"
    file.write_text(INCLUDING.replace("FOLDER", str(tmp_path / "run")))
    run = launched(file)
    assert run.returncode == 0, run.stdout + run.stderr
    bag = Bag(tmp_path / "run" / "bag")
    assert bag.run["seed"] == "3"
    assert bag.topics["/ship/winch/command"].message_count == 100, "5 s of 0.05 s"


MANAGED = """
import launch
from launch_ros.event_handlers import OnStateTransition
from launch_ros.events import matches_node_name
from launch_ros.events.lifecycle import ChangeState, StateTransition
from lifecycle_msgs.msg import Transition

{including}
LOOP = generate_launch_description

def generate_launch_description():
    def change(name, transition):
        matcher = matches_node_name(f"/ship/{{name}}")
        return launch.actions.EmitEvent(event=ChangeState(lifecycle_node_matcher=matcher, transition_id=transition))
    names = [{names}]
    up = [change(name, Transition.TRANSITION_CONFIGURE) for name in names]
    on = [
        launch.actions.RegisterEventHandler(
            OnStateTransition(
                matcher=lambda event, name=name: isinstance(event, StateTransition) and event.action.node_name
                == f"/ship/{{name}}",
                goal_state="inactive",
                entities=[change(name, Transition.TRANSITION_ACTIVATE)],
            )
        )
        for name in names
    ]
    return LaunchDescription([*on, *LOOP().entities, launch.actions.TimerAction(period=4.0, actions=up)])
"""


def launched(file: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Launch a `file` with `arguments`."""
    with domain_id() as domain:
        command = [str(LAUNCH), "launch", str(file), *arguments]
        return subprocess.run(
            command, env=environment(domain), capture_output=True, text=True, timeout=300.0, check=False
        )


@needs_launch
def test_events_of_launch_configure_and_activate_the_nodes(tmp_path):
    names = ("wave_vessel", "winch_controller", "winch_adviser", "virtual_winch", "recorder", "cable_sim")
    file = tmp_path / "managed.launch.py"
    including = INCLUDING.replace("FOLDER", str(tmp_path / "run")).replace('"5",', '"5", "autostart": "false",')
    file.write_text(MANAGED.format(including=including, names=", ".join(map(repr, names))))
    run = launched(file)
    assert run.returncode == 0, run.stdout + run.stderr
    assert Bag(tmp_path / "run" / "bag").topics["/ship/winch/command"].message_count == 100, "5 s of 0.05 s"


@needs_launch
def test_arguments_of_the_launch_file_have_an_effect_on_the_processes(tmp_path):
    """In one process; with the lines of the debug log, which the nodes print at their start."""
    loop = Path(__file__).parents[1] / "bringup" / "launch" / "loop.launch.py"
    given = ("composed:=true", "log_level:=debug", "duration:=5")
    run = launched(loop, "scenario:=b2_calm_300", f"folder:={tmp_path / 'run'}", *given)
    assert run.returncode == 0, run.stdout + run.stderr
    assert Bag(tmp_path / "run" / "bag").run["composed"] == "true"
    assert "[DEBUG]" in run.stdout + run.stderr
