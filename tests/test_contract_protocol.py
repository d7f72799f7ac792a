"""A node written from the contract alone takes part in each tick, whatever the suite's nodes send each other."""

from pathlib import Path

import pytest
from domain_coordinator import domain_id
from heave_bags.mcap.reader import Bag

from tests.loop_runs import HAS_RUN, beside, give, recorded_messages

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
