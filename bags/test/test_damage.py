"""Bags of killed recorders and damaged files: what can be read is read, and the loss is named."""

import os
import random
import shutil
import signal
import subprocess
import sys
import time
import zlib
from io import BytesIO
from pathlib import Path

import pytest
from damages import KINDS, chunk_positions, damage_one_file, read_all, stated_loss, true_loss
from heave_bags.mcap.bag_writer import BagPolicy
from heave_bags.mcap.reader import Bag
from heave_bags.mcap.storage import journal_path
from heave_bags.mcap.summary import interim_ending
from heave_bags.mcap.writer import ChunkPolicy
from hostile_bags import HEAD, HEADER, chunk, mcap, message, topic
from made_up_run import MadeUpRun, write_run
from mcap.reader import make_reader
from mcap.records import Chunk
from mcap.stream_reader import StreamReader

SMALL_CHUNKS = BagPolicy(ChunkPolicy(size=8_000))


@pytest.fixture(scope="module")
def sound(tmp_path_factory):
    """Return a sound file of many chunks and its messages."""
    folder = tmp_path_factory.mktemp("sound") / "bag"
    write_run(folder, MadeUpRun(duration=20.0), SMALL_CHUNKS)
    path = folder / "bag_0.mcap"
    return path.read_bytes(), list(Bag(path).messages())


def read(data: bytes, folder: Path) -> tuple[Bag, list]:
    path = folder / "damaged.mcap"
    path.write_bytes(data)
    bag = Bag(path)
    return bag, list(bag.messages())


@pytest.mark.parametrize("seed", range(25))
def test_a_file_cut_anywhere_gives_the_messages_before_the_cut(sound, tmp_path, seed):
    data, messages = sound
    cut = random.Random(seed).randrange(2_000, len(data) - 1)
    bag, got = read(data[:cut], tmp_path)
    assert got == messages[: len(got)]
    assert bag.losses, "a cut file must say so"
    assert bag.losses[-1].end is None or bag.losses[-1].messages == 0, "nobody knows up to when"


