"""Bags of killed recorders and damaged files: what can be read is read, and the loss is named."""

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from heave_bags.mcap.bag_writer import BagPolicy
from heave_bags.mcap.reader import Bag
from heave_bags.mcap.writer import ChunkPolicy
from made_up_run import MadeUpRun, write_run

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


def test_the_share_that_survives_a_cut_is_the_share_that_was_left(sound, tmp_path):
    data, messages = sound
    end_of_data = data.rindex(b"\x0f\x04\x00\x00\x00\x00\x00\x00\x00")  # the DataEnd record
    _, got = read(data[: end_of_data // 2], tmp_path)
    assert len(got) > 0.45 * len(messages)


@pytest.mark.parametrize("seed", range(15))
def test_a_damaged_chunk_costs_that_chunk_and_its_loss_is_counted(sound, tmp_path, seed):
    data, messages = sound
    broken = bytearray(data)
    chunk = random.Random(seed).choice(chunk_positions(data)[1:])
    for offset in range(60, 100):  # inside the compressed records
        broken[chunk + offset] ^= 0x5A
    bag, got = read(bytes(broken), tmp_path)
    (loss,) = bag.losses
    assert loss.messages == len(messages) - len(got) > 0
    missing = [m for m in messages if m not in set(got)]
    assert (loss.start, loss.end) == (missing[0].log_time, missing[-1].log_time)
    assert f"{loss.messages} messages lost" in str(loss)


def chunk_positions(data: bytes) -> list[int]:
    found, position = [], data.find(b"\x04\x00\x00\x00zstd")
    while position >= 0:
        if data[position - 37] == 6:
            found.append(position - 37)
        position = data.find(b"\x04\x00\x00\x00zstd", position + 1)
    return found


def test_reading_goes_on_behind_overwritten_bytes(sound, tmp_path):
    data, messages = sound
    chunks = chunk_positions(data)
    broken = bytearray(data)
    broken[chunks[3] : chunks[3] + 200] = bytes(200)
    bag, got = read(bytes(broken), tmp_path)
    assert len(got) > 0.8 * len(messages)
    assert set(got) < set(messages)
    assert "make no sense" in str(bag.losses[0])


def test_noise_never_raises_anything_but_a_bag_error(sound, tmp_path):
    data, messages = sound
    for seed in range(40):
        chance = random.Random(seed)
        broken = bytearray(data)
        for _ in range(20):
            broken[chance.randrange(8, len(broken))] = chance.randrange(256)
        _, got = read(bytes(broken), tmp_path)
        assert len(got) <= len(messages)


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
    assert "its writer was stopped" in str(bag.losses[0])
