"""The receiving half of the tick protocol, without ROS."""

import random

from heave_node.tick.gate import Inbox, TickGate
from heave_node.tick.roster import NOT_WAITED_FOR, Participant, Roster
from hypothesis import given
from hypothesis import strategies as st


def message(number: int) -> bytes:
    """Return bytes like those of a message with a header: encapsulation, stamp, the rest."""
    return b"\x00\x01\x00\x00" + number.to_bytes(8, "little") + b"data"


def make_gate(**options) -> TickGate:
    gate = TickGate(["/mru", "/load"], ["sea"], **options)
    gate.set_roster(["sea", "sea", "plant"], ["/other", "/mru", "/load"])
    return gate


def test_a_repeated_message_is_taken_once():
    inbox = Inbox("/mru")
    assert inbox.put(message(1))
    assert not inbox.put(message(1))
    assert inbox.put(message(2))
    assert (inbox.received, inbox.duplicates) == (2, 1)
    assert inbox.take(2) == [message(1), message(2)]


def test_a_message_from_before_the_run_does_not_count():
    inbox = Inbox("/mru")
    assert not inbox.put(message(0))
    assert inbox.received == 0


def test_the_gate_tells_for_how_many_ticks_a_peer_was_silent():
    gate = make_gate(lockstep=False)
    gate.begin(1, 3, [0, 0, 1])
    assert gate.ticks_behind("sea") == 2, "of this tick nobody need have an answer yet"
    gate.peer_done("sea", 1, 2, [0, 0])
    assert gate.ticks_behind("sea") == 0
    gate.begin(1, 9, [0, 0, 1])
    assert (gate.ticks_behind("sea"), gate.ticks_behind("a node outside")) == (6, 0)


def test_the_gate_waits_for_the_peer_and_for_every_counted_message():
    gate = make_gate()
    gate.begin(1, 1, [0, 0, 1])
    assert not gate.is_complete()
    gate.inboxes["/load"].put(message(1))
    assert not gate.is_complete()
    gate.peer_done("sea", 1, 1, [5, 1])
    assert gate.missing() == "/mru from sea (0 of 1 messages)"
    gate.inboxes["/mru"].put(message(1))
    assert gate.is_complete()
    assert gate.missing() == ""


def test_in_lockstep_a_message_of_the_next_tick_stays():
    gate = make_gate()
    gate.begin(1, 1, [0, 0, 0])
    gate.peer_done("sea", 1, 1, [0, 1])
    gate.inboxes["/mru"].put(message(1))
    gate.inboxes["/mru"].put(message(2))
    assert gate.take("/mru") == [message(1)]
    gate.begin(1, 2, [0, 1, 0])
    gate.peer_done("sea", 1, 2, [0, 2])
    assert gate.take("/mru") == [message(2)]


def test_in_real_time_whatever_has_come_is_taken():
    gate = make_gate(lockstep=False)
    gate.begin(1, 1, [0, 0, 0])
    gate.inboxes["/mru"].put(message(1))
    gate.inboxes["/mru"].put(message(2))
    assert gate.take("/mru") == [message(1), message(2)]


def test_a_new_run_outranks_the_ticks_of_the_old_one():
    gate = make_gate()
    gate.peer_done("sea", 1, 500, [0, 500])
    gate.begin(2, 1, [0, 500, 0])
    assert "sea to end tick 1" in gate.missing()


@given(st.integers(0, 10_000), st.lists(st.integers(0, 3), min_size=1, max_size=20))
def test_any_order_of_arrival_gives_each_tick_its_own_messages(seed, per_tick):
    """Shuffled across topics, in order within a topic: the promise of DDS."""
    gate = make_gate()
    order = random.Random(seed)
    sent_mru = 0
    for tick, count in enumerate(per_tick, start=1):
        mru = [message(1000 * tick + i) for i in range(count)]
        load = [message(1000 * tick + 500)]
        sent_mru += count
        events = ["mru"] * count + ["load", "start", "done"]
        order.shuffle(events)
        waiting = {"mru": iter(mru), "load": iter(load)}
        for event in events:
            if event == "start":
                gate.begin(1, tick, [0, sent_mru - count, tick])
            elif event == "done":
                gate.peer_done("sea", 1, tick, [0, sent_mru])
            else:
                gate.inboxes[f"/{event}"].put(next(waiting[event]))
        assert gate.is_complete()
        assert gate.take("/mru") == mru
        assert gate.take("/load") == load


