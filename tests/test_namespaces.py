"""Two systems side by side in one ROS domain: each with its own scenario, bag and clock; neither hears the other."""

import subprocess

import pytest
from domain_coordinator import domain_id
from heave_bags.mcap.reader import Bag

from tests.loop_runs import command, environment, recorded_messages, run_scenario

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
