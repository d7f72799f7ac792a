"""A bag is what others expect, and reads back as it was written."""

import math
from pathlib import Path

import numpy as np
import pytest
import yaml
from heave_bags.cdr.canonical import Canonical
from heave_bags.errors import BagError
from heave_bags.mcap.bag_writer import BagPolicy, BagWriter
from heave_bags.mcap.reader import Bag, summary_of
from heave_bags.mcap.ros.qos import OfferedQos, from_yaml, to_yaml
from heave_bags.mcap.writer import ChunkPolicy
from heave_node.cdr.definitions import DefinitionError, schema_text, type_hash
from made_up_run import TYPES, MadeUpRun, tick_messages, write_run
from mcap_ros2.reader import read_ros2_messages
from rclpy.serialization import serialize_message
from rosbags.highlevel import AnyReader


def test_every_message_comes_back_byte_for_byte_in_order_and_at_its_time(made_up_bag):
    run = MadeUpRun(duration=5.0)
    clean = {topic: Canonical(kind, schema_text(kind)) for topic, kind in TYPES.items()}
    written = [
        (topic, number * 50_000_000, clean[topic](bytes(serialize_message(message))))
        for number in range(1, 101)
        for topic, message in tick_messages(run, number * 50_000_000).items()
    ]
    read = [(m.topic, m.log_time, m.data) for m in Bag(made_up_bag(run=run)).messages() if m.topic != "/sea_state"]
    assert read == written


