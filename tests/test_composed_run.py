"""`heave run --composed`: all nodes in one process give the bag that five give, and the record says so."""

import json

import yaml
from heave_bags.mcap.reader import Bag

from tests.loop_runs import CALM_DURATION, HAS_RUN, heave, recorded_messages


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