def test_the_share_that_survives_a_cut_is_the_share_that_was_left(sound, tmp_path):
    data, messages = sound
    end_of_data = data.rindex(b"\x0f\x04\x00\x00\x00\x00\x00\x00\x00")  # the DataEnd record
    _, got = read(data[: end_of_data // 2], tmp_path)
    assert len(got) > 0.45 * len(messages)


@pytest.mark.parametrize("position", range(8))
def test_a_damaged_byte_of_the_magic_costs_nothing_and_is_told(sound, tmp_path, position):
    data, messages = sound
    broken = bytearray(data)
    broken[position] ^= 0x10
    bag, got = read(bytes(broken), tmp_path)
    assert got == messages
    assert "every MCAP file begins with are damaged" in str(bag.losses[0])


def test_damage_to_the_chunk_of_the_definitions_costs_no_message(sound, tmp_path):
    data, messages = sound
    broken = bytearray(data)
    for offset in range(60, 100):
        broken[chunk_positions(data)[0] + offset] ^= 0x5A
    _, got = read(bytes(broken), tmp_path)
    assert got == messages


@pytest.mark.parametrize("seed", range(1, 15))
def test_a_damaged_chunk_costs_that_chunk_and_its_loss_is_counted(sound, tmp_path, seed):
    data, messages = sound
    broken = bytearray(data)
    position = chunk_positions(data)[seed]  # the first with messages among them
    for offset in range(60, 100):  # inside the compressed records
        broken[position + offset] ^= 0x5A
    bag, got = read(bytes(broken), tmp_path)
    (loss,) = bag.losses
    assert loss.messages == len(messages) - len(got) > 0
    missing = [m for m in messages if m not in set(got)]
    assert (loss.start, loss.end) == (missing[0].log_time, missing[-1].log_time)
    assert f"{loss.messages} messages lost" in str(loss)


def test_reading_goes_on_behind_overwritten_bytes(sound, tmp_path):
    data, messages = sound
    chunks = chunk_positions(data)
    broken = bytearray(data)
    broken[chunks[3] : chunks[3] + 200] = bytes(200)
    bag, got = read(bytes(broken), tmp_path)
    assert len(got) > 0.8 * len(messages)
    assert set(got) < set(messages)
    assert "corrupt records" in str(bag.losses[0])


@pytest.fixture(scope="module")
def sound_bags(tmp_path_factory):
    """Return the folders of sound bags of several makes, with their messages."""
    folder = tmp_path_factory.mktemp("makes")
    policies = {
        "zstd": SMALL_CHUNKS,
        "none": BagPolicy(ChunkPolicy(size=8_000, compression="")),
        "split": BagPolicy(ChunkPolicy(size=20_000, compression="lz4"), max_file_bytes=40_000),
    }
    for name, policy in policies.items():
        write_run(folder / name, MadeUpRun(duration=10.0), policy)
    return {path: read_all(path)[0] for path in sorted(folder.iterdir())}


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("kind", KINDS)
def test_the_stated_loss_is_the_true_loss(sound_bags, tmp_path, kind, seed):
    for bag, before in sound_bags.items():
        broken = tmp_path / bag.name
        shutil.copytree(bag, broken)
        path = damage_one_file(broken, kind, random.Random(f"{kind} {seed}"))
        after, losses = read_all(broken)
        assert stated_loss(losses) == true_loss(before, after)
        assert losses or path.read_bytes() == (bag / path.name).read_bytes(), "no damage goes unsaid"


def test_without_a_second_count_an_end_that_is_gone_is_said_to_be_unknown(sound, tmp_path):
    data, _ = sound
    bag, messages = read(data[: chunk_positions(data)[5] + 200], tmp_path)
    assert bag.losses[-1].messages is None
    words = str(bag.losses[-1])
    assert f"everything from {messages[-1].log_time * 1e-9:.3f} s on with an unknown number of messages lost" in words


@pytest.mark.parametrize(("damaged", "costs"), [(0, False), (1, True)], ids=["definitions", "first messages"])
def test_a_killed_file_of_which_one_of_the_first_chunks_is_damaged_keeps_all_others(sound, tmp_path, damaged, costs):
    data, messages = sound
    chunks = chunk_positions(data)
    end_of_data = data.rindex(b"\x0f\x04\x00\x00\x00\x00\x00\x00\x00")
    killed = bytearray(data[:end_of_data] + interim_ending())
    for offset in range(60, 100):
        killed[chunks[damaged] + offset] ^= 0x5A
    path = tmp_path / "killed_0.mcap"
    path.write_bytes(killed)
    got, losses = read_all(path)
    assert got == messages[-len(got) :]
    assert stated_loss(losses) == len(messages) - len(got)
    assert (len(got) < len(messages)) == costs


def test_a_piece_that_is_gone_from_a_killed_file_is_told_by_the_numbers_of_its_messages(sound, tmp_path):
    data, messages = sound
    _, _, third, fourth, *_ = chunk_positions(data)
    end_of_data = data.rindex(b"\x0f\x04\x00\x00\x00\x00\x00\x00\x00")
    closing_record = data.rindex(b"\x07\x00\x00\x00rosbag2", 0, end_of_data) - 9  # a killed writer has not come so far
    path = tmp_path / "killed_0.mcap"
    path.write_bytes(data[:third] + data[fourth:closing_record] + interim_ending())
    got, losses = read_all(path)
    assert stated_loss(losses) == len(messages) - len(got) > 0
    assert "messages are missing" in str(losses[0])


def test_no_single_byte_takes_the_definitions(sound, tmp_path):
    data, messages = sound
    first, second, third, *_ = chunk_positions(data)
    parts = {
        "first": range(first, second, 997),
        "second": range(second, third, 997),
        "end": range(len(data) - 60, len(data), 7),
    }
    for positions in parts.values():
        for position in positions:
            broken = bytearray(data)
            broken[position] ^= 0x10
            _, got = read(bytes(broken), tmp_path)
            assert len(got) > 0.8 * len(messages)


def test_one_flipped_byte_in_a_chunk_that_is_not_packed_is_told_by_its_checksum(tmp_path):
    write_run(tmp_path / "bag", MadeUpRun(duration=5.0), BagPolicy(ChunkPolicy(size=8_000, compression="")))
    path = tmp_path / "bag" / "bag_0.mcap"
    data = bytearray(path.read_bytes())
    before, _ = read_all(tmp_path / "bag")
    victim = before[200].data
    data[data.index(victim) + len(victim) // 2] ^= 1  # a value: the message would be decoded, and be wrong
    path.write_bytes(data)
    after, losses = read_all(tmp_path / "bag")
    assert set(after) < set(before)
    assert "its checksum does not match" in str(losses[0])


def test_every_checksum_is_written_and_right(sound):
    data, _ = sound
    reader = StreamReader(BytesIO(data), validate_crcs=True, emit_chunks=True)
    chunks = [record for record in reader.records if isinstance(record, Chunk)]
    assert all(record.uncompressed_crc for record in chunks)
    assert sum(1 for _ in make_reader(BytesIO(data), validate_crcs=True).iter_messages()) > 0
    at = data.rindex(b"\x0f\x04\x00\x00\x00\x00\x00\x00\x00")
    assert int.from_bytes(data[at + 9 : at + 13], "little") == zlib.crc32(data[:at])
    assert int.from_bytes(data[-12:-8], "little"), "the checksum of the summary"


def test_a_change_that_hits_no_message_is_told_all_the_same(sound, tmp_path):
    data, messages = sound
    bag, got = read(
        data.replace(b"\x04\x00\x00\x00seed\x01\x00\x00\x007", b"\x04\x00\x00\x00seed\x01\x00\x00\x008"), tmp_path
    )
    assert got == messages
    assert "data other than messages has changed" in str(bag.losses[0])
    assert bag.losses[0].messages == 0


def test_messages_of_a_channel_that_nobody_defined_are_counted_as_lost(tmp_path):
    path = tmp_path / "strangers.mcap"
    path.write_bytes(mcap(chunk(topic() + message(HEAD + HEADER) + message(b"?", number=9) * 5)))
    got, losses = read_all(path)
    assert len(got) == 1
    assert [loss.messages for loss in losses] == [5]


def test_a_journal_that_belongs_to_another_state_of_the_file_is_not_read(tmp_path):
    write_run(tmp_path / "bag", MadeUpRun(duration=5.0), SMALL_CHUNKS, close=False).acknowledge()
    path = tmp_path / "bag" / "bag_0.mcap"
    journal = journal_path(path).read_bytes()
    with_journal, _ = read_all(path)
    chunks = chunk_positions(path.read_bytes())
    path.write_bytes(path.read_bytes()[: chunks[-1]] + interim_ending())  # as it was before its last chunk
    assert journal_path(path).read_bytes() == journal
    got, losses = read_all(path)
    assert len(got) < len(with_journal) - 20, "the journal's records do not follow here"
    assert got == with_journal[: len(got)]
    assert "the file ends before its journal begins" in str(losses[0])
    assert losses[0].messages is None


def test_a_time_window_is_right_where_the_head_of_a_chunk_lies_about_its_times(sound, tmp_path):
    data, messages = sound
    position = chunk_positions(data)[4]
    broken = bytearray(data)
    broken[position + 9 + 6] ^= 0x40  # the first time becomes one of the year 3000
    path = tmp_path / "lie.mcap"
    path.write_bytes(broken)
    start, end = messages[0].log_time, messages[-1].log_time
    assert list(Bag(path).messages(start=start, end=end)) == messages


RECORD = """
import sys, time
sys.path.insert(0, {tests!r})
from pathlib import Path
import made_up_run as made_up
from heave_bags.mcap.bag_writer import BagPolicy
from heave_bags.mcap.writer import ChunkPolicy
from rclpy.serialization import serialize_message

writer = made_up.write_run(Path({folder!r}), made_up.MadeUpRun(duration=0.05),
BagPolicy(ChunkPolicy(size=30_000)), close=False)
run = made_up.MadeUpRun()
acknowledged = open({acknowledged!r}, "w", buffering=1)
number = 1
while True:
    number += 1
    for topic, message in made_up.tick_messages(run, number * 50_000_000).items():
        writer.write(topic, number * 50_000_000, bytes(serialize_message(message)))
    writer.acknowledge()
    acknowledged.write(f"{{number}}\\n")
"""


@pytest.mark.parametrize("seed", range(4))
def test_a_recorder_killed_at_any_time_has_lost_nothing_it_acknowledged(tmp_path, seed):
    acknowledged = tmp_path / "acknowledged"
    script = RECORD.format(
        tests=str(Path(__file__).parent), folder=str(tmp_path / "bag"), acknowledged=str(acknowledged)
    )
    process = subprocess.Popen([sys.executable, "-c", script], env=dict(os.environ))
    try:
        while not acknowledged.exists() or not acknowledged.read_text():
            assert process.poll() is None
            time.sleep(0.02)
        time.sleep(random.Random(seed).uniform(0.01, 0.4))
    finally:
        process.send_signal(signal.SIGKILL)
        process.wait()
    last = int(acknowledged.read_text().split()[-1])
    bag = Bag(tmp_path / "bag")
    ticks = [m.log_time // 50_000_000 for m in bag.messages(["boom_tip"])]
    assert ticks == list(range(1, len(ticks) + 1))
    assert len(ticks) >= last
    assert "its writer did not finish" in str(bag.losses[0])
