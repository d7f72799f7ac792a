"""Who may speak on a topic, without a ROS graph."""

import logging
from types import SimpleNamespace

from heave_node.ros.diagnostics import Level
from heave_node.ros.transport.strangers import Strangers
from heave_node.tick.gate import Inbox, TickGate
from heave_node.tick.speakers import ANYONE, Speakers, Standing
from hypothesis import given
from hypothesis import strategies as st


def message(number: int) -> bytes:
    """Return bytes like those of a message with a header: encapsulation, stamp, the rest."""
    return b"\x00\x01\x00\x00" + number.to_bytes(8, "little") + b"data"


def make_gate(strangers: list[str]) -> tuple[TickGate, Inbox]:
    gate = TickGate((), ["sea"])
    inbox = gate.add_inbox(Inbox("/mru", on_stranger=lambda identity, _: strangers.append(identity)))
    return gate, inbox


def test_the_first_process_heard_keeps_an_external_topic_until_it_has_left():
    speakers = Speakers(is_external=True)
    assert speakers.standing("winch") is Standing.LAWFUL
    assert speakers.standing("rogue") is Standing.STRANGER
    speakers.release()
    assert speakers.standing("new winch") is Standing.LAWFUL
    assert speakers.standing("winch") is Standing.STRANGER


def test_where_the_middleware_tells_no_identity_everybody_is_heard():
    speakers = Speakers()
    speakers.appoint(["sea"])
    assert speakers.standing(ANYONE) is Standing.LAWFUL
    speakers.appoint([ANYONE])
    assert speakers.standing("anybody") is Standing.LAWFUL


def test_a_topic_whose_node_takes_no_part_is_nobodys():
    speakers = Speakers()
    assert speakers.standing("anybody") is Standing.UNKNOWN
    speakers.appoint([])
    assert speakers.standing("anybody") is Standing.STRANGER


@given(st.lists(st.sampled_from(["sea", "rogue", "other"]), max_size=40), st.integers(0, 40))
def test_only_the_lawful_publisher_counts_whenever_the_roster_comes(senders, roster_after):
    strangers: list[str] = []
    gate, inbox = make_gate(strangers)
    lawful = []
    for number, sender in enumerate(senders, start=1):
        if number == roster_after + 1:
            gate.set_roster(["sea"], ["/mru"], ["sea"])
        inbox.put(message(number), sender)
        if sender == "sea":
            lawful.append(message(number))
    gate.set_roster(["sea"], ["/mru"], ["sea"])
    gate.begin(1, 1, [0])
    gate.peer_done("sea", 1, 1, [len(lawful)])
    assert gate.is_complete()
    assert gate.take("/mru") == lawful
    assert len(strangers) == len(senders) - len(lawful)


def test_a_topic_that_a_node_owns_is_never_released():
    speakers = Speakers()
    speakers.appoint(["own"])
    speakers.release()
    assert speakers.standing("own") is Standing.LAWFUL
    assert speakers.standing("other") is Standing.STRANGER


class Graph:
    """A node as far as its strangers look at it: who publishes, by the first bytes of its identity."""

    def __init__(self) -> None:
        self.present: list[bytes] = []

    def get_publishers_info_by_topic(self, _: str) -> list[SimpleNamespace]:
        return [SimpleNamespace(endpoint_gid=one * 16, node_name="drive", node_namespace="/") for one in self.present]

    def get_logger(self) -> logging.Logger:
        return logging.getLogger("strangers")


def test_a_process_that_takes_the_place_of_one_that_has_left_is_no_stranger_any_more():
    """A drive that was restarted stood in the diagnostics as unknown, to be stopped, until the end of the run."""
    graph, speakers = Graph(), Speakers(is_external=True)
    strangers = Strangers(graph, "")
    old, new = b"\x01", b"\x02"
    graph.present = [old, new]  # the graph has not seen yet that the first one has left
    assert speakers.standing((old * 12).hex()) is Standing.LAWFUL
    strangers.look({"/winch/state": speakers})
    assert [part.level for part in strangers.health()] == [Level.ERROR]
    graph.present = [new]
    strangers.refuse_speaker("/winch/state", (new * 12).hex(), speakers)
    assert strangers.has_news
    assert strangers.health() == []
    assert speakers.standing((new * 12).hex()) is Standing.LAWFUL
