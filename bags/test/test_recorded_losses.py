"""A bag itself says what its recorder could not write: in `metadata.yaml`, and to everyone who reads it."""

from __future__ import annotations

import errno
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest
import yaml
from heave_bags.analyse.read_run import read_run
from heave_bags.errors import StorageError
from heave_bags.mcap.bag_writer import BagWriter
from heave_bags.mcap.files import METADATA_ROOT, RECORDING_MARK
from heave_bags.mcap.loss import RecordedLoss, recorded_loss
from heave_bags.mcap.reader import Bag
from heave_bags.mcap.repair import repair
from heave_bags.mcap.storage import BackgroundStorage, DirectStorage
from heave_bags.record import sequence_gaps
from heave_bags.record import session as session_module
from heave_bags.record.sequence_gaps import SequenceGaps
from heave_bags.record.session import RecordingSession, SnapshotRing, missing_messages
from test_storage import POLICY, FullDisk, record

SENT = 1000


def custom_data(folder: Path) -> dict[str, str]:
    return yaml.safe_load((folder / "metadata.yaml").read_text())[METADATA_ROOT]["custom_data"]


def recorded_on(folder: Path, opener=FullDisk, count: int = SENT) -> RecordingSession:
    """Return the session, in real time, that was given `count` messages and whose disk refused some."""
    session = RecordingSession(
        lambda folder: BagWriter(folder, policy=POLICY, opener=opener), SnapshotRing(0, 0), survive=True
    )
    session.start(folder)
    record(session, count)
    session.acknowledge()
    if session.is_recording:
        with suppress(StorageError):  # a thread has written what it could, and is refused now
            session.stop()
    session.finish()
    return session


def test_the_bag_of_a_full_disk_holds_or_names_every_message_that_was_sent(tmp_path):
    recorded_on(tmp_path / "bag")
    bag = Bag(tmp_path / "bag")
    held = sum(1 for _ in bag.messages())
    (loss,) = (loss for loss in bag.losses if loss.messages != 0)
    assert held + loss.messages == SENT
    assert 0 < held < SENT
    assert "the disk is full" in str(loss)
    assert loss.end == SENT * 1_000_000
    assert str(loss.messages) == custom_data(tmp_path / "bag")["heave_lost_messages"]
    assert not RECORDING_MARK.items() <= custom_data(tmp_path / "bag").items()


def test_whoever_reads_the_bag_is_told(tmp_path):
    recorded_on(tmp_path / "bag")
    bag = Bag(tmp_path / "bag")
    assert bag.message_count > 0
    assert "the disk is full" in str(bag.losses[-1])
    saved = repair(tmp_path / "bag", tmp_path / "saved")
    assert "the disk is full" in str(saved.losses[-1])
    assert "the disk is full" in Bag(tmp_path / "saved").outcome["lost"]
    assert "the disk is full" in read_run(tmp_path / "bag").remarks()[-1]


def test_a_writer_that_is_refused_at_its_close_says_so_in_the_bag(tmp_path):
    writer = BagWriter(tmp_path / "bag", policy=POLICY, opener=FullDisk)
    with pytest.raises(StorageError):
        record(writer, 5000)
    with pytest.raises(StorageError, match="were lost") as told:
        writer.close()
    (loss,) = Bag(tmp_path / "bag")._not_recorded
    assert f"; {loss.messages} messages from" in str(told.value)


def test_what_comes_after_the_disk_was_full_is_counted_while_the_recorder_runs(tmp_path, monkeypatch):
    monkeypatch.setattr(session_module, "DESCRIPTION_PERIOD", 0.0)
    session = RecordingSession(
        lambda folder: BagWriter(folder, policy=POLICY, opener=FullDisk), SnapshotRing(0, 0), survive=True
    )
    session.start(tmp_path / "bag")
    for count in (SENT, 50):
        record(session, count)
        session.acknowledge()  # and then it is killed
    bag = Bag(tmp_path / "bag")
    assert sum(1 for _ in bag.messages()) + sum(loss.messages for loss in bag.losses) == SENT + 50


def test_a_slow_disk_says_what_it_did_not_take(tmp_path):
    recorded_on(tmp_path / "bag", lambda path: BackgroundStorage(FullDisk(path)))
    bag = Bag(tmp_path / "bag")
    assert sum(1 for _ in bag.messages()) + sum(loss.messages for loss in bag.losses) == SENT


def test_a_disk_that_takes_no_new_file_still_gets_the_mark(tmp_path, monkeypatch):
    from heave_bags.mcap import files  # noqa: PLC0415

    write = Path.write_bytes

    def refuse(path, content):
        if path.name.startswith("metadata.yaml"):
            raise OSError(errno.ENOSPC, "full")
        return write(path, content)

    class ThenFull(FullDisk):
        def write(self, data: bytes, /) -> None:
            if len(data) > self.left:
                monkeypatch.setattr(files.Path, "write_bytes", refuse)
            super().write(data)

    recorded_on(tmp_path / "bag", ThenFull)
    bag = Bag(tmp_path / "bag")
    assert sum(1 for _ in bag.messages()) + sum(loss.messages for loss in bag.losses) == SENT
    assert not (tmp_path / "bag" / "metadata.yaml.new").exists()


