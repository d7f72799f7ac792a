"""Programs that somebody else wrote take part in each tick, in lockstep: a plant, and a controller by the contract."""

import subprocess
from pathlib import Path

import numpy as np
import pytest
from domain_coordinator import domain_id
from heave_bags.mcap.reader import Bag

from tests.loop_runs import HAS_RUN, beside, give, recorded_messages

PLANT = Path(__file__).parents[1] / "examples" / "plant.py"


def run_with_plant(folder: Path, *options: str) -> tuple[subprocess.CompletedProcess[str], str]:
    """Run with the example as the plant; return how the run ended and what the plant said."""
    with domain_id() as domain, beside(domain, str(PLANT), stderr=subprocess.PIPE) as plant:
        arguments = ("--replace", "cable_sim=lockstep", "--bag", str(folder), "--no-report", *options)
        run = give(domain, "run", "b2_calm_300", *arguments)
        _, said = plant.communicate(timeout=30.0)
    return run, said


@pytest.mark.slow
def test_a_foreign_plant_takes_part_in_each_tick_and_the_ships_clock_leads(tmp_path):
    run, said = run_with_plant(tmp_path / "run", "--duration", "5")
    assert run.returncode in HAS_RUN, run.stderr + said
    assert said == "", "it ends with the run"
    bag = Bag(tmp_path / "run" / "bag")
    unit = bag.columns({"/unit/odometry": ["pose.pose.position.z"]})["/unit/odometry"]
    assert list(np.round(unit["time"] / 0.05)) == list(range(2, 102)), "one for the end of each of 100 ticks of 0.05 s"


@pytest.mark.slow
@pytest.mark.long
def test_the_load_of_a_foreign_plant_is_compensated(tmp_path):
    options = ("--duration", "120", "--set", "wave_vessel.ramp=5", "--set", "all.transient=60")
    run, said = run_with_plant(tmp_path / "run", *options)
    assert run.returncode in HAS_RUN, run.stderr + said
    topics = {"/unit/odometry": ["pose.pose.position.z"], "/boom_tip": ["position.z"]}
    columns = Bag(tmp_path / "run" / "bag").columns(topics)
    unit, tip = (columns[topic][fields[0]][columns[topic]["time"] > 60.0] for topic, fields in topics.items())
    assert np.std(unit) < 0.2 * np.std(tip), "a cable that does not stretch carries the boom tip's heave to the unit"


# a controller by the contract alone


PROGRAM = Path(__file__).with_name("protocol_controller.py")
SECONDS = 10


def run_beside_it(folder: Path, *options: str) -> Path:
    """Run with the controller in the place of the suite's, and return the bag."""
    with domain_id() as domain, beside(domain, str(PROGRAM)) as controller:
        run = give(
            domain,
            *("run", "b2_calm_300", "--bag", str(folder), "--duration", str(SECONDS), "--no-report"),
            *("--replace", "winch_controller=lockstep", "--replace", "winch_adviser=none", *options),
        )
        assert run.returncode in HAS_RUN, run.stderr
        assert controller.wait(20.0) == 0
    return folder / "bag"


@pytest.mark.slow
def test_a_program_by_the_contract_takes_part_in_each_tick_and_its_runs_are_the_same(tmp_path):
    bag, again = (run_beside_it(tmp_path / name) for name in ("run", "again"))
    counts = {name: topic.message_count for name, topic in Bag(bag).topics.items()}
    assert counts["/winch/command"] == counts["/winch/state"] == counts["/clock"] == 20 * SECONDS
    assert recorded_messages(bag) == recorded_messages(again)
