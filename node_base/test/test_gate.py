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
    assert inbox.received == 2
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
    assert [participant.entry for participant in roster.participants.values()] == [0, 2]


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


# bytes that arrive

SOMEBODY, STRANGER = "aa", "bb"


def test_what_is_said_before_the_roster_is_known_is_judged_by_it_then():
    strange = []
    inbox = Inbox("/mru", on_stranger=lambda *who: strange.append(who))
    assert not inbox.put(message(1), SOMEBODY)
    assert not inbox.put(message(2), STRANGER)
    assert inbox.received == 0
    inbox.appoint([SOMEBODY])
    assert (inbox.received, inbox.take(1)) == (1, [message(1)])
    assert strange == [(STRANGER, message(2))]
    inbox.appoint([SOMEBODY])
    assert inbox.received == 1, "it is judged once"


def test_a_stranger_is_neither_counted_nor_taken_though_nobody_wants_to_know_of_him():
    inbox = Inbox("/mru")
    inbox.appoint([SOMEBODY])
    assert inbox.put(message(1), STRANGER) is False
    assert inbox.put(message(2), SOMEBODY) is True
    assert inbox.take(1) == [message(2)]


def test_hardware_may_send_without_a_stamp_and_the_same_twice():
    inbox = Inbox("/load", is_external=True)
    inbox.appoint([SOMEBODY])
    for _ in range(2):
        assert inbox.put(message(0), SOMEBODY) is True
    assert inbox.received == 2


def test_what_is_taken_is_decoded_and_what_came_twice_is_not_counted():
    inbox = Inbox("/mru", lambda data: data[4])
    assert inbox.put(message(1)) is True
    for _ in range(3):
        assert inbox.put(message(1)) is False
    assert inbox.received == 1
    assert inbox.take(1) == [1]
    assert inbox.take(1) == []


def test_a_stamp_that_is_zero_but_for_its_last_byte_is_one():
    """Nanoseconds of the 32 bits at bytes 8 to 11 of a message, after 4 of encapsulation and 4 of seconds."""
    for byte, is_stamped in ((3, False), (4, True), (11, True), (12, False)):
        data = bytearray(16)
        data[byte] = 1
        assert Inbox("/mru").put(bytes(data)) is is_stamped


def test_the_next_run_may_begin_with_the_bytes_of_this_one():
    gate = make_gate()
    assert gate.inboxes["/mru"].put(message(1))
    gate.end_run()
    assert gate.inboxes["/mru"].put(message(1))


@given(st.integers(0, 6), st.integers(0, 8))
def test_messages_up_to_a_number_are_taken_and_later_ones_stay(come, expected):
    inbox = Inbox("/mru")
    for number in range(1, come + 1):
        inbox.put(message(number))
    every = [message(number) for number in range(1, come + 1)]
    assert inbox.take(expected) == every[:expected]
    assert inbox.take(come) == every[expected:]


# who owes what


def test_the_messages_of_several_outputs_of_a_node_are_counted_each_by_its_own_counter():
    """The sea's second output is /mru: its place among the counters of the sea is 1, among those of all 2."""
    gate = TickGate(["/mru", "/tip"], ["sea"])
    gate.set_roster(["plant", "sea", "sea"], ["/tip", "/tip", "/mru"])
    assert gate.expected("/mru") == 0
    assert gate.expected("/unknown") == 0
    gate.begin(1, 1, [1, 2, 3])
    assert (gate.expected("/tip"), gate.expected("/mru")) == (3, 3), "plant and sea add up"
    gate.peer_done("sea", 1, 1, [4, 7])
    assert (gate.expected("/tip"), gate.expected("/mru")) == (5, 7)
    gate.begin(1, 2, [1, 9, 9])
    assert (gate.expected("/tip"), gate.expected("/mru")) == (10, 9), "the newest count is the largest"


