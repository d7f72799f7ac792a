"""Start, stop, split and snapshots, without ROS."""

import pytest
from heave_bags.errors import BagError
from heave_bags.mcap.bag_writer import BagWriter
from heave_bags.mcap.qos import OfferedQos
from heave_bags.mcap.reader import Bag
from heave_bags.record.session import RecordingSession, SnapshotRing
from made_up_run import MadeUpRun, tick_messages
from rclpy.serialization import serialize_message

SECOND = 1_000_000_000
DATA = bytes(serialize_message(tick_messages(MadeUpRun(), 50_000_000)["/boom_tip"]))


def session(span: int = 0, limit: int = 1 << 30) -> RecordingSession:
    made = RecordingSession(BagWriter, SnapshotRing(span, limit), survive=True)
    made.add_topic("/boom_tip", "heave_msgs/msg/PointMotion", ())
    made.add_topic("/sea_state", "heave_msgs/msg/SeaState", [OfferedQos(durability="transient_local")])
    made.write("/sea_state", SECOND // 10, DATA)
    return made


def feed(made: RecordingSession, first: int, last: int) -> None:
    for number in range(first, last):
        made.write("/boom_tip", number * SECOND, DATA)


def times(folder, topic="/boom_tip"):
    return [m.log_time // SECOND for m in Bag(folder).messages([topic])]


def test_a_bag_holds_what_came_between_start_and_stop_and_the_latched_before(tmp_path):
    made = session()
    feed(made, 1, 5)
    made.start(tmp_path / "one")
    feed(made, 5, 8)
    assert made.stop() == str(tmp_path / "one")
    feed(made, 8, 10)
    assert times(tmp_path / "one") == [5, 6, 7]
    assert times(tmp_path / "one", "/sea_state") == [4]


def test_two_bags_at_once_and_none_to_stop_are_refused(tmp_path):
    made = session()
    with pytest.raises(BagError, match="nothing is being recorded"):
        made.stop()
    made.start(tmp_path / "one")
    with pytest.raises(BagError, match="stop it first"):
        made.start(tmp_path / "two")


def test_a_split_begins_the_next_file(tmp_path):
    made = session()
    made.start(tmp_path / "one")
    feed(made, 1, 3)
    made.split()
    feed(made, 3, 5)
    made.stop()
    assert [path.name for path in sorted((tmp_path / "one").glob("*.mcap"))] == ["one_0.mcap", "one_1.mcap"]
    assert times(tmp_path / "one") == [1, 2, 3, 4]


def test_a_snapshot_holds_the_last_seconds_and_the_latched_topics(tmp_path):
    made = session(span=10 * SECOND)
    feed(made, 1, 31)
    assert made.save_snapshot(tmp_path / "all") == 12
    made.save_snapshot(tmp_path / "some", 3 * SECOND)
    assert times(tmp_path / "all") == list(range(20, 31))
    assert times(tmp_path / "some") == [27, 28, 29, 30]
    assert len(times(tmp_path / "some", "/sea_state")) == 1


def test_the_past_takes_no_more_memory_than_allowed(tmp_path):
    made = session(span=1000 * SECOND, limit=20 * len(DATA))
    feed(made, 1, 200)
    assert len(made.ring) <= 20
    assert made.save_snapshot(tmp_path / "bag") <= 21


def test_a_snapshot_without_memory_is_refused(tmp_path):
    with pytest.raises(BagError, match="snapshot_duration"):
        session().save_snapshot(tmp_path / "bag")
