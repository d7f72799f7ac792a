"""The account of what a pass over a file lost adds up to what is known to be missing, whatever the evidence."""

from __future__ import annotations

from pathlib import Path

import pytest
from heave_bags.mcap.loss import MISSING, LossAccount


@pytest.mark.parametrize("noted", [0, 3])
def test_messages_that_the_count_of_the_file_misses_are_named_though_no_place_is_known(noted):
    account = LossAccount(Path("own.mcap"))
    if noted:
        account.add(100, "a damaged chunk", noted, start=5)
        account.end_at(9)
    losses = account.settle(10, is_cut=False)
    assert sum(loss.messages for loss in losses) == 10
    assert losses[-1].reason == MISSING
    assert losses[-1].messages == 10 - noted


@pytest.mark.parametrize("noted", [0, 3])
def test_gaps_in_the_numbering_beyond_what_was_noted_are_named(noted):
    account = LossAccount(Path("own.mcap"))
    if noted:
        account.add(100, "a damaged chunk", noted, start=5)
        account.end_at(9)
    account.in_gaps = 8
    losses = account.settle(None, is_cut=False)
    assert sum(loss.messages for loss in losses) == 8
    assert losses[-1].reason == MISSING


def test_gaps_tell_how_many_a_place_of_unknown_number_has_cost_and_what_follows_stays_unknown():
    account = LossAccount(Path("own.mcap"))
    account.add(100, "a damaged chunk", None, start=5)
    account.end_at(9)
    account.add(200, "the file is cut off", None, start=12)
    account.in_gaps = 8
    before, behind = account.settle(None, is_cut=True)
    assert (before.messages, before.end) == (8, 9)
    assert (behind.messages, behind.end) == (None, None)