def joined(name: str, outputs=(), inputs=(), *, ready: bool = True, matched: int = 1, lag: int = 0) -> Participant:
    return Participant(name, ready, lag, dict.fromkeys(outputs, matched), dict.fromkeys(inputs, 1))


def test_the_barrier_names_whoever_is_not_there():
    roster = Roster(["plant", "sea"])
    roster.join(joined("plant", inputs=["/tip"]))
    assert "sea (not seen)" in roster.missing({})
    roster.join(joined("sea", outputs=["/tip"], ready=False))
    assert roster.missing({}) == ["sea (not ready)"]
    roster.join(joined("sea", outputs=["/tip"], matched=0))
    assert roster.missing({}) == ["sea sees 0 of 1 subscribers of /tip"]
    roster.join(joined("sea", outputs=["/tip"]))
    assert roster.missing({}) == []
    assert roster.missing({"/winch": 0}, ["/winch"]) == ["a publisher of /winch (external)"]
    assert roster.missing({"/winch": 0}) == [], "the loop closes without it"


def test_what_a_node_waited_for_in_a_tick_that_it_has_done_is_forgotten():
    """A run named 'tick 10' as what a node waited for at tick 2038."""
    roster = Roster(["winch"])
    roster.join(Participant("winch", ready=True, outputs={"/state": 0}))
    roster.freeze()
    roster.participants["winch"].waiting_for = "winch_controller to end tick 10"
    roster.answer("winch", 10, [10])
    (behind,) = roster.unanswered(11)
    assert behind.waiting_for == ""


def test_the_barrier_waits_until_every_reader_sees_the_external_publisher():
    """The graph shows a publisher before its readers are known or matched: quality of service may yet keep it out."""
    roster = Roster(["winch", "recorder"])
    for name, seen in (("winch", 0), ("recorder", 1)):
        roster.join(Participant(name, ready=True, inputs={"/command": seen}))
    assert roster.missing({"/command": 1}, ["/command"]) == ["winch sees no publisher of /command (external)"]
    roster.join(Participant("winch", ready=True, inputs={"/command": 1}))
    assert roster.missing({"/command": 1}, ["/command"]) == []


def test_answers_are_idempotent_and_a_laggard_may_lag():
    roster = Roster(["sea", "recorder"])
    roster.join(joined("sea", outputs=["/a", "/b"]))
    roster.join(joined("recorder", lag=3))
    roster.freeze()
    roster.answer("sea", 4, [7, 8])
    roster.answer("sea", 3, [1, 1])
    assert roster.counters == [7, 8]
    assert [p.name for p in roster.unanswered(4)] == ["recorder"]
    roster.answer("recorder", 1, [])
    assert roster.unanswered(4) == []
    assert [p.name for p in roster.unanswered(4, flush=True)] == ["recorder"]
    assert roster.published_by_topic() == {"/a": 7, "/b": 8}


def test_nobody_waits_for_a_node_beside_the_ticks_not_even_at_the_end():
    roster = Roster(["sea", "adviser"])
    roster.join(joined("sea", outputs=["/a"]))
    roster.join(joined("adviser", lag=NOT_WAITED_FOR, outputs=["/b"]))
    roster.freeze()
    roster.answer("sea", 10_000, [3])
    assert roster.unanswered(10_000) == []
    assert roster.unanswered(10_000, flush=True) == []
    assert roster.answered_by_all() == 10_000
    assert roster.published_by_topic() == {"/a": 3, "/b": 0}
