"""What is played, and when."""

import pytest
from bags_of_others import TOPIC, samples, write_mcap, write_split
from foreign_bags import by_host_clock, write_foreign
from heave_bags.errors import BagError
from heave_bags.mcap.bag_writer import BagWriter
from heave_bags.mcap.reader import Bag, RawMessage
from heave_bags.play.playback import (
    AT_ONCE,
    LAST_TIME,
    Playback,
    PlaybackOptions,
    in_order_of,
    publisher_of,
    selected_topics,
)
from heave_bags.play.tick_player import TickPlayer
from made_up_run import MadeUpRun, write_run

PERIOD = 50_000_000


def play(bag: Bag, *, until: float = 1e9, period: float = 0.01, **options) -> list[tuple[float, RawMessage]]:
    """Play a bag against a clock that is advanced by hand; return wall times and messages."""
    playback = Playback(bag, PlaybackOptions(**options))
    wall, played = 0.0, []
    while not playback.finished and wall < until:
        played += [(wall, message) for message in playback.due(wall)]
        wall += period
    return played


@pytest.fixture
def bag(shared_bag):
    return Bag(shared_bag)


def test_every_message_is_played_once_in_order(bag):
    assert [message for _, message in play(bag, period=1.0)] == list(bag.messages())


@pytest.mark.parametrize("rate", [0.5, 1.0, 4.0])
def test_a_message_is_played_when_it_is_due_at_the_rate(bag, rate):
    for wall, message in play(bag, rate=rate, duration=5.0):
        due = (message.log_time - bag.start_time) * 1e-9 / rate
        assert due <= wall + 1e-9
        assert wall < due + 0.0101


def test_start_and_duration_choose_a_part(bag):
    times = [message.log_time for _, message in play(bag, start=10.0, duration=2.0)]
    assert times[0] == bag.start_time + 10_000_000_000
    assert times[-1] == bag.start_time + 12_000_000_000


def test_what_the_bag_lost_and_its_order_are_said_after_it_was_played(tmp_path):
    write_split(tmp_path / "bag", ("bag_0.mcap", "bag_1.mcap"))
    (tmp_path / "bag" / "bag_1.mcap").write_bytes(b"")
    write_mcap(tmp_path / "a.mcap", [*samples(50, 50), *samples(50)])
    for name, word in (("bag", "bag_1.mcap: the file is empty"), ("a.mcap", "are not in the order of their log times")):
        playback = Playback(Bag(tmp_path / name), PlaybackOptions(topics=[TOPIC]))
        playback.due(0.0)
        while not playback.finished:
            playback.step(1000)
        (remark,) = playback.remarks
        assert word in remark


def test_what_the_bag_lost_is_said_of_a_pass_that_was_broken_off(tmp_path):
    write_split(tmp_path / "bag", ("bag_0.mcap", "bag_1.mcap"))
    (tmp_path / "bag" / "bag_1.mcap").write_bytes(b"")
    playback = Playback(Bag(tmp_path / "bag"), PlaybackOptions())
    playback.step(3)
    assert "bag_1.mcap: the file is empty" in playback.remarks[0]


def test_what_was_latched_before_the_start_is_played_first(bag):
    playback = Playback(bag, PlaybackOptions(start=10.0))
    assert [message.topic for message in playback.latched()] == ["/sea_state"]
    assert Playback(bag, PlaybackOptions()).latched() == []


def test_a_loop_begins_again(bag):
    rounds = play(bag, loop=True, duration=1.0, topics=["boom_tip"], until=3.5)
    times = [message.log_time for _, message in rounds]
    assert times[:21] * 3 == times[:63]


def test_paused_nothing_is_played_and_no_time_is_caught_up_afterwards(bag):
    playback = Playback(bag, PlaybackOptions(topics=["boom_tip"]))
    playback.due(0.0)
    playback.due(1.0)
    playback.paused = True
    assert playback.due(50.0) == []
    playback.paused = False
    assert len(playback.due(50.5)) == 10


def test_a_step_plays_the_next_messages_at_once(bag):
    playback = Playback(bag, PlaybackOptions(paused=True))
    stepped = playback.step(3)
    assert stepped == list(bag.messages())[:3]
    assert playback.step(2) == list(bag.messages())[3:5]


