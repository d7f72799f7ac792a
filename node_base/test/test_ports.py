"""Inputs of a node within ticks: which messages a tick gets."""

from types import SimpleNamespace

from heave_node.interface import topics
from heave_node.interface.sensors import WireReading
from heave_node.ros.ports import Input
from heave_node.tick.gate import Inbox, TickGate
from heave_node.tick.speakers import ANYONE
from heave_node.tick.tick import Tick

TICK = 50_000_000
NODE = SimpleNamespace(resolve_topic_name=lambda name: f"/{name}")


def make_input() -> tuple[Input, Inbox]:
    """Return an input that holds what is ahead, and the inbox that feeds it readings."""
    gate = TickGate((), (), lockstep=False)
    inbox = gate.add_inbox(
        Inbox("/winch/state", decode=lambda data: (int(data), WireReading(int(data), ())), is_external=True)
    )
    return Input(NODE, topics.WINCH_STATE, gate, check_stamps=False, holds_ahead=True), inbox


def measured_in(port: Input, tick: int) -> list[int]:
    """Return when the messages that a tick gets were measured [ms]."""
    return [reading.stamp // 1_000_000 for reading in port.take(Tick(tick, 1, TICK))]


def test_what_hardware_measures_within_a_tick_is_a_reading_of_the_next_one():
    port, inbox = make_input()
    for measured in (3 * TICK - 20_000_000, 3 * TICK, 3 * TICK + 15_000_000):
        inbox.put(b"%d" % measured)
    assert measured_in(port, 3) == [130, 150]
    assert port.latest.stamp == 3 * TICK
    inbox.put(b"%d" % (3 * TICK + 35_000_000))
    assert measured_in(port, 4) == [165, 185]


def test_a_node_that_is_behind_takes_in_each_tick_what_was_known_by_then():
    port, inbox = make_input()
    for number in range(1, 11):
        inbox.put(b"%d" % (number * TICK))
    assert [len(port.take(Tick(number, 1, TICK))) for number in range(1, 12)] == [1] * 10 + [0]


def test_what_settles_is_taken_in_the_tick_after_its_stamp_however_early_it_came_and_in_lockstep_too():
    """What is stamped with tick 5 is taken in tick 6, whether it came in tick 2, 5 or 6; in 8 if it came then."""
    taken = []
    for came in (2, 5, 6, 8):
        gate = TickGate((), (), lockstep=True)
        inbox = gate.add_inbox(Inbox("/winch/state", decode=lambda data: (int(data), WireReading(int(data), ()))))
        inbox.appoint([ANYONE])
        port = Input(NODE, topics.WINCH_STATE, gate, check_stamps=False, settles=True)
        for tick in range(1, 10):
            if tick == came:
                inbox.put(b"%d" % (5 * TICK))
            taken += [(came, tick) for _ in measured_in(port, tick)]
    assert taken == [(2, 6), (5, 6), (6, 6), (8, 8)]


def test_another_run_begins_without_what_was_held():
    port, inbox = make_input()
    inbox.put(b"%d" % (100 * TICK))
    assert port.take(Tick(1, 1, TICK)) == []
    port.reset()
    assert port.take(Tick(200, 2, TICK)) == []