def test_each_output_of_a_node_has_its_place_among_its_counters_and_another_roster_counts_at_once():
    gate = TickGate(["/a", "/b", "/c"], ["sea"])
    gate.set_roster(["sea"] * 3, ["/a", "/b", "/c"])
    gate.begin(1, 1, [0, 0, 0])
    gate.peer_done("sea", 1, 1, [1, 2, 3])
    assert [gate.expected(topic) for topic in gate.inboxes] == [1, 2, 3]
    gate.set_roster(["sea"] * 3, ["/c", "/b", "/a"])
    assert [gate.expected(topic) for topic in gate.inboxes] == [3, 2, 1]


def test_only_nodes_that_are_waited_for_add_to_the_counts():
    gate = make_gate()
    gate.begin(1, 1, [0, 0, 0])
    gate.peer_done("plant", 1, 1, [5])
    assert gate.expected("/load") == 0


def test_what_is_missing_names_the_tick_the_topics_and_all_their_publishers():
    gate = TickGate(["/mru", "/tip"], ["sea", "plant"])
    gate.set_roster(["plant", "sea", "sea"], ["/tip", "/tip", "/mru"])
    gate.begin(3, 7, [2, 0, 1])
    gate.inboxes["/mru"].put(message(1))
    assert gate.missing() == ("sea to end tick 7, plant to end tick 7, /tip from plant and sea (0 of 2 messages)")
    gate.peer_done("sea", 3, 7, [0, 1])
    gate.peer_done("plant", 2, 7, [2])
    assert gate.missing() == "plant to end tick 7, /tip from plant and sea (0 of 2 messages)", "that was of run 2"


def test_a_node_steps_once_each_of_its_inputs_is_whole_in_whatever_order_they_become_so():
    topics = ["/a", "/b", "/c"]
    for order in (topics, topics[::-1]):
        gate = TickGate(topics, [])
        gate.set_roster(["plant"] * 3, topics)
        gate.begin(1, 1, [1, 2, 1])
        assert not gate.is_complete()
        for topic in order:
            for number in range(2 if topic == "/b" else 1):
                assert gate.is_complete() is False
                gate.inboxes[topic].put(message(number + 1))
        assert gate.is_complete() is True
        gate.begin(1, 2, [1, 2, 2])
        assert gate.is_complete() is False, "of the next tick one more is due"


def test_what_has_not_come_is_lost_but_not_what_came_before_this_node_took_part():
    gate = TickGate(["/mru", "/load"], [])
    gate.set_roster(["sea", "plant"], ["/mru", "/load"])
    gate.begin(1, 1, [2, 3])
    gate.inboxes["/load"].put(message(1))
    assert gate.lost() == 4
    late = TickGate(["/mru", "/load"], [])
    late.set_roster(["sea", "plant"], ["/mru", "/load"])
    for number in range(1, 4):
        late.inboxes["/load"].put(message(number))
    late.begin(1, 2, [4, 2])
    assert late.lost() == 0
    assert gate.lost() == 4
    late.begin(1, 3, [5, 6])
    assert late.lost() == 1 + 3, "one of /mru after those that it never saw, three of /load"


def test_a_node_that_was_there_from_the_first_tick_of_a_later_run_has_lost_what_it_lacks():
    gate = make_gate()
    gate.begin(2, 1, [0, 1, 0])
    assert gate.lost() == 1
    gate.begin(2, 2, [0, 2, 0])
    assert gate.lost() == 2


def test_ticks_of_another_run_are_no_answer():
    gate = make_gate()
    gate.begin(2, 5, [0, 0, 0])
    gate.peer_done("sea", 1, 4, [0, 0])
    assert gate.ticks_behind("sea") == 4
    gate.peer_done("sea", 2, 5, [0, 0])
    assert gate.ticks_behind("sea") == 0, "it is ahead by one"


def test_before_the_first_tick_everything_is_there():
    """Tick 0 of run 0 is before the first; a node that has never answered is behind even that."""
    gate = TickGate(["/mru"], [])
    gate.set_roster(["sea"], ["/mru"])
    assert gate.is_complete() is True
    assert make_gate().is_complete() is False


