"""Bags of other recorders, and bags that an accident has hit: all that is in them is read, the rest is named."""

import os
import shlex
import shutil
from pathlib import Path

import numpy as np
import pytest
import zstandard
from bags_of_others import PERIOD, START, TOPIC, heave_at, samples, write_mcap, write_metadata, write_split
from heave_bags.analyse.read_run import read_run
from heave_bags.errors import BagError
from heave_bags.mcap import repair
from heave_bags.mcap.bag_writer import BagPolicy
from heave_bags.mcap.reader import Bag
from heave_bags.mcap.writer import ChunkPolicy
from heave_devices.records.sea_import import import_sea
from made_up_run import MadeUpRun
from mcap.reader import make_reader

NEW_NAMES = (
    "0_trial_2026_03_01-10_00_50.mcap",
    "1_trial_2026_03_01-10_02_30.mcap",
    "2_trial_2026_03_01-10_04_10.mcap",
)
ROSBAG2 = "ROSBAG2_SOURCE"
"""Names the folder of rosbag2's source, in which its test bags are."""


def check_sea(source: Path, duration: float) -> list[str]:
    """Check that a bag is imported as the heave that was written, all of it; return what is noted."""
    sea = import_sea(source, TOPIC)
    assert sea.time[-1] == pytest.approx(duration, abs=0.051)  # to a sample of the 20 Hz that it is resampled to
    heave = np.array([heave_at(time) for time in sea.time])
    assert np.abs(sea.position[:, 2] - (heave - heave.mean())).max() < 1e-4  # cubic splines over 90 samples a wave
    return sea.notes


# Order ---------------------------------------------------------------------------------------------------------------


def test_split_files_with_a_time_in_their_names_are_read_in_their_order(tmp_path):
    write_split(tmp_path / "bag", NEW_NAMES)
    notes = check_sea(tmp_path / "bag", 299.9)
    assert not any("skipped" in note or "not in the order" in note for note in notes)


@pytest.mark.parametrize("keep", [True, False], ids=["with metadata.yaml", "without"])
def test_renamed_files_are_read_in_the_order_of_their_times_and_none_is_missed(tmp_path, keep):
    folder = tmp_path / "bag"
    write_split(folder, NEW_NAMES)
    for old, new in zip(NEW_NAMES, ("c.mcap", "b.mcap", "a_0.mcap"), strict=True):
        (folder / old).rename(folder / new)
    if not keep:
        (folder / "metadata.yaml").unlink()
    assert not any("skipped" in note for note in check_sea(folder, 299.9))
    bag = Bag(folder)
    assert [path.name for path in bag.files] == ["c.mcap", "b.mcap", "a_0.mcap"]
    assert [m.log_time for m in bag.messages()] == [START + PERIOD * number for number in range(3000)]
    assert bag.losses == []


def late_block() -> list:
    whole = samples()
    return [*whole[:2000], *whole[4000:], *whole[2000:4000]]


def swapped_neighbours() -> list:
    whole = samples()
    return [whole[index ^ 1] for index in range(len(whole))]


@pytest.mark.parametrize("options", [{}, {"chunk_size": 20_000}, {"use_chunking": False}], ids=["one", "many", "none"])
@pytest.mark.parametrize("order", [late_block, swapped_neighbours])
def test_messages_in_any_order_are_read_by_log_time_and_it_is_said_once(tmp_path, order, options):
    path = write_mcap(tmp_path / "a.mcap", order(), **options)
    notes = check_sea(path, 599.9)
    assert sum("not in the order of their log times" in note for note in notes) == 1
    assert not any("skipped" in note for note in notes)


def test_a_repair_puts_messages_in_order(tmp_path):
    path = write_mcap(tmp_path / "a.mcap", late_block(), chunk_size=20_000)
    saved = repair.repair(path, tmp_path / "saved")
    assert "not in the order" in str(saved)
    with Bag(saved.folder).files[0].open("rb") as stream:
        times = [m.log_time for _, _, m in make_reader(stream).iter_messages(log_time_order=False)]
    assert times == [START + PERIOD * number for number in range(6000)]
    assert Bag(saved.folder).notes == []


