"""A bag in the place of a node: the recorded sea through the same scenario gives the same run, byte for byte."""

import subprocess
import sys
from pathlib import Path

import pytest
from domain_coordinator import domain_id
from heave_bags.errors import BagError
from heave_bags.mcap.reader import Bag
from heave_bags.play.tick_player import TickPlayer
from heave_bringup.cli import main
from visualization_msgs.msg import Marker

from tests.loop_runs import CALM_DURATION, command, environment, heave, recorded_messages, run_scenario

sys.path.insert(0, str(Path(__file__).parents[1] / "bags" / "test"))

from foreign_bags import by_host_clock, by_simulated_clock, write_foreign

TICK = 50_000_000
NODES = ("wave_vessel", "cable_sim", "virtual_winch", "winch_controller")


def in_ticks(bag: Path, node: str, topics: list[str]) -> list[tuple[int, str, bytes]]:
    """Return what a node published, with the tick, sorted within each."""
    player = TickPlayer(Bag(bag), node, TICK)
    ticks = range(1, round(CALM_DURATION * 1e9) // TICK + 1)
    return [(tick, *entry) for tick in ticks for entry in sorted(player.take(tick)) if entry[0] in topics]


@pytest.mark.parametrize("clock", [by_host_clock, by_simulated_clock])
@pytest.mark.parametrize("node", NODES)
def test_a_bag_of_another_recorder_tells_in_which_tick_each_message_was_published(calm_bag, tmp_path, clock, node):
    foreign = write_foreign(calm_bag, tmp_path / "foreign", clock)
    stamped = [name for name in TickPlayer(Bag(calm_bag), node, TICK).topics if name != "/markers"]
    own = in_ticks(calm_bag, node, stamped)
    assert len(own) > 200
    assert in_ticks(foreign, node, stamped) == own


def test_the_sea_from_another_recorder_by_the_host_s_clock_gives_the_same_run(calm_bag, tmp_path):
    foreign = write_foreign(calm_bag, tmp_path / "foreign", by_host_clock)
    again = run_scenario(
        tmp_path / "again", duration=CALM_DURATION, options=["--replace", f"wave_vessel=bag:{foreign}"]
    )
    assert recorded_messages(again) == recorded_messages(calm_bag)
    assert [Bag(bag).run["replaced"] for bag in (again, calm_bag)] == ["wave_vessel=bag", ""]


def test_the_sea_of_a_run_in_one_namespace_gives_the_same_run_in_another(calm_bag, tmp_path):
    foreign = write_foreign(calm_bag, tmp_path / "foreign", by_host_clock, namespace="/fleet/east")
    options = ["--namespace", "west", "--replace", f"wave_vessel=bag:{foreign}"]
    again = run_scenario(tmp_path / "again", duration=CALM_DURATION, options=options)
    assert recorded_messages(again) == [(f"/west{name}", *rest) for name, *rest in recorded_messages(calm_bag)]


def test_a_bag_of_several_runs_is_refused_as_a_substitute(calm_bag, tmp_path):
    half = round(CALM_DURATION * 0.5e9)

    def twice(message, _):
        return message.log_time + (0 if message.log_time > half else 2 * half)

    foreign = write_foreign(calm_bag, tmp_path / "foreign", twice)
    with pytest.raises(BagError, match="several runs"):
        TickPlayer(Bag(foreign), "wave_vessel", TICK)


def test_a_bag_that_ends_before_the_run_is_refused_before_anything_starts(calm_bag, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    longer = CALM_DURATION + 10.0
    command = ["run", "b2_calm_300", "--duration", f"{longer:g}", "--replace", f"wave_vessel=bag:{calm_bag}"]
    assert main(command) == 2
    assert f"it has {CALM_DURATION:g} s of wave_vessel, but the run lasts {longer:g} s" in capsys.readouterr().err
    assert not (tmp_path / "runs").exists()


@pytest.mark.long
def test_the_recorded_sea_through_the_same_scenario_gives_the_same_run(calm_bag, tmp_path):
    options = ["--replace", f"wave_vessel=bag:{calm_bag}"]
    again = run_scenario(tmp_path / "again", duration=CALM_DURATION, options=options)
    assert recorded_messages(again) == recorded_messages(calm_bag)


def test_the_recorded_sea_against_another_controller_is_the_same_sea_and_another_run(calm_bag, tmp_path):
    options = ["--replace", f"wave_vessel=bag:{calm_bag}", "--set", "winch_controller.law=off"]
    what_if = recorded_messages(run_scenario(tmp_path / "what_if", duration=CALM_DURATION, options=options))
    before = recorded_messages(calm_bag)
    for topic in ("/boom_tip", "/mru", "/unit_uncompensated"):
        assert [m for m in what_if if m[0] == topic] == [m for m in before if m[0] == topic]
    assert [m for m in what_if if m[0] == "/controller/state"] != [m for m in before if m[0] == "/controller/state"]


# two systems in one domain


DURATION = 20.0


@pytest.mark.slow
@pytest.mark.long
def test_two_systems_in_one_domain_run_as_each_does_alone(tmp_path):
    general = ["--duration", str(DURATION), "--no-report"]
    with domain_id() as domain:
        runs = {
            name: subprocess.Popen(
                command("run", "b2_calm_300", *general, "--bag", str(tmp_path / name), *options),
                env=environment(domain),
                stderr=subprocess.PIPE,
                text=True,
            )
            for name, options in (("east", ["--namespace", "east"]), ("west", ["--namespace", "west", "--seed", "2"]))
        }
        errors = {name: run.communicate(timeout=200.0)[1] for name, run in runs.items()}
    assert [run.returncode for run in runs.values()] == [0, 0], errors
    alone = recorded_messages(run_scenario(tmp_path / "alone", duration=DURATION))
    beside = recorded_messages(tmp_path / "east" / "bag")
    assert beside == [(f"/east{topic}", time, checksum) for topic, time, checksum in alone]
    assert Bag(tmp_path / "west" / "bag").run["seed"] == "2"
    assert all(topic.startswith("/west/") for topic in Bag(tmp_path / "west" / "bag").topics)


# sea and sensors of a bag


@pytest.mark.slow
def test_recorded_sea_and_sensors_lead_the_same_controller_to_the_same_run(calm_bag, tmp_path):
    replaced = ("wave_vessel", "cable_sim", "virtual_winch")
    options = [part for node in replaced for part in ("--replace", f"{node}=bag:{calm_bag}")]
    again = run_scenario(tmp_path / "again", duration=CALM_DURATION, options=options)
    assert Bag(again).run["replaced"].split() == [f"{node}=bag" for node in replaced]
    assert list(Bag(again).messages()) == list(Bag(calm_bag).messages())


def test_a_bag_that_is_too_short_is_refused_in_one_line(calm_bag, tmp_path):
    result = heave(
        *("run", "b2_calm_300", "--duration", "100", "--bag", str(tmp_path / "again"), "--no-report"),
        *("--replace", f"wave_vessel=bag:{calm_bag}"),
    )
    assert result.returncode != 0
    assert "the run lasts 100 s" in result.stderr.strip().splitlines()[-1]


def test_markers_show_the_cable_and_the_unit_where_they_are(calm_bag):
    bag = Bag(calm_bag)
    cables = {message.log_time: state for message, state in bag.decoded(["cable/state"])}
    units = {message.log_time: state for message, state in bag.decoded(["unit/odometry"])}
    seen = 0
    for message, array in bag.decoded(["markers"]):
        strips = [marker for marker in array.markers if marker.type == Marker.LINE_STRIP]
        nodes = [(node.x, node.y, node.z) for node in cables[message.log_time].nodes]
        assert any([(point.x, point.y, point.z) for point in strip.points] == nodes for strip in strips)
        unit = units[message.log_time].pose.pose.position
        bodies = [
            m.pose.position for m in array.markers if m.type in (Marker.CUBE, Marker.SPHERE, Marker.MESH_RESOURCE)
        ]
        assert any((body.x, body.y, body.z) == pytest.approx((unit.x, unit.y, unit.z), abs=1e-9) for body in bodies)
        assert {marker.header.frame_id for marker in array.markers} == {"world"}
        seen += 1
    assert seen >= CALM_DURATION