def test_messages_of_a_run_that_was_reset_are_dropped_and_those_of_the_next_stay():
    gate = make_gate()
    gate.begin(1, 1, [0, 1, 0])
    for number in (1, 2):
        gate.inboxes["/mru"].put(message(number))
    gate.end_run()
    gate.begin(2, 1, [0, 2, 0])
    assert gate.take("/mru") == [message(2)]


def test_what_a_peer_has_sent_in_the_next_run_already_stays_when_the_last_one_is_dropped():
    """It begins the next run before this node does, and its first message and its answer may both be here by then."""
    gate = make_gate()
    gate.begin(1, 2, [0, 1, 0])
    gate.inboxes["/mru"].put(message(1))
    for number in (2, 3):
        gate.inboxes["/mru"].put(message(number))
    gate.inboxes["/load"].put(message(1))
    gate.peer_done("sea", 2, 1, [0, 2])
    gate.end_run()
    gate.begin(2, 1, [0, 1, 1])
    assert gate.is_complete()
    assert gate.take("/mru") == [message(2)]
    assert gate.take("/load") == [message(1)], "of the clock master, which counts it in the start of the tick"


def test_a_topic_that_nobody_counts_gives_what_has_come_in_lockstep_too():
    gate = TickGate(["/joystick"], [])
    gate.set_roster([], [])
    gate.begin(1, 1, [])
    gate.inboxes["/joystick"].put(message(1))
    assert gate.take("/joystick") == [message(1)]


def test_an_inbox_is_added_once_and_whoever_asks_again_gets_the_same():
    gate = make_gate()
    first = gate.add_inbox(Inbox("/joystick"))
    assert gate.add_inbox(Inbox("/joystick")) is first
    assert gate.inboxes["/joystick"] is first


def test_who_may_publish_comes_with_the_roster():
    """A run's own topic takes its roster's process alone; one of hardware anybody until the roster names one."""
    gate = TickGate(["/mru"], [])
    external = gate.add_inbox(Inbox("/load", is_external=True))
    gate.set_roster(["sea", "plant"], ["/mru", "/other"], [SOMEBODY, STRANGER])
    assert gate.inboxes["/mru"].put(message(1), SOMEBODY)
    assert not gate.inboxes["/mru"].put(message(2), STRANGER)
    assert external.put(message(3), "cc")
    gate.set_roster(["sea", "plant"], ["/mru", "/load"], [SOMEBODY, STRANGER])
    assert not external.put(message(4), "cc")
    assert external.put(message(4), STRANGER)
    gate.set_roster(["sea", "plant"], ["/mru", "/load"])
    assert gate.inboxes["/mru"].put(message(5), "cc"), "no identities: anybody"


def parts_gate() -> TickGate:
    gate = TickGate(["/mru"], ["sea"])
    gate.set_roster(["sea", "sea"], ["/_tick/part/sea", "/mru"], ["a", "a"])
    return gate


def test_a_part_brings_its_messages_once_and_copies_of_them_do_not_count():
    gate = parts_gate()
    gate.begin(1, 1, [0, 0])
    assert gate.take_part("sea", 1, [(1, message(1)), (0, b"not read here")])
    assert not gate.take_part("sea", 1, [(1, message(1))]), "it was sent again"
    assert not gate.inboxes["/mru"].put(message(1), "a")
    gate.peer_done("sea", 1, 1, [1, 1])
    assert gate.is_complete()
    assert gate.take("/mru") == [message(1)]


def test_messages_of_a_part_that_was_lost_are_counted_as_lost():
    gate = parts_gate()
    gate.begin(1, 1, [0, 0])
    gate.begin(1, 3, [2, 2])
    gate.take_part("sea", 2, [(1, message(2))])
    assert gate.lost() == 1


def test_parts_of_another_process_of_the_node_are_counted_anew():
    gate = parts_gate()
    assert gate.take_part("sea", 7, [(1, message(1))])
    gate.set_roster(["sea", "sea"], ["/_tick/part/sea", "/mru"], ["b", "b"])
    assert gate.take_part("sea", 1, [(1, message(2))])
