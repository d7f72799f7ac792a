"""What rosbag2 reads of a bag as a whole: `metadata.yaml`, and the record inside each file."""

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import yaml
from heave_bags.mcap import repair
from heave_bags.mcap.bag_writer import BagPolicy, BagWriter
from heave_bags.mcap.files import METADATA_ROOT, RECORDING_MARK, file_counts, parse_information, read_information
from heave_bags.mcap.reader import Bag, summary_of
from heave_bags.mcap.writer import ChunkPolicy
from made_up_run import MadeUpRun, write_run
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader

SPLIT = BagPolicy(ChunkPolicy(size=10_000), max_file_bytes=50_000)


def records_of(path: Path) -> list[dict]:
    """Return what the records of rosbag2 in a file say, as others read them: by the index of the file."""
    with path.open("rb") as stream:
        found = [record for record in make_reader(stream).iter_metadata() if record.name == "rosbag2"]
    return [yaml.safe_load(record.metadata["serialized_metadata"]) for record in found]


@pytest.fixture(scope="module")
def split_bag(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("split") / "bag"
    write_run(folder, MadeUpRun(duration=20.0), SPLIT)
    assert len(list(folder.glob("*.mcap"))) > 2
    return folder


def test_every_file_carries_the_inner_mapping_that_rosbag2_reads_there(split_bag):
    for number, path in enumerate(Bag(split_bag).files):
        opening, closing = records_of(path)
        for record in (opening, closing):  # rosbag2 asks for these at the top: without them it plays nothing
            assert next(iter(record.items())) == ("version", 9)
            assert METADATA_ROOT not in record
            assert record["storage_identifier"] == "mcap"
            assert record["ros_distro"] == "kilted"
        assert closing["relative_file_paths"][-1] == path.name
        assert len(closing["files"]) == number + 1
        assert closing["message_count"] == sum(part["message_count"] for part in closing["files"])


def test_the_last_record_is_what_metadata_yaml_says(split_bag):
    last = records_of(Bag(split_bag).files[-1])[-1]
    outside = yaml.safe_load((split_bag / "metadata.yaml").read_text())
    assert outside == {METADATA_ROOT: last}


def test_a_record_names_what_every_topic_offers(split_bag):
    topics = records_of(Bag(split_bag).files[-1])[-1]["topics_with_message_count"]
    latched = next(topic["topic_metadata"] for topic in topics if topic["topic_metadata"]["name"] == "/sea_state")
    assert latched["offered_qos_profiles"][0]["durability"] == "transient_local"
    assert latched["type_description_hash"].startswith("RIHS01_")


def test_a_bag_under_way_is_described_from_its_first_moment(tmp_path):
    BagWriter(tmp_path / "bag", run={"scenario": "calm"}, ros_distro="kilted")
    information = read_information(tmp_path / "bag")
    assert information["relative_file_paths"] == ["bag_0.mcap"]
    assert information["custom_data"] == {"scenario": "calm", **RECORDING_MARK}
    with AnyReader([tmp_path / "bag"]) as reader:
        assert reader.message_count == 0


def test_the_description_is_kept_current_and_loses_its_mark_at_the_end(tmp_path, monkeypatch):
    monkeypatch.setattr("heave_bags.mcap.bag_writer.DESCRIPTION_PERIOD", 0.0)
    writer = write_run(tmp_path / "bag", MadeUpRun(duration=5.0), close=False)
    writer.acknowledge()
    information = read_information(tmp_path / "bag")
    assert information["message_count"] == 606
    assert file_counts(information) == {}, "what is still counted up is no evidence of a loss"
    writer.split()
    assert read_information(tmp_path / "bag")["relative_file_paths"] == ["bag_0.mcap", "bag_1.mcap"]
    writer.close()
    information = read_information(tmp_path / "bag")
    assert not RECORDING_MARK.items() <= information["custom_data"].items()
    assert file_counts(information) == {"bag_0.mcap": 606, "bag_1.mcap": 0}


def test_a_description_is_written_at_once_for_new_topics_and_once_a_second_after_that(tmp_path):
    writer = write_run(tmp_path / "bag", MadeUpRun(duration=5.0), close=False)
    writer.acknowledge()
    assert read_information(tmp_path / "bag")["message_count"] == 606, "with the first messages of its topics"
    data = next(Bag(tmp_path / "bag").messages(["/boom_tip"])).data
    writer.write("/boom_tip", 6_000_000_000, data)
    writer.acknowledge()
    assert read_information(tmp_path / "bag")["message_count"] == 606
    writer.close()


KILLED = """
import os, sys
sys.path.insert(0, {tests!r})
from pathlib import Path
from made_up_run import MadeUpRun, write_run
from heave_bags.mcap.bag_writer import BagPolicy
from heave_bags.mcap.writer import ChunkPolicy
policy = BagPolicy(ChunkPolicy(size={chunk}), max_file_bytes={split})
writer = write_run(Path({folder!r}), MadeUpRun(duration={duration}), policy, close=False)
writer.acknowledge()
os.kill(os.getpid(), 9)
"""


@pytest.mark.parametrize(
    ("duration", "split", "chunk"),
    [(20.0, 0, 8_000), (20.0, 50_000, 8_000), (0.05, 0, 8_000), (0.3, 0, 1_000_000)],
    ids=["one file", "split", "first tick", "before the first chunk is full"],
)
def test_the_bag_of_a_killed_writer_opens_at_once_with_the_readers_of_others(tmp_path, duration, split, chunk):
    folder = tmp_path / "bag"
    script = KILLED.format(
        tests=str(Path(__file__).parent), folder=str(folder), duration=duration, split=split, chunk=chunk
    )
    assert subprocess.run([sys.executable, "-c", script], check=False).returncode == -signal.SIGKILL
    bag = Bag(folder)
    messages = list(bag.messages())
    assert len(messages) == round(duration / 0.05) * 6 + int(duration) + 1, "nothing acknowledged is missing"
    with AnyReader([folder]) as reader:
        by_rosbags = sum(1 for _ in reader.messages())
    by_mcap = 0
    for path in bag.files:
        with path.open("rb") as stream:
            by_mcap += sum(1 for _ in make_reader(stream, validate_crcs=True).iter_messages())
    assert by_rosbags == by_mcap
    assert len(messages) - by_mcap < 40, "those that lack are in the journal, for a moment less than a chunk"
    assert records_of(bag.files[0])[0]["version"] == 9


def test_a_repair_keeps_messages_and_distribution_where_there_is_no_metadata_yaml(made_up_bag, tmp_path):
    bag = made_up_bag("bag", MadeUpRun(duration=5.0), SPLIT)
    (bag / "metadata.yaml").unlink()
    saved = Bag(repair.repair(bag, tmp_path / "saved").folder)
    for path in saved.files:
        assert [record["version"] for record in records_of(path)] == [9, 9]
    assert saved.ros_distro == "kilted"
    assert list(saved.messages()) == list(Bag(bag).messages())


def test_a_repair_keeps_what_others_have_put_in(tmp_path):
    writer = BagWriter(tmp_path / "bag", records=[("camera", {"serial": "7"})], ros_distro="jazzy")
    writer.add_topic("/quiet", "sensor_msgs/msg/Imu")
    writer.close()
    repair.repair(tmp_path / "bag", tmp_path / "saved")
    assert ("camera", {"serial": "7"}) in Bag(tmp_path / "saved").metadata
    assert summary_of(Bag(tmp_path / "saved")).ros_distro == "jazzy"


@pytest.mark.parametrize("text", ["", "[", "- 1", "a: {b", "rosbag2_bagfile_information: 3", "[" * 1000])
def test_a_description_that_says_nothing_sensible_says_nothing(text):
    assert parse_information(text) == {}
    assert file_counts(parse_information(text)) == {}


def test_counts_that_do_not_agree_with_each_other_are_no_evidence(made_up_bag):
    information = read_information(made_up_bag(run=MadeUpRun(duration=5.0)))
    assert file_counts(information) == {"run_0.mcap": 606}
    for wrong in (605, "many", None, -606):
        assert file_counts({**information, "message_count": wrong}) == {}


def test_the_files_of_a_bag_can_be_moved_and_renamed(made_up_bag, tmp_path):
    path = made_up_bag(run=MadeUpRun(duration=5.0)) / "run_0.mcap"
    shutil.copy(path, tmp_path / "alone.mcap")
    os.utime(tmp_path / "alone.mcap", (time.time(), 0))
    alone = Bag(tmp_path / "alone.mcap")
    assert (alone.message_count, alone.ros_distro) == (606, "kilted")
