"""A sample of the campaigns that `make validate` runs: damaged and hostile bags, and killed recorders."""

import pytest

from tests.campaigns import damaged_bags, killed_processes


@pytest.mark.slow
def test_no_damaged_and_no_hostile_bag_gets_a_command_into_trouble_and_stated_losses_are_true(tmp_path):
    results = damaged_bags.campaign(8, 2, lambda _: None)
    assert len(results) > 8 + 40
    assert {result.bag: result.wrong for result in results if result.wrong} == {}
    assert max(result.memory for result in results) < damaged_bags.MEMORY
    assert sum(result.lost for result in results) > 0


@pytest.mark.slow
@pytest.mark.parametrize("number", [0, pytest.param(5, marks=pytest.mark.long)], ids=["lockstep", "realtime"])
def test_a_killed_recorder_leaves_a_bag_that_all_readers_open_with_all_it_answered_for(tmp_path, number):
    kill = killed_processes.kill_one(number, tmp_path / "run")
    assert (kill.node, kill.wrong) == ("recorder", "")
    assert kill.answered > 0
