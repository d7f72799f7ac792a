"""What an operator requests of a node is in its next diagnostics, with the time from which on it counts."""

from types import SimpleNamespace

import pytest

pytest.importorskip("rclpy")
pytest.importorskip("heave_msgs")

from heave_node.interface.codes import OPERATOR, timed_words
from heave_node.ros.diagnostics import Level
from heave_node.ros.node import HeaveNode
from heave_node.tick.tick import Tick


class Node(SimpleNamespace):
    """What `publish_diagnostics` needs of a node that has nothing else to report; it keeps what is published."""

    note_request = HeaveNode.note_request

    def __init__(self):
        self.published = []
        silent = dict.fromkeys(("diagnose", "diagnose_inputs", "diagnose_timing"), list)
        super().__init__(
            name="plant",
            run=SimpleNamespace(tick_period=0.05),
            strangers=SimpleNamespace(has_news=False, health=list),
            has_urgent_news=lambda: True,
            _asked={},
            _diagnostics=SimpleNamespace(publish=self.published.append),
            **silent,
        )

    def requests(self):
        HeaveNode.publish_diagnostics(self, Tick(30, 1, 50_000_000))
        return [one for one in self.published[-1].status if one.name == f"plant: {OPERATOR}"]


def test_requests_are_reported_once_at_their_own_times_and_are_no_warning():
    node = Node()
    assert node.requests() == []
    node.note_request(1.2, "factor 0.8")
    node.note_request(1.55, "speed +0.20 m/s")
    node.note_request(1.55, "fault of mru: gap")
    (part,) = node.requests()
    assert part.level == Level.OK.value
    assert timed_words(part.message) == [(1.2, "factor 0.8"), (1.55, "speed +0.20 m/s, fault of mru: gap")]
    assert node.requests() == []
