"""The account of what a pass over a file lost adds up to what is known to be missing, whatever the evidence."""

from __future__ import annotations

from pathlib import Path

import pytest
from heave_bags.errors import BagError, StorageError, one_line
from heave_bags.mcap.loss import MISSING, Loss, LossAccount, remarks


@pytest.mark.parametrize("noted", [0, 3])
@pytest.mark.parametrize(("total", "in_gaps"), [(10, 0), (None, 10)], ids=["count of the file", "numbers"])
def test_messages_that_are_missing_beyond_what_was_noted_are_named_though_no_place_is_known(noted, total, in_gaps):
    account = LossAccount(Path("own.mcap"))
    if noted:
        account.add(100, "a damaged chunk", noted, start=5)
        account.end_at(9)
    account.in_gaps = in_gaps
    losses = account.settle(total, is_cut=False)
    assert sum(loss.messages for loss in losses) == 10
    assert losses[-1].reason == MISSING
    assert losses[-1].messages == 10 - noted


def test_gaps_tell_how_many_a_place_of_unknown_number_has_cost_and_what_follows_stays_unknown():
    account = LossAccount(Path("own.mcap"))
    account.add(100, "a damaged chunk", None, start=5)
    account.end_at(9)
    account.add(200, "the file is cut off", None, start=12)
    account.in_gaps = 8
    before, behind = account.settle(None, is_cut=True)
    assert (before.messages, before.end) == (8, 9)
    assert (behind.messages, behind.end) == (None, None)


def account_of(*noted) -> LossAccount:
    """Return an account of losses at these positions [bytes], of so many messages, from these times on [ns]."""
    account = LossAccount(Path("own.mcap"))
    for position, messages, start in noted:
        account.add(position, f"damage {position}", messages, start)
    return account


def told(losses):
    return [(loss.position, loss.messages, loss.start, loss.end) for loss in losses]


@pytest.mark.parametrize(
    ("position", "messages", "start", "end", "words"),
    [
        (7, 3, None, None, "at byte 7: an unknown span of time with 3 messages lost"),
        (0, None, 2_000_000_000, None, "at byte 0: everything from 2.000 s on with an unknown number of messages lost"),
        (None, 0, 0, 1_500_000_000, ": 1.500 s (from 0.000 s to 1.500 s) with 0 messages lost"),
        (7, 1, 1_000_000_000, 1_500_000_000, "at byte 7: 0.500 s (from 1.000 s to 1.500 s) with 1 messages lost"),
    ],
)
def test_a_loss_is_told_by_place_time_and_number_as_far_as_they_are_known(position, messages, start, end, words):
    loss = Loss(Path("a folder/own.mcap"), position, "a damaged chunk", start, end, messages)
    assert str(loss) == f"own.mcap: a damaged chunk{' ' if position is not None else ''}{words}"
    assert remarks(["a\nnote"], [loss]) == ["a\\nnote", f"not all of the bag could be read: {loss}"]


def test_what_costs_a_message_leaves_a_place_open_until_messages_go_on():
    account = LossAccount(Path("own.mcap"))
    assert account.is_empty
    assert not account.is_open
    account.add(10, "a byte of the magic", 0)
    assert not account.is_empty
    assert not account.is_open, "nothing was lost with it"
    account.add(20, "a damaged chunk", 1)
    account.add(30, "a byte more", 0)
    assert account.is_open, "a harmless one behind it closes nothing"
    account.end_at(9)
    assert not account.is_open
    account.add(40, "a damaged chunk", None)
    assert account.is_open, "of an unknown number some may be missing"


def test_a_loss_ends_where_messages_go_on_unless_it_is_known_to_end_before_and_never_before_it_begins():
    account = account_of((10, 1, 5), (20, None, None), (30, 0, 6), (40, 1, 50))
    account.add(50, "a chunk with an index", 2, start=3, end=8)
    account.add(60, "a chunk with an index", 2, start=3, end=80)
    account.end_at(20)
    account.add(70, "later", 1, start=25)
    account.end_at(30)
    assert [end for *_, end in told(account.settle(None, is_cut=False))] == [20, 20, None, 50, 8, 20, 30]


def test_the_count_that_is_known_later_is_that_of_the_last_loss():
    account = account_of((10, None, 1), (20, None, 2), (30, None, 3))
    account.set_count(4)
    found = account.settle(None, is_cut=False)
    assert [(position, messages) for position, messages, *_ in told(found)] == [(10, None), (20, None), (30, 4)]


def test_of_what_is_cut_off_nobody_knows_the_end_but_of_what_lies_before_and_of_what_costs_nothing():
    account = account_of((10, 1, 1))
    account.end_at(5)
    account.add(20, "a byte", 0, start=6, end=7)
    account.add(30, "a chunk with an index", 1, start=6, end=8)
    assert told(account.settle(None, is_cut=False)) == [(10, 1, 1, 5), (20, 0, 6, 7), (30, 1, 6, 8)]
    assert told(account.settle(None, is_cut=True)) == [(10, 1, 1, 5), (20, 0, 6, 7), (30, 1, 6, None)]


