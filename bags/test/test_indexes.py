"""What the index of a file says is not taken as true: the file is read from front to back."""

from __future__ import annotations

import struct
import tempfile
from pathlib import Path

import mcap.writer
import pytest
import zstandard
from heave_bags.errors import BagError
from heave_bags.mcap.bounds import BoundError, unpack
from heave_bags.mcap.reader import Bag
from hostile_bags import HEAD, HEADER, topic
from hostile_bags import messages as records
from mcap.data_stream import RecordBuilder
from mcap.records import ChunkIndex
from mcap.writer import IndexType, Writer

COUNT = 500


def write(path: Path, *, profile: str = "ros2", qos: str = "", first: int = 1, **options: object) -> Path:
    """Write messages, their numbers, at the times of these numbers; `options` are of the writer."""
    with path.open("wb") as stream:
        writer = Writer(stream, **{"chunk_size": 2_000, **options})
        writer.start(profile=profile)
        channel = writer.register_channel("/a", "cdr", 0, {"offered_qos_profiles": qos} if qos else {})
        for number in range(first, first + COUNT):
            writer.add_message(channel, number, struct.pack("<I", number), number)
        writer.finish()
    return path


def numbers(bag: Bag) -> list[int]:
    return [struct.unpack("<I", message.data)[0] for message in bag.messages()]


def test_a_recording_in_several_files_is_read_however_they_are_packed(tmp_path):
    folder = tmp_path / "bag"
    folder.mkdir()
    kinds = (mcap.writer.CompressionType.LZ4, mcap.writer.CompressionType.NONE, mcap.writer.CompressionType.ZSTD)
    for number, kind in enumerate(kinds):
        write(folder / f"bag_{number}.mcap", first=1 + number * COUNT, compression=kind)
    bag = Bag(folder)
    assert numbers(bag) == list(range(1, 3 * COUNT + 1))
    assert bag.losses == []
    part = [struct.unpack("<I", message.data)[0] for message in bag.messages(start=COUNT, end=COUNT + 3)]
    assert part == [COUNT, COUNT + 1, COUNT + 2, COUNT + 3]


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("chunk_start_offset", 60),
        ("chunk_length", 5),
        ("compressed_size", 10),
        ("uncompressed_size", 1 << 50),
        ("message_start_time", 1 << 62),
        ("message_end_time", 0),
        ("message_index_length", 0),
        ("message_index_offsets", {}),
        ("message_index_offsets", {1: 9, 7: 8}),
        ("compression", ""),
    ],
)
def test_an_index_that_is_wrong_is_not_believed(tmp_path, monkeypatch, field, value):
    class Wrong(ChunkIndex):
        def write(self, stream: RecordBuilder) -> None:
            ChunkIndex(**{**vars(self), field: value}).write(stream)

    monkeypatch.setattr(mcap.writer, "ChunkIndex", Wrong)
    bag = Bag(write(tmp_path / "a.mcap"))
    assert numbers(bag) == list(range(1, COUNT + 1))
    assert bag.losses == []


@pytest.mark.parametrize(
    "options",
    [
        {"profile": ""},
        {"qos": "- {reliability: reliable}"},
        {"index_types": IndexType.ALL & ~IndexType.MESSAGE},
        {"index_types": IndexType.NONE},
        {"use_chunking": False},
        {"use_statistics": False},
    ],
    ids=str,
)
def test_what_other_readers_refuse_or_pass_over_is_read(tmp_path, options):
    bag = Bag(write(tmp_path / "a.mcap", **options))
    assert numbers(bag) == list(range(1, COUNT + 1))
    assert bag.losses == []


def test_what_is_packed_behind_a_chunk_is_not_unpacked():
    """A reader that unpacks every frame would be given any number of bytes."""
    plain = topic() + records(HEAD + HEADER)
    behind = zstandard.compress(plain) + zstandard.compress(bytes(1 << 20))
    with pytest.raises((BoundError, zstandard.ZstdError)):
        unpack("zstd", behind, len(plain))


def shuffled(folder: Path) -> Bag:
    """Return a bag whose messages are in no order."""
    folder.mkdir()
    for name, first in (("a", 1001), ("b", 1)):
        write(folder / f"{name}.mcap", first=first)
    with (folder / "c.mcap").open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        channel = writer.register_channel("/a", "cdr", 0)
        for number in (1, 2000, 700):
            writer.add_message(channel, number, struct.pack("<I", number), number)
        writer.finish()
    return Bag(folder)


def test_a_file_that_has_gone_since_it_was_checked_is_named(tmp_path):
    bag = Bag(write(tmp_path / "a.mcap"))
    assert len(numbers(bag)) == COUNT
    bag.files[0].unlink()
    with pytest.raises(BagError, match=r"a\.mcap: cannot be read"):
        numbers(bag)


def test_what_was_sorted_goes_with_its_bag(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    bag = shuffled(tmp_path / "bag")
    read = numbers(bag)
    assert len(read) == 2 * COUNT + 3
    assert read == sorted(read)
    assert len(list(tmp_path.glob("heave_bag_*"))) == 1
    del bag
    assert not list(tmp_path.glob("heave_bag_*"))


def test_a_disk_without_room_to_sort_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr("heave_bags.mcap.read.order.mkdtemp", _refuse)
    with pytest.raises(BagError, match=r"no room to sort its messages in .*; set TMPDIR to a folder with more room"):
        numbers(shuffled(tmp_path / "bag"))


def _refuse(*_: object, **__: object) -> None:
    raise OSError(28, "No space left on device")