def test_files_that_overlap_are_merged(tmp_path):
    folder = tmp_path / "bag"
    folder.mkdir()
    whole = samples(3000)
    write_mcap(folder / "bag_0.mcap", whole[::2], chunk_size=5_000)
    write_mcap(folder / "bag_1.mcap", whole[1::2], chunk_size=5_000)
    bag = Bag(folder)
    assert [m.log_time for m in bag.messages()] == [time for time, _ in whole]
    assert [m.log_time for m in bag.messages(start=whole[100][0], end=whole[200][0])] == [t for t, _ in whole[100:201]]


@pytest.mark.parametrize("options", [{}, {"chunk_size": 20_000}], ids=["one chunk", "many chunks"])
def test_after_a_reset_of_the_clock_the_order_is_that_of_the_file(tmp_path, options):
    first, again = samples(1500), samples(1000)
    bag = Bag(write_mcap(tmp_path / "reset.mcap", [*first, *again], **options))
    assert [m.log_time for m in bag.messages()] == [time for time, _ in [*first, *again]]
    assert "its clock was reset" in bag.notes[0]


def test_after_a_reset_in_another_file_the_order_is_that_of_metadata_yaml(tmp_path):
    folder = tmp_path / "bag"
    folder.mkdir()
    parts = {"z.mcap": samples(1500), "a.mcap": samples(1000)}
    for name, part in parts.items():
        write_mcap(folder / name, part)
    write_metadata(folder, list(parts.items()))
    assert [m.log_time for m in Bag(folder).messages()] == [time for part in parts.values() for time, _ in part]


def test_own_files_are_known_by_what_is_in_them_not_by_their_names(made_up_bag):
    folder = made_up_bag(
        run=MadeUpRun(duration=20.0), policy=BagPolicy(ChunkPolicy(size=10_000), max_file_bytes=50_000)
    )
    before = list(Bag(folder).messages())
    files = Bag(folder).files
    for path in files:
        path.rename(path.with_suffix(".moved"))
    for number, path in enumerate(reversed(files)):
        path.with_suffix(".moved").rename(folder / f"run_{number}.mcap")
    bag = Bag(folder)
    assert list(bag.messages()) == before
    (folder / "metadata.yaml").unlink()
    bag = Bag(folder)
    assert list(bag.messages()) == before
    assert bag.losses == []


# Bad neighbours and missing files ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "content", "word"),
    [
        ("bag_1.mcap", b"", "empty"),
        ("bag_1.mcap", bytes(100_000), "zeros"),
        ("bag_1.mcap", b"PK\x03\x04 something else", "not an MCAP file"),
        ("._bag_0.mcap", b"\x00\x05\x16\x07\x00\x02\x00\x00Mac OS X", "macOS"),
    ],
)
def test_a_bad_neighbour_is_named_and_costs_nothing_else(tmp_path, name, content, word):
    folder = tmp_path / "bag"
    folder.mkdir()
    write_mcap(folder / "bag_0.mcap", samples())
    (folder / name).write_bytes(content)
    notes = check_sea(folder, 599.9)
    assert sum(name in note and word in note for note in notes) == 1
    saved = repair.repair(folder, tmp_path / "saved")
    assert saved.messages == 6000
    assert name in str(saved)
    bag = repair.reindex(folder)
    assert name in "".join([*bag.notes, *map(str, bag.losses)])
    assert [path.name for path in Bag(folder).files] == ["bag_0.mcap"]
    assert "relative_file_paths:\n  - bag_0.mcap\n  files:" in (folder / "metadata.yaml").read_text()


def test_what_metadata_yaml_says_of_an_empty_file_is_what_is_lost(tmp_path):
    write_split(tmp_path / "bag", ["bag_0.mcap", "bag_1.mcap", "bag_2.mcap"])
    (tmp_path / "bag" / "bag_1.mcap").write_bytes(b"")
    bag = Bag(tmp_path / "bag")
    assert len(list(bag.messages())) == 2000
    (loss,) = bag.losses
    assert (loss.file.name, loss.messages) == ("bag_1.mcap", 1000)
    assert (loss.start, loss.end) == (START + 1000 * PERIOD, START + 1999 * PERIOD)


