"""Which event restarts which memory: the table is what is done."""

from types import SimpleNamespace

import pytest
from winch_controller_node.core.component import WinchController
from winch_controller_node.core.restarts import MEMORIES, RESTARTS, Event, restart
from winch_controller_node.node_parameters import WinchControllerParameters


@pytest.mark.parametrize("event", Event)
def test_an_event_restarts_the_memories_of_its_row_in_their_order_and_no_other(event, monkeypatch):
    noted = []
    for memory in MEMORIES:
        monkeypatch.setitem(MEMORIES, memory, lambda core, memory=memory: noted.append((core, memory)))
    core = SimpleNamespace()
    restart(core, event)
    assert noted == [(core, memory) for memory in RESTARTS[event]]


def test_every_memory_has_its_event_and_every_event_its_row():
    assert set(RESTARTS) == set(Event)
    assert {memory for row in RESTARTS.values() for memory in row} == set(MEMORIES)


def test_every_memory_is_one_of_a_controller():
    controller = WinchController(WinchControllerParameters(), tick_period=0.05)
    for event in Event:
        restart(controller, event)
