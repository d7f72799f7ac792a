"""The nodes of `examples/` take the places of the suite's, and `heave check` finds them as the contract says."""

import json
import subprocess
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np
import pytest
from domain_coordinator import domain_id
from heave_bags.mcap.reader import Bag
from heave_bringup.errors import ExitStatus

from tests.loop_runs import HAS_RUN, beside, give, recorded_messages

EXAMPLES = Path(__file__).parents[1] / "examples"
PROGRAM = {"virtual_winch": "winch.py", "wave_vessel": "vessel.py", "winch_controller": "controller.py"}
RADAR = {"radar": "radar.py"}


@contextmanager
def running(nodes: list[str], domain: int, *arguments: str) -> Iterator[None]:
    with ExitStack() as stack:
        for node in nodes:
            stack.enter_context(beside(domain, str(EXAMPLES / (PROGRAM | RADAR)[node]), *arguments))
        yield


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.parametrize("nodes", [["virtual_winch"], ["wave_vessel", "winch_controller"]], ids=" and ".join)
def test_the_loop_closes_with_the_examples_in_place_of_its_nodes(nodes, tmp_path):
    options = ["--pacing", "realtime", "--duration", "45", "--no-report", "--set", "all.transient=30.0"]
    options += ["--set", "winch_controller.modes.settling_time=5.0", "--set", "wave_vessel.ramp=5.0"]
    options += [word for node in nodes for word in ("--replace", f"{node}=external")]
    with domain_id() as domain, running(nodes, domain):
        run = give(domain, "run", "b2_calm_300", "--bag", str(tmp_path / "run"), *options)
    assert run.returncode in HAS_RUN, run.stderr
    topics = {"/unit/odometry": ["pose.pose.position.z"], "/unit_uncompensated": ["position.z"]}
    columns = Bag(tmp_path / "run" / "bag").columns(topics)
    unit, free = (columns[topic][fields[0]][columns[topic]["time"] > 30.0] for topic, fields in topics.items())
    assert np.std(unit) < 0.5 * np.std(free), "an untuned loop removes more than half of the heave"


@pytest.mark.slow
@pytest.mark.long
def test_the_plant_may_be_the_ship_itself(tmp_path):
    """MRU and winch are external too, and nobody knows the truth: the suite is the clock, controller and recorder.

    No tick of the controller takes less than a microsecond: its budget of time is a warning in the report.
    """
    nodes = ["wave_vessel", "virtual_winch"]
    options = ["--pacing", "realtime", "--duration", "25", "--json", str(tmp_path / "kpi.json")]
    options += ["--set", "all.transient=15.0", "--set", "winch_controller.modes.settling_time=5.0"]
    options += ["--set", "all.time_budgets=['winch_controller=work:1.0e-6']"]
    options += [word for node in (*nodes, "cable_sim") for word in ("--replace", f"{node}=external")]
    with domain_id() as domain, running(nodes, domain):
        run = give(domain, "run", "b2_calm_300", "--bag", str(tmp_path / "run"), *options)
    assert run.returncode in HAS_RUN, run.stderr
    figures = json.loads((tmp_path / "kpi.json").read_text())
    assert figures["sources"]["load heave"] == "estimated"
    assert figures["sources"]["payout"] == "measured"
    assert figures["unit_sigma_m"] > 0.0
    report = (tmp_path / "run" / "report.html").read_text()
    assert "winch_controller: interval winch/state" in report
    assert "winch_controller: timing work in a tick: Processor time too long" in report


@pytest.mark.slow
@pytest.mark.long
def test_a_radar_beside_the_vessel_tells_the_controller_what_is_to_come(tmp_path):
    options = ["--pacing", "realtime", "--duration", "30", "--no-report", "--replace", "wave_vessel=external"]
    options += ["--set", "winch_controller.mpc.preview_time=4", "--set", "all.transient=20.0"]
    with domain_id() as domain, running(["wave_vessel", "radar"], domain):
        run = give(domain, "run", "b2_calm_300", "--bag", str(tmp_path / "run"), *options)
    assert run.returncode in HAS_RUN, run.stderr
    bag = Bag(tmp_path / "run" / "bag")
    previews = [message for _, message in bag.decoded(["vessel/heave_preview"])]
    assert len(previews) >= 25
    said = [
        status.message
        for _, message in bag.decoded(["/diagnostics"])
        for status in message.status
        if status.name == "winch_controller: preview"
    ]
    assert said[-1] == "used", said


@pytest.mark.slow
@pytest.mark.long
def test_a_foreign_controller_takes_part_in_lockstep_and_equal_seeds_give_equal_bytes(tmp_path):
    bags = []
    for name in ("first", "second"):
        folder = tmp_path / name
        options = ["--replace", "winch_controller=lockstep", "--duration", "15", "--no-report"]
        options += ["--set", "wave_vessel.ramp=1.0"]
        foreign = str(EXAMPLES / "lockstep_controller.py")
        with domain_id() as domain, beside(domain, foreign, stderr=subprocess.PIPE) as program:
            run = give(domain, "run", "b2_calm_300", "--bag", str(folder), *options)
            _, error = program.communicate(timeout=30.0)
        assert run.returncode == 0, run.stderr
        assert (program.returncode, error) == (0, ""), "it ends with the run"
        bags.append(folder / "bag")
    commands = Bag(bags[0]).columns({"/winch/command": ["sequence", "brake"]})["/winch/command"]
    assert list(commands["sequence"]) == list(range(1, 301)), "one command for each tick of 0.05 s"
    assert not commands["brake"][-1]
    assert recorded_messages(bags[0]) == recorded_messages(bags[1])