def test_a_folder_that_is_deleted_under_way_is_named(tmp_path):
    writer = BagWriter(tmp_path / "bag", policy=POLICY)
    record(writer, 10)
    shutil.rmtree(tmp_path / "bag")
    with pytest.raises(StorageError, match="10 messages were lost with the folder"):
        writer.close()


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """Return a file system of 200 kB."""
    folder = tmp_path / "disk"
    folder.mkdir()
    done = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=200k", "none", folder], check=False)
    if done.returncode:
        pytest.skip("no file system may be mounted here")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


@pytest.mark.parametrize("direct", [True, False])
def test_a_disk_that_is_really_full_leaves_a_bag_that_says_so(small_disk, direct):
    opener = DirectStorage if direct else lambda path: BackgroundStorage(DirectStorage(path))
    recorded_on(small_disk / "bag", opener, 4 * SENT)
    bag = Bag(small_disk / "bag")
    assert sum(1 for _ in bag.messages()) + sum(loss.messages for loss in bag.losses) == 4 * SENT


@pytest.mark.parametrize(
    "stated",
    [
        {"heave_lost_reason": "x", "heave_lost_messages": "many"},
        {"heave_lost_reason": "x", "heave_lost_messages": "9" * 5000},
        {"heave_lost_messages": "5"},
        {"heave_lost_reason": "x", "heave_lost_messages": None},
        [],
        None,
        "heave_lost_reason",
    ],
)
def test_a_loss_that_makes_no_sense_is_none(stated):
    assert recorded_loss({"custom_data": stated}) is None


def test_a_loss_is_read_as_it_was_written():
    loss = RecordedLoss("the disk is full", 515, 10, 20)
    assert recorded_loss({"custom_data": loss.to_custom_data()}) == loss
    strange = {
        **loss.to_custom_data(),
        "heave_lost_messages": "-5",
        "heave_lost_to_ns": "1",
        "heave_lost_reason": "a\nb",
    }
    assert recorded_loss({"custom_data": strange}) == RecordedLoss("a\\nb", 0, 10, 10)


def test_losses_join_to_one():
    one, other = RecordedLoss("a", 1, 10, 20), RecordedLoss("b", 2, 5, 15)
    assert one.joined(other) == RecordedLoss("a; b", 3, 5, 20)
    assert one.joined(one).reason == "a"
    assert one.joined(None) == one


def test_gaps_in_the_numbers_of_a_publisher_are_messages_that_were_dropped():
    found = []
    gaps = SequenceGaps(lambda topic, count: found.append((topic, count)))

    def take(topic, publisher, *numbers):
        for number in numbers:
            information = {"publication_sequence_number": number, "publisher_gid": {"data": publisher}}
            gaps.note(topic, information)

    take("/a", b"1", 7, 8, 9)  # it came late: no gap
    take("/a", b"2", 1, 2)
    take("/b", b"1", 1)
    assert found == []
    take("/a", b"1", 15, 16)  # 10 to 14
    take("/a", b"2", 4, 3)  # 3 was overtaken
    take("/b", b"1", 1, 2)
    assert found == [("/a", 5), ("/a", 1)]
    gaps.note("/a", {})
    gaps.note("/a", {"publication_sequence_number": None, "publisher_gid": None})
    assert found == [("/a", 5), ("/a", 1)]


def test_a_number_that_comes_again_hides_no_gap_behind_it():
    """Where the middleware gives a message twice, or a late one, the newest number stays what it was."""
    found = []
    gaps = SequenceGaps(lambda *gap: found.append(gap))
    for number in (5, 5, 3, 7, 7, 6, 8):
        gaps.note("/a", {"publication_sequence_number": number, "publisher_gid": {"data": b"1"}})
    assert found == [("/a", 1)]


def test_a_recorder_that_takes_a_message_takes_note_of_its_number_and_of_the_message(monkeypatch):
    """Numbers 1 and 4 of the messages that it takes: two are missing."""
    monkeypatch.setattr(sequence_gaps, "with_information", lambda take: take)
    found, taken = [], []
    take = SequenceGaps(lambda *gap: found.append(gap)).noting("/a", lambda *given: taken.append(given))
    for number in (1, 4):
        information = {"publication_sequence_number": number, "publisher_gid": {"data": b"1"}}
        take(b"message", information)
        assert taken[-1] == (b"message", information)
    assert found == [("/a", 2)]
    assert len(taken) == 2


def test_topics_that_hold_less_than_was_published_are_known_by_number():
    assert missing_messages({"/a": 5, "/b": 3, "/c": 1}, {"/a": 2, "/b": 3}) == {"/a": 3}
