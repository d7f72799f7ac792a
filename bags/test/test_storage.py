"""Full and slow disks: the run's bag stays readable, and what is lost is said."""

import errno
import os
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from heave_bags.errors import StorageError
from heave_bags.mcap.bag_writer import BagPolicy, BagWriter
from heave_bags.mcap.reader import Bag
from heave_bags.mcap.storage import BackgroundStorage, DirectStorage, journal_path
from heave_bags.mcap.summary import interim_ending
from heave_bags.mcap.writer import ChunkPolicy
from heave_bags.record.session import RecordingSession, SnapshotRing
from made_up_run import MadeUpRun, tick_messages
from rclpy.serialization import serialize_message
from rosbags.highlevel import AnyReader

POLICY = BagPolicy(ChunkPolicy(size=8_000, compression=""))
DATA = bytes(serialize_message(tick_messages(MadeUpRun(), 50_000_000)["/boom_tip"]))


class FullDisk(DirectStorage):
    """A disk that takes 50,000 bytes."""

    left = 50_000

    def write(self, data: bytes, /) -> None:
        if len(data) > self.left:
            raise StorageError(f"{self.path}: the disk is full")
        self.left -= len(data)
        super().write(data)


def record(writer: BagWriter | RecordingSession, count: int) -> None:
    writer.add_topic("/boom_tip", "heave_msgs/msg/PointMotion", ())
    for number in range(1, count + 1):
        writer.write("/boom_tip", number * 1_000_000, DATA)


def test_a_full_disk_leaves_a_readable_bag_and_says_what_it_lacks(tmp_path):
    writer = BagWriter(tmp_path / "bag", policy=POLICY, opener=FullDisk)
    with pytest.raises(StorageError, match="the disk is full"):
        record(writer, 5000)
    with pytest.raises(StorageError, match=r"\d+ messages from 0\.\d+ s to 0\.\d+ s were lost"):
        writer.close()
    bag = Bag(tmp_path / "bag")
    times = [m.log_time for m in bag.messages()]
    assert times == [number * 1_000_000 for number in range(1, len(times) + 1)]
    assert 25_000 < len(times) * len(DATA) < 50_000  # the rest is heads and indexes of messages
    assert not journal_path(tmp_path / "bag" / "bag_0.mcap").exists()


def test_a_session_in_real_time_survives_a_full_disk_and_counts_what_it_cannot_write(tmp_path):
    session = RecordingSession(
        lambda folder: BagWriter(folder, policy=POLICY, opener=FullDisk), SnapshotRing(0, 0), survive=True
    )
    session.start(tmp_path / "bag")
    record(session, 1000)
    assert not session.is_recording
    assert session.state.unwritten > 300
    assert "were lost" in session.state.problems[0]


def test_a_session_in_lockstep_ends_on_a_full_disk(tmp_path):
    session = RecordingSession(
        lambda folder: BagWriter(folder, policy=POLICY, opener=FullDisk), SnapshotRing(0, 0), survive=False
    )
    session.start(tmp_path / "bag")
    with pytest.raises(StorageError, match=r"the disk is full.* were lost"):
        record(session, 5000)


LIMITED = """
import resource
import sys
sys.path.insert(0, {tests!r})
resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, resource.RLIM_INFINITY))
import test_storage
from pathlib import Path
from heave_bags.mcap.bag_writer import BagWriter
writer = BagWriter(Path({folder!r}), policy=test_storage.POLICY)
try:
    test_storage.record(writer, 100_000)
except Exception as error:
    print(error)
try:
    writer.close()
except Exception as error:
    print(error)
"""


def test_a_file_that_the_system_lets_grow_no_more_is_cut_to_its_last_whole_chunk(tmp_path):
    script = LIMITED.format(tests=str(Path(__file__).parent), folder=str(tmp_path / "bag"))
    said = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout
    assert said.count("the disk is full") == 2
    bag = Bag(tmp_path / "bag")
    assert len(list(bag.messages())) * len(DATA) > 30_000
    assert "chunk" not in " ".join(map(str, bag.losses))


