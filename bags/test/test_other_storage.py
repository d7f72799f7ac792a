"""Bags of SQLite and of ROS 1, written by rosbags, are read as those of MCAP are; what cannot be read is one line."""

import math
import sqlite3

import numpy as np
import pytest
from heave_bags import Bag, BagError
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Ros2Writer
from rosbags.typesys import Stores, get_typestore

FLOAT, TOPIC = "std_msgs/msg/Float64", "/mru/heave"
TIMES = 1_750_000_000_000_000_000 + 100_000_000 * np.arange(50)
VALUES = np.array([math.sin(0.3 * number) for number in range(50)])


def sqlite_bag(folder, unknown=""):
    """Write the messages, and none of a topic of an `unknown` type, to a bag without definitions."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    with Ros2Writer(folder, version=8, storage_plugin=StoragePlugin.SQLITE3) as writer:
        connection = writer.add_connection(TOPIC, FLOAT, typestore=store)
        if unknown:
            writer.add_connection("/other", unknown, msgdef="float64 data", rihs01="RIHS01_" + 64 * "0")
        for time, value in zip(TIMES, VALUES, strict=True):
            writer.write(connection, int(time), store.serialize_cdr(store.types[FLOAT](data=value), FLOAT))
    with sqlite3.connect(next(folder.glob("*.db3"))) as base:
        base.execute("DELETE FROM message_definitions")
    return folder


def ros1_bag(file):
    store = get_typestore(Stores.ROS1_NOETIC)
    with Ros1Writer(file) as writer:
        connection = writer.add_connection(TOPIC, FLOAT, typestore=store)
        for time, value in zip(TIMES, VALUES, strict=True):
            writer.write(connection, int(time), store.serialize_ros1(store.types[FLOAT](data=value), FLOAT))
    return file


@pytest.mark.parametrize("kind", ["folder", "file", "ROS 1"])
def test_a_bag_of_another_storage_is_read_and_says_so(tmp_path, kind):
    path = ros1_bag(tmp_path / "one.bag") if kind == "ROS 1" else sqlite_bag(tmp_path / "one")
    if kind == "file":
        path = next(path.glob("*.db3"))
    bag = Bag(path)
    frame = bag.frame(TOPIC)
    np.testing.assert_array_equal(frame["data"].to_numpy(), VALUES)
    assert (bag.start_time, bag.end_time, bag.message_count) == (TIMES[0], TIMES[-1], len(TIMES))
    assert bag.losses == []
    assert any("was copied to MCAP" in note for note in bag.notes)


def test_types_that_nobody_knows_are_named_and_the_others_are_read(tmp_path):
    bag = Bag(sqlite_bag(tmp_path / "one", "acme_msgs/msg/Other"))
    assert list(bag.topics) == [TOPIC]
    assert any("acme_msgs/msg/Other" in note for note in bag.notes)


@pytest.mark.parametrize("begins", [b"SQLite format 3\x00" + bytes(4000), b"#ROSBAG V2.0\n" + bytes(4000)])
def test_a_broken_one_is_one_line_with_the_way_out(tmp_path, begins):
    file = tmp_path / ("one.db3" if begins.startswith(b"SQL") else "one.bag")
    file.write_bytes(begins)
    with pytest.raises(BagError, match=r"cannot be read .* rosbags-convert") as found:
        Bag(file).message_count  # noqa: B018 - read
    assert ("ros2 bag" in str(found.value)) == (file.suffix == ".db3"), "which does not read ROS 1"