@pytest.mark.parametrize(
    ("node", "words"), [("recorder", "must be one of cable_sim, wave_vessel"), ("winch", "no such node: winch")]
)
def test_a_node_that_cannot_be_foreign_is_refused(node, words):
    with domain_id() as domain:
        run = give(domain, "run", "b2_calm_300", "--replace", f"{node}=lockstep")
    assert run.returncode == 2
    assert words in run.stderr


@pytest.mark.slow
@pytest.mark.parametrize("node", PROGRAM)
def test_each_example_is_as_the_contract_says(node):
    with domain_id() as domain, running([node], domain):
        check = give(domain, "check", "--replace", f"{node}=external", "--seconds", "3")
    assert check.returncode == 0, check.stdout + check.stderr


ON_ITS_OWN_TIMER = """
import math, time
import rclpy
from heave_msgs.msg import MruSample, PointMotion
rclpy.init()
node = rclpy.create_node("own_timer")
mru, tip = node.create_publisher(MruSample, "mru", 10), None
if WITH_TIP:
    tip = node.create_publisher(PointMotion, "boom_tip", 10)
count = 0
def sample():
    global count
    count += 1
    now = node.get_clock().now()
    heave, rate = 0.3 * math.sin(now.nanoseconds * 1e-9), 0.3 * math.cos(now.nanoseconds * 1e-9)
    reading = MruSample(sequence=count, heave=heave, heave_rate=rate, heave_acceleration=-heave)
    point = PointMotion()
    point.position.z, point.velocity.z, point.acceleration.z = 5.0 + heave, rate, -heave
    point.header.frame_id = "world"
    for publisher, message in ((mru, reading), (tip, point)):
        message.header.stamp = now.to_msg()
        if publisher is not None:
            publisher.publish(message)
node.create_timer(0.05, sample)
rclpy.spin(node)
"""


ALONE = "WITH_TIP = False\n" + ON_ITS_OWN_TIMER
BY_EVENTS = ALONE.replace(
    "rclpy.spin(node)",
    "from rclpy.experimental.events_executor import EventsExecutor\n"
    "executor = EventsExecutor()\nexecutor.add_node(node)\nwhile True:\n    executor.spin_once(timeout_sec=1.0)",
)


def test_a_correct_sensor_that_publishes_by_its_own_timer_passes_also_what_it_sent_before_the_clock_began():
    with domain_id() as domain, beside(domain, "-c", "WITH_TIP = True\n" + ON_ITS_OWN_TIMER):
        check = give(domain, "check", "--replace", "wave_vessel=external", "--seconds", "3")
    assert check.returncode == 0, check.stdout + check.stderr


@pytest.mark.parametrize(
    ("program", "replaces", "wrong"),
    [
        (ALONE, "mru=external:own", ""),
        (BY_EVENTS, "mru=external", ""),
        (ALONE.replace("0.3 *", "300.0 *"), "mru=external", "mru: numbers"),
        (ALONE.replace("create_timer(0.05", "create_timer(0.5"), "mru=external", "mru: rate"),
        (ALONE, "wave_vessel=external", "boom_tip: publisher"),
        (ALONE, "winch/load_cell=external", "winch/load_cell: all: publisher"),
    ],
)
def test_a_sensor_alone_is_checked_by_its_topic_and_needs_no_boom_tip(program, replaces, wrong):
    with domain_id() as domain, beside(domain, "-c", program):
        check = give(domain, "check", "--replace", replaces, "--seconds", "2")
    assert check.returncode == (ExitStatus.VERDICT_FAILED if wrong else 0), check.stdout + check.stderr
    assert wrong in check.stderr
    assert ("mru=external" in check.stdout) == (wrong == "boom_tip: publisher")


@pytest.mark.parametrize("node", ["wave_vessel", "cable_sim"])
def test_a_node_that_is_not_there_is_named(node):
    """Of the plant no topic is required: each sensor may be left off, but not all."""
    with domain_id() as domain:
        check = give(domain, "check", "--replace", f"{node}=external", "--seconds", "2")
    assert check.returncode == ExitStatus.VERDICT_FAILED
    assert f"{node}: all: publisher" in check.stderr
    assert "nobody publishes any of these topics: is the node running" in " ".join(check.stdout.split())


def test_a_node_in_a_namespace_is_checked_there_and_hinted_at_elsewhere():
    in_namespace = ("--ros-args", "-r", "__ns:=/alpha")
    with domain_id() as domain, running(["wave_vessel"], domain, *in_namespace):
        elsewhere = give(domain, "check", "--replace", "wave_vessel=external", "--seconds", "2")
        there = give(domain, "check", "--replace", "wave_vessel=external", "--seconds", "3", "--namespace", "alpha")
    assert "/alpha/mru" in elsewhere.stderr
    assert there.returncode == 0, there.stdout + there.stderr


@pytest.mark.parametrize("program", PROGRAM.values())
def test_an_example_is_a_page_of_rclpy_and_nothing_of_the_suite_but_its_messages(program):
    text = (EXAMPLES / program).read_text()
    assert len(text.splitlines()) <= 75
    assert "heave_node" not in text
    assert "heave_bringup" not in text
