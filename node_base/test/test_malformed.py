"""Messages of the tick protocol whose parts do not fit together."""

import math

import pytest
from heave_msgs.msg import TickJoin, TickRoster, TickStatus
from heave_node.tick import malformed
from heave_node.tick.protocol import Part


@pytest.mark.parametrize(
    ("check", "message", "fault"),
    [
        (malformed.fault_in_join, TickJoin(), "it names no node"),
        (
            malformed.fault_in_join,
            TickJoin(node="sea", outputs=["/mru"]),
            "it has 1 outputs, 0 matched_subscriptions",
        ),
        (malformed.fault_in_join, TickJoin(node="sea", inputs=["/mru"]), "it has 1 inputs, 0 matched_publishers"),
        (malformed.fault_in_roster, TickRoster(tick_period=0.05), "its epoch is 0"),
        (malformed.fault_in_roster, TickRoster(epoch=1, tick_period=math.nan), "its tick_period is nan s"),
        (malformed.fault_in_roster, TickRoster(epoch=1, tick_period=math.inf), "its tick_period is inf s"),
        (malformed.fault_in_roster, TickRoster(epoch=1, tick_period=0.0), "its tick_period is 0.0 s"),
        (malformed.fault_in_roster, TickRoster(epoch=1, tick_period=-0.05), "its tick_period is -0.05 s"),
        (
            malformed.fault_in_roster,
            TickRoster(epoch=1, tick_period=0.05, nodes=["sea"], identities=["ab"]),
            "it has 1 nodes, 1 identities, 0 topics",
        ),
        (malformed.fault_in_status, TickStatus(state=9), "its state is 9"),
        (malformed.fault_in_status, TickStatus(topics=["/mru"]), "it has 1 topics, 0 published"),
    ],
)
def test_what_does_not_fit_together_is_said(check, message, fault):
    assert check(message) == fault


def test_counts_must_be_as_many_as_the_roster_has():
    lead = Part(epoch=1, tick=1, published=[1, 2], messages=[(0, b"x")])
    assert malformed.fault_in_lead(lead, 2, 1) == ""
    assert malformed.fault_in_lead(lead, 2, 0) == "it has a message of output 0 of 0"
    assert malformed.fault_in_lead(lead, 3, 1) == "it has 2 counts instead of 3"
    assert malformed.fault_in_lead(Part(epoch=1), 0, 1) == "its epoch is 1 and its tick 0; both count from 1"
    assert malformed.fault_in_part(Part(published=[1, 2, 3]), 2) == "it has 3 counts instead of 2"
    assert malformed.fault_in_part(Part(published=[1], messages=[(1, b"x")]), 1) == "it has a message of output 1 of 1"


def test_whole_messages_pass():
    assert malformed.fault_in_join(TickJoin(node="sea", outputs=["/mru"], matched_subscriptions=[1])) == ""
    roster = TickRoster(epoch=1, tick_period=0.05, nodes=["sea"], identities=["ab"], topics=["/mru"])
    assert malformed.fault_in_roster(roster) == ""
    assert malformed.fault_in_status(TickStatus()) == ""
    assert malformed.fault_in_status(TickStatus(state=TickStatus.FAILED)) == ""