def test_topics_and_nodes_select(bag):
    assert selected_topics(bag, PlaybackOptions(topics=["/unit*"])) == ["/unit/odometry", "/unit_uncompensated"]
    assert selected_topics(bag, PlaybackOptions(nodes=["virtual_winch"])) == ["/winch/state"]
    assert "/boom_tip" not in selected_topics(bag, PlaybackOptions(exclude=["boom_tip"]))
    assert publisher_of(bag, "/boom_tip") == ("wave_vessel",)


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ({"topics": ["/nothing*"]}, "no topic matches"),
        ({"nodes": ["nobody"]}, "no message in it was published by nobody"),
        ({"exclude": ["*"]}, "no topic is left"),
        ({"start": 100.0}, "is after its end"),
    ],
)
def test_a_selection_that_leaves_nothing_is_refused(bag, options, complaint):
    with pytest.raises(BagError, match=complaint):
        Playback(bag, PlaybackOptions(**options))


@pytest.mark.parametrize("options", [{"rate": 0.0}, {"rate": float("nan")}, {"start": -1.0}, {"duration": 0.0}])
def test_options_out_of_range_are_refused(options):
    with pytest.raises(BagError):
        PlaybackOptions(**options)


def test_what_is_due_at_once_is_handed_out_in_parts_that_memory_holds(made_up_bag):
    folder = made_up_bag("burst", MadeUpRun(duration=5.0))
    bag = Bag(folder)
    playback = Playback(bag, PlaybackOptions(rate=1e9))
    playback.due(0.0)
    parts = []
    while not playback.finished:
        parts.append(len(playback.due(1.0)))
    assert sum(parts) + 1 >= bag.message_count - 6
    assert max(parts) <= AT_ONCE


def test_large_messages_are_not_held_back_for_the_sake_of_order():
    messages = [RawMessage("/a", time, bytes(10 << 20)) for time in range(12)]
    held = 0
    taken = in_order_of((message.log_time, message) for message in messages)
    first, _ = next(taken)
    held = sum(1 for _ in taken)
    assert (first, held) == (0, 11)


def test_times_that_no_message_of_ros_can_tell_are_refused(tmp_path):
    write_run(tmp_path / "bag", MadeUpRun(duration=1.0), offset=(1 << 31) * 1_000_000_000 - 500_000_000_000)
    assert Playback(Bag(tmp_path / "bag"), PlaybackOptions()).topics
    writer = BagWriter(tmp_path / "late")
    writer.add_topic("/boom_tip", "heave_msgs/msg/PointMotion")
    writer.write("/boom_tip", LAST_TIME + 1, b"")
    writer.close()
    with pytest.raises(BagError, match="after 2038"):
        Playback(Bag(tmp_path / "late"), PlaybackOptions())


def test_messages_that_are_a_little_out_of_order_are_sorted():
    messages = [RawMessage("/a", time, b"") for time in (3, 1, 2, 5, 4)]
    assert [time for time, _ in in_order_of((message.log_time, message) for message in messages)] == [1, 2, 3, 4, 5]


def test_a_substitute_plays_each_message_of_its_node_in_the_tick_it_was_recorded_in(bag):
    player = TickPlayer(bag, "wave_vessel", PERIOD)
    assert player.topics == ["/boom_tip", "/sea_state"]
    played = [(tick, topic) for tick in range(1, 1201) for topic, _ in player.take(tick)]
    assert played == [(1, "/sea_state"), *((tick, "/boom_tip") for tick in range(1, 1201))]
    with pytest.raises(BagError, match="it ends at t = 60 s"):
        player.take(1201)


def test_a_substitute_knows_its_topics_in_any_namespace_and_refuses_several(bag, tmp_path):
    east = write_foreign(bag.path, tmp_path / "east", by_host_clock, namespace="/fleet/east")
    player = TickPlayer(Bag(east), "wave_vessel", PERIOD)
    assert player.namespace == "/fleet/east"
    assert [player.name_in_run(topic) for topic in player.topics] == ["boom_tip", "sea_state"]
    assert player.name_in_run("/fleet/east/diagnostics") == "diagnostics"
    files = [
        *east.glob("*.mcap"),
        *write_foreign(bag.path, tmp_path / "west", by_host_clock, namespace="/west").glob("*"),
    ]
    both = tmp_path / "both"
    both.mkdir()
    for number, file in enumerate(files):
        file.rename(both / f"both_{number}.mcap")
    with pytest.raises(BagError, match="it holds several systems: /west, /fleet/east"):
        TickPlayer(Bag(both), "wave_vessel", PERIOD)


def test_a_substitute_for_another_tick_or_node_is_refused(bag, made_up_bag):
    with pytest.raises(BagError, match="published by winch_controllers"):
        TickPlayer(bag, "winch_controllers", PERIOD)
