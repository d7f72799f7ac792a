"""Bags whose files and messages come in any order: the same messages and the same figures, in bounded memory."""

import random
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from foreign_bags import copy_messages
from heave_bags.analyse import analysis
from heave_bags.mcap.read import order
from heave_bags.mcap.read.order import NOT_IN_ORDER, RESET, ClockWatch
from heave_bags.mcap.reader import Bag, RawMessage
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from made_up_run import MadeUpRun, write_run
from mcap.writer import CompressionType, Writer


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.lists(st.integers(1, 40), min_size=1, max_size=60),
    st.sampled_from([0, 1500, 10_000, 1 << 30]),
    st.sampled_from([30, 200, 10_000]),
)
def test_messages_are_read_in_a_stable_sort_by_log_time_however_little_may_be_held(
    tmp_path, monkeypatch, times, most_held, chunk_size
):
    monkeypatch.setattr(order, "MOST_HELD", most_held)
    with (tmp_path / "a.mcap").open("wb") as stream:
        writer = Writer(stream, chunk_size=chunk_size)
        writer.start(profile="ros2")
        channel = writer.register_channel("/a", "cdr", 0)
        for number, time in enumerate(times):
            writer.add_message(channel, time, bytes([number]), time)
        writer.finish()
    read = [(message.log_time, message.data[0]) for message in Bag(tmp_path / "a.mcap").messages()]
    assert read == sorted(((time, number) for number, time in enumerate(times)), key=lambda pair: pair[0])


def watch(*stretches: range, topics: int = 1) -> str:
    """Return what is noted of the order of messages each second, in these stretches."""
    clock = ClockWatch()
    for stretch in stretches:
        clock.observe([RawMessage(f"/{n}", t * 10**8, b"") for t in stretch for n in range(topics)])
    return clock.note


def test_a_reset_is_told_from_late_and_shuffled_messages():
    shuffled = list(range(1000))
    random.Random(1).shuffle(shuffled)
    assert watch(range(1000), range(800), topics=3) == RESET
    assert watch(range(1000), range(500), range(900)) == RESET
    assert watch(range(30, 1000), range(500)) == RESET, "a recorder that had joined late"
    assert watch(range(1000)) == ""
    assert watch(range(300), range(600, 900), range(300, 600)) == NOT_IN_ORDER
    assert watch(range(0, 1000, 2), range(1, 1000, 2)) == NOT_IN_ORDER, "two recorders"
    assert watch(shuffled) == NOT_IN_ORDER
    pieces = [range(start, start + 50) for start in range(0, 2000, 50)]
    random.Random(2).shuffle(pieces)
    assert watch(*pieces) == NOT_IN_ORDER


READ_SHUFFLED = """
import sys
sys.path.insert(0, {tests!r})
from heave_bags.mcap.reader import Bag
from memory import peak_memory
before = peak_memory()
last = count = 0
for message in Bag({path!r}).messages():
    assert message.log_time >= last
    last, count = message.log_time, count + 1
print(count, peak_memory() - before)
"""


def test_a_file_without_any_order_that_is_larger_than_what_may_be_held_is_read_in_bounded_memory(tmp_path):
    count, size = 5_000, 64_000
    times = list(range(1, count + 1))
    random.Random(3).shuffle(times)
    with (tmp_path / "large.mcap").open("wb") as stream:
        writer = Writer(stream, chunk_size=4 << 20, compression=CompressionType.NONE)
        writer.start()
        channel = writer.register_channel("/a", "cdr", 0)
        for time in times:
            writer.add_message(channel, time, bytes(size), time)
        writer.finish()
    assert (tmp_path / "large.mcap").stat().st_size > 310e6
    script = READ_SHUFFLED.format(tests=str(Path(__file__).parent), path=str(tmp_path / "large.mcap"))
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    read, memory = map(int, done.stdout.split())
    assert read == count
    assert memory < 220 << 20  # twice what a merge keeps (64 MiB), a chunk, and what the allocator leaves


@pytest.fixture(scope="module")
def run(tmp_path_factory) -> tuple[Bag, dict]:
    """Return a run as another recorder has written it in order, and its figures."""
    folder = tmp_path_factory.mktemp("run")
    write_run(folder / "own", MadeUpRun(duration=24.0))
    own = Bag(folder / "own")
    copy_messages(own, {folder / "ordered" / "ordered_0.mcap": list(enumerate_topics(own))})
    return own, figures(folder / "ordered")


def enumerate_topics(bag: Bag) -> Iterator[tuple[int, RawMessage]]:
    """Yield the messages of a bag, each with its number in its topic."""
    numbers: dict[str, int] = {}
    for message in bag.messages():
        numbers[message.topic] = numbers.get(message.topic, 0) + 1
        yield numbers[message.topic], message


def figures(folder: Path) -> dict:
    """Return what `heave kpi` gives of a bag, to every digit, without its name and what it notes of the order."""
    (record,) = analysis.analyse([folder])
    content = analysis.to_json(record)
    assert not content["losses"]
    assert all("not in the order" in note for note in content["notes"])
    return {key: repr(value) for key, value in content.items() if key not in ("bag", "notes")}


@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_the_order_of_messages_and_files_and_their_names_change_no_digit_of_a_figure(run, tmp_path, data):
    own, expected = run
    chance = data.draw(st.randoms(use_true_random=False))
    files = data.draw(st.integers(1, 4))
    shuffled = data.draw(st.sampled_from(["not", "neighbours", "blocks", "all"]))
    messages = list(enumerate_topics(own))
    if shuffled == "neighbours":
        messages = [messages[index ^ 1] for index in range(len(messages) & ~1)] + messages[len(messages) & ~1 :]
    elif shuffled == "blocks":
        length = data.draw(st.integers(50, 500))
        blocks = [messages[start : start + length] for start in range(0, len(messages), length)]
        chance.shuffle(blocks)
        messages = [message for block in blocks for message in block]
    elif shuffled == "all":
        chance.shuffle(messages)
    share = -(-len(messages) // files)
    parts = [messages[start : start + share] for start in range(0, len(messages), share)]
    if data.draw(st.booleans()):  # each message into any file
        parts = [[] for _ in parts]
        for message in messages:
            chance.choice(parts).append(message)
    names = data.draw(st.permutations([f"{name}.mcap" for name in ("run_0", "run_1", "z_2026-10", "10")]))
    folder = tmp_path / "bag"
    shutil.rmtree(folder, ignore_errors=True)
    chunk_size = data.draw(st.sampled_from([2_000, 100_000, 10_000_000]))
    copy_messages(own, {folder / name: part for name, part in zip(names, parts, strict=False)}, chunk_size=chunk_size)
    assert figures(folder) == expected
