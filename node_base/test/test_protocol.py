"""Parts of ticks as bytes: what the middleware makes of the same message, and what is none."""

import pytest
from heave_msgs.msg import TickDone, TickPart, TickStart
from heave_node.cdr.layout import LayoutError
from heave_node.tick.protocol import Part, Past
from heave_node.tick.tick import stamp_of
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message, serialize_message

COUNTS = st.integers(0, 2**32 - 1)
PARTS = st.builds(
    Part,
    tick=st.integers(0, 2**64 - 1),
    epoch=COUNTS,
    published=st.lists(COUNTS, max_size=20).map(tuple),
    messages=st.lists(st.tuples(COUNTS, st.binary(max_size=50)), max_size=20),
    lost=COUNTS,
    stamp=st.integers(0, 2**31 * 10**9 - 1),
    flush=st.booleans(),
)


@given(PARTS)
def test_a_part_is_the_message_that_the_middleware_makes(part):
    made = deserialize_message(part.to_bytes(), TickPart)
    assert made == TickPart(
        tick=part.tick,
        epoch=part.epoch,
        lost=part.lost,
        stamp=stamp_of(part.stamp),
        flush=part.flush,
        published=part.published,
        outputs=[output for output, _ in part.messages],
        sizes=[len(data) for _, data in part.messages],
        data=b"".join(data for _, data in part.messages),
    )
    assert Part.of(part.to_bytes()) == part
    assert Part.of(part.to_bytes() + bytes(3)) == part, "the middleware fills up to four bytes"


@given(PARTS)
def test_other_programs_are_told_by_messages_of_their_own(part):
    start, done = deserialize_message(part.to_start(), TickStart), deserialize_message(part.to_done(), TickDone)
    assert start == TickStart(
        epoch=part.epoch, tick=part.tick, stamp=stamp_of(part.stamp), flush=part.flush, published=part.published
    )
    assert done == TickDone(epoch=part.epoch, tick=part.tick, lost=part.lost, published=part.published)
    assert Part.of_done(serialize_message(done)) == Part(part.tick, part.epoch, list(part.published), (), part.lost)


@given(st.lists(st.tuples(st.integers(0, 3), PARTS), max_size=4))
def test_parts_that_are_passed_on_are_those_of_the_entries_that_a_node_hears(parts):
    past = Past(7, 2, parts)
    came = Past.of(past.to_bytes())
    assert (came.tick, came.epoch, came.to_bytes()) == (7, 2, past.to_bytes())
    heard = [(entry, part) for entry, part in parts if entry in (0, 2)]
    assert list(came.parts_of({0, 2})) == list(past.parts_of({0, 2})) == heard


def test_a_part_that_is_passed_on_and_is_none_is_refused_where_it_is_heard():
    part = Part(tick=7, epoch=2, published=(1, 5), messages=[(1, b"reading")])
    past = Past.of(Past(7, 2, [(1, b"nonsense"), (2, part)]).to_bytes())
    assert list(past.parts_of({2})) == [(2, part)]
    with pytest.raises(LayoutError):
        list(past.parts_of({1, 2}))


@given(PARTS, st.integers(0, 400), st.binary(min_size=1, max_size=4))
def test_what_was_cut_or_changed_is_a_part_or_refused(part, place, noise):
    data = part.to_bytes()
    for changed in (data[:place], data[:place] + noise + data[place + len(noise) :], noise):
        try:
            taken = Part.of(changed)
        except LayoutError:
            continue
        assert sum(len(message) for _, message in taken.messages) <= len(changed)


def test_a_part_whose_lengths_do_not_fit_is_refused():
    data = Part(published=(1,), messages=[(0, b"abc")]).to_bytes()
    with pytest.raises(LayoutError, match="its lengths do not fit"):
        Part.of(data + b"and more")
