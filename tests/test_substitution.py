"""A bag in the place of a node: the recorded sea through the same scenario gives the same run, byte for byte."""

import sys
from pathlib import Path

import pytest
from heave_bags.errors import BagError
from heave_bags.mcap.reader import Bag
from heave_bags.play.tick_player import TickPlayer
from heave_bringup.cli import main

from tests.loop_runs import CALM_DURATION, recorded_messages, run_scenario

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