def test_a_cut_behind_messages_that_went_on_takes_no_end_away():
    account = account_of((20, 0, 6))
    account.add(30, "a byte", 0, start=6, end=8)
    assert told(account.settle(None, is_cut=True)) == [(20, 0, 6, None), (30, 0, 6, 8)]


def test_numbers_that_add_up_stay():
    noted = (10, 2, 1), (20, 0, 2), (30, 5, 3)
    assert told(account_of(*noted).settle(7, is_cut=False)) == [(*one, None) for one in noted]
    assert told(account_of((10, 2, 1), (20, None, 2)).settle(2, is_cut=False)) == [(10, 2, 1, None), (20, 0, 2, None)]


def test_the_one_place_of_an_unknown_number_has_cost_the_rest():
    found = account_of((10, 2, 1), (20, None, 2), (30, 0, 3)).settle(9, is_cut=False)
    assert told(found) == [(10, 2, 1, None), (20, 7, 2, None), (30, 0, 3, None)]


def test_several_places_of_unknown_number_share_the_rest_and_the_others_keep_theirs():
    account = account_of((10, None, 4), (20, 2, 5), (30, None, 3))
    account.end_at(6)
    account.add(40, "damage 40", None, start=7)
    account.end_at(8)
    account.add(50, "the last", 1, start=9)
    account.end_at(11)
    joined, known, last = account.settle(12, is_cut=False)
    assert told([joined, known, last]) == [(10, 9, 3, 8), (20, 2, 5, 6), (50, 1, 9, 11)]
    assert joined.reason == "damage 10, and 2 more places up to byte 40; the first"
    assert joined.file == Path("own.mcap")


def test_the_place_of_a_joined_loss_stays_in_the_order_of_the_file():
    found = account_of((5, 2, 1), (10, None, 4), (20, 2, 5), (30, None, 3)).settle(12, is_cut=False)
    assert [loss.position for loss in found] == [5, 10, 20]


@pytest.mark.parametrize(("total", "stated"), [(3, 3), (0, 0)])
def test_where_fewer_are_missing_than_was_noted_all_places_that_cost_some_share_the_true_number(total, stated):
    account = account_of((10, 4, 1), (20, 0, 2), (30, 1, 3))
    joined, harmless = account.settle(total, is_cut=False)
    assert told([joined, harmless]) == [(10, stated, None, None), (20, 0, 2, None)]
    assert joined.reason == "damage 10, and 1 more places up to byte 30; the first"


def test_a_single_place_that_was_noted_with_too_many_is_not_said_to_be_several():
    (loss,) = account_of((10, 4, 1)).settle(3, is_cut=False)
    assert (loss.reason, loss.messages) == ("damage 10", 3)


def test_the_time_of_a_joined_loss_is_known_only_where_that_of_each_part_is():
    for unknown in (0, 1):
        account = LossAccount(Path("own.mcap"))
        for place in range(2):
            account.add(10 + place, "damage", None, start=None if place == unknown else 3)
        account.end_at(9)
        (loss,) = account.settle(5, is_cut=False)
        assert (loss.start, loss.end, loss.messages) == (None, None, 5)
    account = account_of((10, None, 3), (20, None, 4))  # messages never went on: no end is known
    (loss,) = account.settle(5, is_cut=False)
    assert (loss.start, loss.end) == (None, None)


@pytest.mark.parametrize("in_gaps", [0, 3])
def test_gaps_that_show_no_more_than_was_noted_change_nothing(in_gaps):
    account = account_of((10, 1, 1), (20, 2, 3))
    account.end_at(9)
    account.add(30, "a damaged chunk", None, start=10)
    account.in_gaps = in_gaps
    assert told(account.settle(None, is_cut=False)) == [(10, 1, 1, 9), (20, 2, 3, 9), (30, None, 10, None)]


@pytest.mark.parametrize(("in_gaps", "unknown"), [(3, None), (4, 1)])
def test_gaps_tell_of_a_place_of_unknown_number_what_the_noted_ones_do_not_explain(in_gaps, unknown):
    account = account_of((10, None, 1), (20, 3, 3))
    account.end_at(9)
    account.in_gaps = in_gaps
    assert [messages for _, messages, *_ in told(account.settle(None, is_cut=False))] == [unknown, 3]


def test_an_error_stays_on_its_line_and_sends_nothing_to_the_terminal():
    assert str(BagError("/a\nb: \x1b[2Jgone")) == "/a\\nb: \\x1b[2Jgone"
    assert str(StorageError("plain")) == "plain"
    assert one_line("Wasserlinie ü, 波") == "Wasserlinie ü, 波"