def test_a_file_that_nobody_may_read_is_named(tmp_path):
    write_split(tmp_path / "bag", ["bag_0.mcap", "bag_1.mcap"])
    (tmp_path / "bag" / "bag_1.mcap").chmod(0)
    if os.access(tmp_path / "bag" / "bag_1.mcap", os.R_OK):
        pytest.skip("this user may read everything")
    bag = Bag(tmp_path / "bag")
    assert len(list(bag.messages())) == 1000
    assert "cannot be read" in str(bag.losses[0])


def test_a_bag_of_which_nothing_can_be_read_is_refused_with_the_reason(tmp_path):
    folder = tmp_path / "bag"
    folder.mkdir()
    (folder / "bag_0.mcap").write_bytes(b"")
    with pytest.raises(BagError, match=r"bag_0\.mcap: the file is empty"):
        Bag(folder)


def test_a_bag_of_no_run_is_called_so_whatever_was_lost_of_it(tmp_path):
    write_split(tmp_path / "bag", ("bag_0.mcap", "bag_1.mcap"))
    (tmp_path / "bag" / "bag_1.mcap").write_bytes(b"")
    with pytest.raises(
        BagError, match=f"none of a run's topics in it; it holds {TOPIC}; bag_1.mcap: the file is empty"
    ):
        read_run(tmp_path / "bag")


@pytest.mark.parametrize("version", [9, 4], ids=["counts by file", "names only"])
def test_a_missing_split_file_is_named_with_its_messages(tmp_path, version):
    parts = write_split(tmp_path / "bag", ["bag_0.mcap", "bag_1.mcap", "bag_2.mcap"], 2000)
    if version == 4:
        write_metadata(
            tmp_path / "bag", [(f"bag_{n}.mcap", part) for n, part in enumerate(parts)], files=None, version=4
        )
    (tmp_path / "bag" / "bag_1.mcap").unlink()
    bag = Bag(tmp_path / "bag")
    assert len(list(bag.messages())) == 4000
    (loss,) = bag.losses
    assert (loss.file.name, loss.messages) == ("bag_1.mcap", 2000)
    assert "missing" in str(loss)


def test_a_missing_file_of_an_own_bag_is_known_from_those_after_it(made_up_bag):
    folder = made_up_bag(
        run=MadeUpRun(duration=20.0), policy=BagPolicy(ChunkPolicy(size=10_000), max_file_bytes=50_000)
    )
    counts = {part.name: part.messages for part in Bag(folder).file_summaries}
    (folder / "metadata.yaml").unlink()
    (folder / "run_1.mcap").unlink()
    bag = Bag(folder)
    read = len(list(bag.messages()))
    assert {loss.file.name: loss.messages for loss in bag.losses} == {"run_1.mcap": counts["run_1.mcap"]}
    assert read == sum(counts.values()) - counts["run_1.mcap"]


def test_a_copy_beside_a_file_is_not_read_twice(tmp_path):
    write_split(tmp_path / "bag", ["bag_0.mcap", "bag_1.mcap"])
    shutil.copy(tmp_path / "bag" / "bag_0.mcap", tmp_path / "bag" / "bag_0 (copy).mcap")
    bag = Bag(tmp_path / "bag")
    assert len(list(bag.messages())) == 2000
    assert "bag_0 (copy).mcap is a copy" in bag.notes[0]


def test_a_piece_that_is_there_twice_is_told(tmp_path):
    path = write_mcap(tmp_path / "a.mcap", samples(1000), chunk_size=20_000)
    data = path.read_bytes()
    with path.open("rb") as stream:
        second = make_reader(stream).get_summary().chunk_indexes[1]
    end = second.chunk_start_offset + second.chunk_length
    path.write_bytes(data[:end] + data[second.chunk_start_offset : end] + data[end:])
    bag = Bag(path)
    more = len(list(bag.messages())) - 1000
    assert more > 0
    assert any(f"{more} messages more than the file says" in str(loss) for loss in bag.losses)


# Compression, definitions, names -------------------------------------------------------------------------------------