class SlowDisk(DirectStorage):
    """A disk that takes a tenth of a second for each piece."""

    def write(self, data: bytes, /) -> None:
        time.sleep(0.1)
        super().write(data)


def test_a_slow_disk_holds_nobody_up_in_real_time_and_loses_nothing(tmp_path):
    writer = BagWriter(tmp_path / "bag", policy=POLICY, opener=lambda path: BackgroundStorage(SlowDisk(path)))
    began = time.monotonic()
    record(writer, 1000)
    handed_over = time.monotonic() - began
    writer.close()
    assert time.monotonic() - began > 5 * handed_over  # what takes long happened behind the caller's back
    with AnyReader([tmp_path / "bag"]) as reader:
        assert reader.message_count == 1000


def test_a_backlog_that_grows_too_large_is_refused_not_swallowed(tmp_path):
    writer = BagWriter(
        tmp_path / "bag", policy=POLICY, opener=lambda path: BackgroundStorage(SlowDisk(path), limit=40_000)
    )
    with pytest.raises(StorageError, match="too slow"):
        record(writer, 100_000)
    with pytest.raises(StorageError, match=r"messages from .* were lost"):
        writer.close()
    assert Bag(tmp_path / "bag").message_count > 0


def test_what_fails_in_the_background_is_raised_in_front(tmp_path):
    failed = threading.Event()

    class Failing(DirectStorage):
        def write(self, data: bytes, /) -> None:
            failed.set()
            raise StorageError(os.strerror(errno.EIO))

    storage = BackgroundStorage(Failing(tmp_path / "file"))
    storage.write(b"x")
    failed.wait(5.0)
    with pytest.raises(StorageError):
        for _ in range(1000):
            storage.write(b"x")
            time.sleep(0.001)


def test_a_piece_that_was_written_in_part_is_undone_and_the_file_stays_one_that_all_open(tmp_path, monkeypatch):
    storage = DirectStorage(tmp_path / "file")
    storage.write(b"first piece")
    whole = (tmp_path / "file").read_bytes()
    write, calls = os.pwrite, []

    def full_after_ten_bytes(descriptor, data, position):
        calls.append(len(data))
        if len(calls) == 1:
            return write(descriptor, data[:10], position)
        if len(calls) == 2:
            raise OSError(errno.ENOSPC, "full")
        return write(descriptor, data, position)

    monkeypatch.setattr(os, "pwrite", full_after_ten_bytes)
    with pytest.raises(StorageError, match="the disk is full"):
        storage.write(b"second piece " * 20)
    assert (tmp_path / "file").read_bytes() == whole == b"first piece" + interim_ending()
    storage.write(b", third")
    assert (tmp_path / "file").read_bytes() == b"first piece, third" + interim_ending()


def test_a_full_disk_leaves_a_bag_that_others_open(tmp_path):
    writer = BagWriter(tmp_path / "bag", policy=POLICY, opener=FullDisk)
    with pytest.raises(StorageError):
        record(writer, 5000)
    with pytest.raises(StorageError):
        writer.close()
    ours = sum(1 for _ in Bag(tmp_path / "bag").messages())
    with AnyReader([tmp_path / "bag"]) as reader:
        assert sum(1 for _ in reader.messages()) == ours > 0


def test_a_description_that_the_disk_refuses_ends_the_recording_with_a_word(tmp_path, monkeypatch):
    def refuse(folder, text):
        raise OSError(errno.ENOSPC, "full")

    writer = BagWriter(tmp_path / "bag", policy=POLICY)
    monkeypatch.setattr("heave_bags.mcap.storage.replace_metadata", refuse)
    writer.add_topic("/boom_tip", "heave_msgs/msg/PointMotion", ())
    writer.write("/boom_tip", 1, DATA)
    with pytest.raises(StorageError, match="the disk is full"):
        writer.acknowledge()
