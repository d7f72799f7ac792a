"""rosbags reads a file as it stands only where that gives every message; any other is repaired first."""

from __future__ import annotations

import struct
from pathlib import Path

import mcap.writer
import pytest
import zstandard
from heave_bags.errors import BagError
from heave_bags.mcap.bounds import BoundError, unpack
from heave_bags.mcap.reader import Bag
from hostile_bags import HEAD, HEADER, topic
from hostile_bags import messages as records
from made_up_run import MadeUpRun, write_run
from mcap.data_stream import RecordBuilder
from mcap.records import ChunkIndex
from mcap.writer import IndexType, Writer
from rosbags.rosbag2 import Reader

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


def test_sound_files_are_read_as_they_stand(tmp_path):
    """Also those of a recording in several files, packed by lz4 or not at all."""
    folder = tmp_path / "bag"
    folder.mkdir()
    kinds = (mcap.writer.CompressionType.LZ4, mcap.writer.CompressionType.NONE, mcap.writer.CompressionType.ZSTD)
    for number, kind in enumerate(kinds):
        write(folder / f"bag_{number}.mcap", first=1 + number * COUNT, compression=kind)
    bag = Bag(folder)
    assert numbers(bag) == list(range(1, 3 * COUNT + 1))
    assert bag.sound_files() == bag.files
    write_run(tmp_path / "own", MadeUpRun(duration=5.0))
    assert Bag(tmp_path / "own").sound_files() == [tmp_path / "own" / "own_0.mcap"]


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
    assert bag.sound_files() != bag.files


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
def test_what_rosbags_would_refuse_or_pass_over_is_read(tmp_path, options):
    bag = Bag(write(tmp_path / "a.mcap", **options))
    assert numbers(bag) == list(range(1, COUNT + 1))
    assert bag.losses == []


def test_rosbags_passes_over_chunks_without_message_indexes(tmp_path):
    """This is why a file is checked first; where it is no longer so, a check may go."""
    path = write(tmp_path / "a.mcap", index_types=IndexType.ALL & ~IndexType.MESSAGE)
    with Reader(path) as reader:
        assert list(reader.messages()) == []


def test_what_is_packed_behind_a_chunk_is_not_unpacked():
    """A reader that unpacks every frame would be given any number of bytes."""
    plain = topic() + records(HEAD + HEADER)
    behind = zstandard.compress(plain) + zstandard.compress(bytes(1 << 20))
    with pytest.raises((BoundError, zstandard.ZstdError)):
        unpack("zstd", behind, len(plain))


def test_a_copy_lives_as_long_as_its_bag(tmp_path):
    bag = Bag(write(tmp_path / "a.mcap", profile=""))
    (copy,) = bag.sound_files()
    assert copy.exists()
    del bag
    assert not copy.parent.exists()


def test_a_file_that_has_gone_since_it_was_checked_is_named(tmp_path):
    bag = Bag(write(tmp_path / "a.mcap"))
    bag.sound_files()[0].unlink()
    with pytest.raises(BagError, match=r"a\.mcap: cannot be read"):
        list(bag.messages())


def test_a_disk_without_room_for_a_copy_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr("heave_bags.mcap.read.recovery.McapWriter", _refuse)
    with pytest.raises(BagError, match=r"no room for a sound copy in .*; set TMPDIR to a folder with more room"):
        list(Bag(write(tmp_path / "a.mcap", profile="")).messages())


def _refuse(*_: object) -> None:
    raise OSError(28, "No space left on device")
