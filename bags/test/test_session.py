"""Start, stop, split and snapshots, without ROS."""

from contextlib import nullcontext
from types import SimpleNamespace

import pytest
from heave_bags.errors import BagError
from heave_bags.mcap.bag_writer import BagWriter
from heave_bags.mcap.reader import Bag
from heave_bags.mcap.ros.qos import OfferedQos
from heave_bags.record.recorder_node import RecorderNode
from heave_bags.record.session import RecordingSession, SnapshotRing, missing_messages, missing_words
from heave_node.errors import NodeError
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
    with pytest.raises(BagError, match="no recording is in progress"):
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


def test_what_was_published_and_not_recorded_is_named_with_its_number():
    published = {"/mru": 100, "/boom_tip": 100, "/clock": 100, "/never_seen": 5}
    recorded = {"/mru": 100, "/boom_tip": 97, "/clock": 0}
    missing = missing_messages(published, recorded)
    assert missing == {"/boom_tip": 3, "/clock": 100}
    assert missing_words(missing, published) == "/boom_tip 3 of 100, /clock 100 of 100"
    assert missing_messages({"/mru": 100}, {"/mru": 101, "/other": 0}) == {}
    assert missing_words({}, {}) == ""


@pytest.mark.parametrize("is_lockstep", [True, False])
def test_the_recorder_of_a_run_names_what_is_missing_and_fails_where_nothing_may_be(tmp_path, is_lockstep):
    """The recorder's own shell around a session that lacks three messages, without a run."""
    logged: list[str] = []
    session = RecordingSession(BagWriter, SnapshotRing(0, 0), survive=False)
    session.add_topic("/mru", "std_msgs/msg/Float64", ())
    session.start(tmp_path / "bag")
    for number in range(7):
        session.write("/mru", number + 1, b"\x00\x01\x00\x00" + bytes(8))
    recorder = SimpleNamespace(
        session=session,
        run=SimpleNamespace(is_lockstep=is_lockstep),
        get_logger=lambda: SimpleNamespace(error=logged.append),
        parameters=SimpleNamespace(directory=str(tmp_path / "bag")),
        _order=None,
        _expected={"/mru": 10, "/diagnostics": 9},
        _diagnostics_topic="/diagnostics",
        _outcome={"ended": "complete"},
        _topic_publishers={},
        _last_log_time=7,
        failure="",
    )
    recorder._missing = lambda published: RecorderNode._missing(recorder, published)
    recorder._final_metadata = lambda lost: RecorderNode._final_metadata(recorder, lost)
    words = "messages were lost: /mru 3 of 10"
    with pytest.raises(NodeError, match=words) if is_lockstep else nullcontext():
        RecorderNode.on_exit(recorder)
    assert logged == ([] if is_lockstep else [words])
    bag = Bag(tmp_path / "bag")
    assert bag.outcome["lost"] == "/mru 3 of 10"
    assert bag.message_count == 7
    assert [loss.messages for loss in bag.losses] == [3]


def test_a_message_larger_than_a_bag_takes_is_counted_and_named_and_the_others_go_on(tmp_path, monkeypatch):
    monkeypatch.setattr("heave_bags.mcap.bag_writer.LARGEST_MESSAGE", 500)
    made = session()
    made.start(tmp_path / "bag")
    for size in (400, 600, 600, 400):
        made.write("/boom_tip", SECOND, bytes(size))
    assert (made.state.written, made.state.unwritten) == (2, 2)
    assert len(made.state.problems) == 1
    assert "600 bytes on /boom_tip is larger than a bag allows" in made.state.problems[0]