@pytest.mark.parametrize("compression", ["zstd", "lz4", ""])
def test_other_readers_decode_every_message_and_agree_with_metadata_yaml(made_up_bag, compression):
    folder = made_up_bag(policy=BagPolicy(ChunkPolicy(size=20_000, compression=compression)))
    information = yaml.safe_load((folder / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    said = {
        entry["topic_metadata"]["name"]: entry["message_count"] for entry in information["topics_with_message_count"]
    }
    counts = dict.fromkeys(said, 0)
    with AnyReader([folder]) as reader:
        assert reader.message_count == information["message_count"]
        assert reader.duration == information["duration"]["nanoseconds"] + 1  # rosbags counts the last nanosecond
        for connection, _, data in reader.messages():
            reader.deserialize(data, connection.msgtype)
            counts[connection.topic] += 1
    assert counts == said
    decoded = sum(1 for path in folder.glob("*.mcap") for _ in read_ros2_messages(str(path)))
    assert decoded == information["message_count"]


def test_a_split_bag_reads_as_one_and_each_file_stands_alone(made_up_bag):
    whole = made_up_bag("whole")
    split = made_up_bag("split", policy=BagPolicy(ChunkPolicy(size=20_000), max_file_span=7_000_000_000))
    files = sorted(split.glob("*.mcap"))
    assert len(files) == 9  # 60 s in files of 7 s
    assert [m[:4] for m in Bag(split).messages()] == [m[:4] for m in Bag(whole).messages()]
    alone = Bag(files[4])
    assert alone.run["scenario"] == "made_up"
    assert sum(1 for _ in alone.decoded()) == alone.message_count
    assert {m.topic for m in alone.messages()} <= set(TYPES)


def test_a_bag_splits_by_size(made_up_bag):
    folder = made_up_bag(policy=BagPolicy(ChunkPolicy(size=10_000), max_file_bytes=50_000))
    sizes = [path.stat().st_size for path in folder.glob("*.mcap")]
    assert len(sizes) > 3
    assert max(sizes) < 50_000 + 30_000  # one chunk and the summary may come on top


def test_the_same_messages_give_the_same_file(tmp_path):
    for name in ("one/bag", "two/bag"):
        write_run(tmp_path / name, MadeUpRun(duration=10.0))
    one, two = (tmp_path / name / "bag_0.mcap" for name in ("one/bag", "two/bag"))
    assert one.read_bytes() == two.read_bytes()


def test_an_existing_folder_is_never_written_into(made_up_bag):
    folder = made_up_bag()
    with pytest.raises(BagError, match="exists already"):
        BagWriter(folder)


def test_a_topic_that_was_not_added_is_refused(tmp_path):
    writer = BagWriter(tmp_path / "bag")
    with pytest.raises(BagError, match="/nobody was not added"):
        writer.write("/nobody", 1, b"")


def test_a_topic_without_messages_is_in_the_bag(tmp_path):
    writer = BagWriter(tmp_path / "bag")
    writer.add_topic("/quiet", "sensor_msgs/msg/Imu")
    writer.close()
    assert Bag(tmp_path / "bag").topics["/quiet"].message_count == 0


def test_the_bag_says_what_it_is(shared_bag):
    bag = Bag(shared_bag)
    assert bag.run["seed"] == "7"
    assert bag.outcome["ended"] == "complete"
    assert b"boom_tip_source: regular" in bag.attachments["scenario.yaml"]
    assert bag.topics["/sea_state"].qos[0].durability == "transient_local"
    assert bag.topics["/winch/state"].type_hash.startswith("RIHS01_")


def test_metadata_yaml_can_be_made_again_from_the_files(shared_bag):
    assert summary_of(Bag(shared_bag)).to_yaml() == (shared_bag / "metadata.yaml").read_text()


def test_a_schema_holds_every_type_it_needs_once():
    text = schema_text("nav_msgs/msg/Odometry")
    parts = [line[5:] for line in text.splitlines() if line.startswith("MSG: ")]
    assert sorted(parts) == sorted(set(parts))
    assert {
        "std_msgs/Header",
        "builtin_interfaces/Time",
        "geometry_msgs/PoseWithCovariance",
        "geometry_msgs/Point",
    } <= set(parts)
    assert type_hash("std_msgs/msg/Header").startswith("RIHS01_")


def test_a_type_nobody_has_installed_is_named():
    with pytest.raises(DefinitionError, match="other_msgs/Thing"):
        schema_text("other_msgs/msg/Thing")


def test_a_topic_of_unknown_type_is_recorded_all_the_same(tmp_path):
    writer = BagWriter(tmp_path / "bag")
    assert "without its definition" in writer.add_topic("/odd", "other_msgs/msg/Thing")
    writer.write("/odd", 5, b"\x00\x01\x00\x00abcd")
    writer.close()
    bag = Bag(tmp_path / "bag")
    assert [m.data for m in bag.messages()] == [b"\x00\x01\x00\x00abcd"]
    with pytest.raises(BagError, match="without its definition"):
        bag.frame("/odd")


def test_quality_of_service_survives_the_round_trip():
    profiles = (
        OfferedQos(reliability="best_effort", depth=3),
        OfferedQos(deadline=50_000_000, durability="transient_local"),
    )
    assert from_yaml(to_yaml(profiles)) == profiles


def test_quality_of_service_of_old_bags_is_understood():
    (old,) = from_yaml("- {history: 3, depth: 0, reliability: 2, durability: 1, deadline: {sec: 0, nsec: 0}}")
    assert (old.reliability, old.durability, old.history) == ("best_effort", "transient_local", "keep_last")


def test_a_frame_has_the_values_and_the_stamps(shared_bag):
    frame = Bag(shared_bag).frame("unit/odometry")
    run = MadeUpRun()
    assert frame.index.name == "time"
    expected = -300.0 + run.unit * np.sin(run.omega * frame.index.to_numpy())
    assert np.allclose(frame["pose.pose.position.z"], expected, atol=1e-12)
    assert "pose.covariance[0]" not in frame
    assert "pose.covariance[0]" in Bag(shared_bag).frame("unit/odometry", ["pose.covariance"])


def test_columns_agree_with_the_decoder_of_others_for_texts_and_sequences_of_any_length(shared_bag):
    bag = Bag(shared_bag)
    columns = bag.columns({"controller/state": None, "cable/state": None})
    state, cable = columns["controller/state"], columns["cable/state"]
    for row, (_, message) in enumerate(bag.decoded(["controller/state"])):
        assert state["mode"][row] == message.mode
        assert state["reason"][row] == message.reason
        assert state["measurement_names[1]"][row] == message.measurement_names[1]
        assert np.array_equal(state["innovation"][row], message.innovation, equal_nan=True)
        assert state["sensors[0].level"][row] == message.sensors[0].level
    for row, (_, message) in enumerate(bag.decoded(["cable/state"])):
        assert [cable[f"nodes[{i}].z"][row] for i in range(5)] == [node.z for node in message.nodes]
        assert cable["segment_tension"][row].tolist() == list(message.segment_tension)


def test_arrays_that_grow_are_padded_with_nan(tmp_path):
    from heave_msgs.msg import CableState  # noqa: PLC0415

    writer = BagWriter(tmp_path / "bag")
    writer.add_topic("/cable/state", "heave_msgs/msg/CableState")
    for number, length in enumerate((2, 0, 3), start=1):
        message = CableState(segment_tension=[float(number)] * length)
        writer.write("/cable/state", number, bytes(serialize_message(message)))
    writer.close()
    tension = Bag(tmp_path / "bag").columns({"cable/state": ["segment_tension"]})["cable/state"]["segment_tension"]
    assert np.array_equal(tension, [[1, 1, math.nan], [math.nan] * 3, [3, 3, 3]], equal_nan=True)


def test_a_time_window_selects_by_log_time(shared_bag):
    times = [m.log_time for m in Bag(shared_bag).messages(["boom_tip"], start=10_000_000_000, end=11_000_000_000)]
    assert (times[0], times[-1], len(times)) == (10_000_000_000, 11_000_000_000, 21)


def test_a_wrong_topic_is_answered_with_those_there_are(shared_bag):
    with pytest.raises(BagError, match="no topic unit/odometri; it has /boom_tip"):
        Bag(shared_bag).frame("unit/odometri")


def test_what_is_no_bag_is_refused_in_one_line(tmp_path):
    with pytest.raises(BagError, match="no such bag"):
        Bag(tmp_path / "nothing")
    (tmp_path / "empty").mkdir()
    with pytest.raises(BagError, match="holds no MCAP file"):
        Bag(tmp_path / "empty")
    text = tmp_path / "text.mcap"
    text.write_text("not a bag at all")
    with pytest.raises(BagError, match="a text file, not an MCAP file; give the folder of a bag"):
        list(Bag(Path(text)).messages())
