"""A sample of the campaigns that `make validate` runs: damaged and hostile bags, hostile files, killed recorders."""

import pytest

from tests.campaigns import damaged_bags, hostile_files, killed_processes


@pytest.mark.slow
def test_no_damaged_and_no_hostile_bag_gets_a_command_into_trouble_and_stated_losses_are_true():
    results = damaged_bags.campaign(8, 2, lambda _: None)
    assert len(results) > 8 + 40
    assert [line for result in results for line in result.problems] == []
    assert sum(result.lost for result in results) > 0


@pytest.mark.slow
def test_scenarios_tables_and_attachments_of_anybody_are_read_or_refused_in_one_line():
    """No traceback, bounded in memory and time, nothing written elsewhere."""
    results = hostile_files.campaign(6, lambda _: None, first=2001)
    assert [result.kind for result in results] == list(hostile_files.KINDS) * 2
    assert [line for result in results for line in result.problems] == []


@pytest.mark.slow
@pytest.mark.parametrize("number", [0, pytest.param(5, marks=pytest.mark.long)], ids=["lockstep", "realtime"])
def test_a_killed_recorder_leaves_a_bag_that_all_readers_open_with_all_it_answered_for(tmp_path, number):
    kill = killed_processes.kill_one(number, tmp_path / "run")
    assert (kill.node, kill.wrong) == ("recorder", "")
    assert kill.answered > 0