def test_files_that_are_compressed_as_a_whole_are_named_with_the_way_out(tmp_path):
    names = ["bag_0.mcap", "bag_1.mcap"]
    write_split(tmp_path / "bag", names)
    plain = tmp_path / "bag" / names[1]
    packed = plain.with_name(f"{plain.name}.zstd")
    packed.write_bytes(zstandard.compress(plain.read_bytes()))
    plain.unlink()
    bag = Bag(tmp_path / "bag")
    assert len(list(bag.messages())) == 1000
    assert any("bag_1.mcap.zstd: compressed as a whole; unpack it: zstd -d" in str(loss) for loss in bag.losses)
    with pytest.raises(BagError, match="compressed as a whole; unpack it: zstd -d"):
        Bag(packed).message_count  # noqa: B018 - read


def test_messages_that_are_compressed_one_by_one_are_refused_with_the_way_out(tmp_path):
    path = write_mcap(tmp_path / "a.mcap", samples(100), packed=True)
    with pytest.raises(BagError, match="each message is compressed: use ros2 bag convert, of a full ROS 2"):
        list(Bag(path).messages())


IDL = """================================================================================
IDL: std_msgs/msg/Float64
module std_msgs {
  module msg {
    @verbatim (language="comment", text=
      "a number; { not a brace" "\\n" "(of any kind)")
    struct Float64 {
      @verbatim (language="comment", text="the value")
      double data;
    };
  };
};
"""


def test_a_type_that_is_defined_in_idl_is_read_by_that_definition(tmp_path):
    check_sea(write_mcap(tmp_path / "a.mcap", samples(), encoding="ros2idl", definition=IDL), 599.9)
    other = write_mcap(tmp_path / "b.mcap", samples(), encoding="ros2idl", definition=IDL.replace(" data", " value"))
    assert Bag(other).frame(TOPIC)["value"].iloc[1] == samples()[1][1]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"encoding": "ros2idl", "definition": IDL.replace("double data", "double")}, "in IDL that cannot be read"),
        ({"encoding": "protobuf", "definition": "x"}, "Protobuf"),
        ({"encoding": "", "definition": ""}, "without its definition"),
    ],
)
def test_a_definition_that_cannot_be_used_is_called_by_its_kind(tmp_path, options, words):
    path = write_mcap(tmp_path / "a.mcap", samples(100), **options)
    with pytest.raises(BagError, match=words):
        Bag(path).frame(TOPIC)


def test_files_without_an_ending_are_read(tmp_path):
    write_split(tmp_path / "bag", ["bag_0", "bag_1"])
    check_sea(tmp_path / "bag", 199.9)
    (tmp_path / "bag" / "metadata.yaml").unlink()
    check_sea(tmp_path / "bag", 199.9)


def test_the_command_that_a_message_gives_can_be_pasted(tmp_path):
    folder = tmp_path / "my trial" / "bag"
    folder.mkdir(parents=True)
    path = write_mcap(folder / "bag_0.mcap", samples())
    path.write_bytes(path.read_bytes()[:-500])
    with pytest.raises(BagError, match="repair the bag instead") as caught:
        repair.reindex(folder)
    command = shlex.split(str(caught.value).split("repair the bag instead: ")[1])
    assert command == ["heave", "repair", str(folder), "--output", f"{folder}_repaired"]


# Real bags -----------------------------------------------------------------------------------------------------------


def rosbag2_files() -> list[Path]:
    source = os.environ.get(ROSBAG2)
    return sorted(Path(source).rglob("*.mcap")) if source else []


@pytest.mark.skipif(not rosbag2_files(), reason=f"{ROSBAG2} does not name a folder with rosbag2's test bags")
def test_the_test_bags_of_rosbag2_are_read_as_the_reference_reader_reads_them():
    for path in rosbag2_files():
        bag = Bag(path)
        got = [(m.topic, m.log_time, m.data) for m in bag.messages()]
        with path.open("rb") as stream:
            by_mcap = [(c.topic, m.log_time, m.data) for _, c, m in make_reader(stream).iter_messages()]
        assert got == by_mcap, path
        assert bag.losses == [], path
    for folder in sorted({path.parent for path in rosbag2_files() if (path.parent / "metadata.yaml").exists()}):
        bag = Bag(folder)
        times = [message.log_time for message in bag.messages()]
        assert times == sorted(times), folder
        assert len(times) == bag.stated["message_count"], folder
        assert bag.losses == [], folder
