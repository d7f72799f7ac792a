"""`heave run --composed`: all nodes in one process give the bag that five give, and the record says so."""

import json
import subprocess
import sys

import yaml
from domain_coordinator import domain_id
from heave_bags.mcap.reader import Bag

from tests.loop_runs import CALM_DURATION, HAS_RUN, environment, heave, recorded_messages


def topics_of(bag):
    metadata = yaml.safe_load((bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    return [entry["topic_metadata"] for entry in metadata["topics_with_message_count"]]


def test_a_composed_run_gives_the_same_bag_and_says_that_it_was_one(tmp_path, calm_bag):
    folder = tmp_path / "run"
    result = heave(
        *("run", "b2_calm_300", "--duration", str(CALM_DURATION), "--bag", str(folder), "--no-report"),
        *("--composed", "--json", str(tmp_path / "result.json")),
    )
    assert result.returncode == 0, result.stderr
    assert "all in one process" in result.stdout
    assert recorded_messages(folder / "bag") == recorded_messages(calm_bag)
    assert topics_of(folder / "bag") == topics_of(calm_bag)
    assert json.loads((tmp_path / "result.json").read_text())["composed"] is True
    assert (Bag(folder / "bag").run["composed"], Bag(calm_bag).run["composed"]) == ("true", "false")


COUNT = """
import sys
from collections import Counter
from heave_bringup.nodes import PROCESS_BY_NAME
from heave_bringup.run.run import RunFolder, nodes_to_start, store_scenario
from heave_bringup.scenarios import load_scenario
from heave_node.ros.process import run_composed
from heave_node.ros.transport.exchange import Exchange
from pathlib import Path
scenario = load_scenario("b2_calm_300", settings=("all.duration=20.0", "all.transient=0.0"))
folder = RunFolder(Path(sys.argv[1]))
store_scenario(scenario, folder)
found, enqueue = Counter(), Exchange._enqueue
def count(exchange, readers, data):
    found.update(messages=1, deliveries=len(readers))
    enqueue(exchange, readers, data)
Exchange._enqueue = count
nodes = [PROCESS_BY_NAME[name].node_type() for name in nodes_to_start(scenario.run)]
status = run_composed(nodes, ["run", "--ros-args", "--params-file", str(folder.scenario)], is_public=False)
print(status, scenario.run.tick_count, found["messages"], found["deliveries"])
"""


def test_a_tick_has_at_most_six_messages_and_twelve_deliveries_with_the_start_of_the_run_among_them(tmp_path):
    with domain_id() as domain:
        program = [sys.executable, "-c", COUNT, str(tmp_path / "run")]
        result = subprocess.run(program, env=environment(domain), capture_output=True, text=True, check=False)
    status, ticks, messages, deliveries = map(int, result.stdout.split()[-4:])
    assert (status, ticks) == (0, 400), result.stderr
    assert 4.0 < messages / ticks <= 6.0
    assert 9.0 < deliveries / ticks <= 12.0


def test_what_is_learnt_is_told_on_the_terminal_and_in_the_report(tmp_path):
    """Noise of five times: found in the first second, and named with its factor."""
    folder = tmp_path / "run"
    noise = [f"wave_vessel.mru.{name}=0.05" for name in ("noise", "rate_noise")]
    result = heave(
        *("run", "b3_deep_900", "--duration", "12", "--bag", str(folder), "--composed", "--set", "all.transient=2"),
        *(word for setting in noise for word in ("--set", setting)),
    )
    told = [line for line in (result.stdout + result.stderr).splitlines() if "SENSOR_DOUBTFUL, MRU (low)" in line]
    assert told, result.stderr
    assert told[0].startswith("t = 0.")
    assert "noise of MRU heave is 0.05 m, 5.0 times the stated value" in (folder / "report.html").read_text()


def test_a_tension_above_the_alarm_of_a_shipped_scenario_is_told_with_the_summary(tmp_path):
    result = heave(
        *("run", "b5_storm", "--duration", "14", "--bag", str(tmp_path / "run"), "--composed", "--no-report"),
        *("--set", "all.transient=2", "--set", "wave_vessel.ramp=5"),
    )
    assert result.returncode in HAS_RUN, result.stderr
    assert "TENSION_HIGH (high): tension " in result.stdout + result.stderr
    assert "times static, limit 1.5" in result.stdout + result.stderr
