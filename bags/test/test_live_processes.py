"""Real processes: what is played is what was recorded, a recorder obeys its services, and a killed one leaves a bag."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
import rclpy
from domain_coordinator import domain_id
from heave_bags.analyse.read_run import read_run
from heave_bags.mcap.bag_writer import BagWriter
from heave_bags.mcap.files import TopicSummary
from heave_bags.mcap.reader import Bag
from heave_msgs.srv import PlaybackControl, SaveSnapshot, StartRecording
from heave_node.ros.transport.environment import prepare_environment
from made_up_run import TYPES, MadeUpRun
from rclpy.node import Node
from std_msgs.msg import String
from std_srvs.srv import Trigger

WAIT = 30.0


class Processes:
    """Starts processes in one ROS domain and ends those that are left."""

    def __init__(self, domain: int) -> None:
        self.environment = {**os.environ, "ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
        self._started: list[subprocess.Popen[str]] = []

    def start(self, module: str, *arguments: str) -> subprocess.Popen[str]:
        command = [sys.executable, "-m", f"heave_bags.{module}", *arguments]
        process = subprocess.Popen(command, env=self.environment, stderr=subprocess.PIPE, text=True)
        self._started.append(process)
        return process

    def record(self, folder: Path, *parameters: str) -> subprocess.Popen[str]:
        options = [part for name in (f"directory:={folder}", *parameters) for part in ("-p", name)]
        return self.start("record.live_recorder", "--ros-args", *options)

    def end(self) -> None:
        for process in self._started:
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
                process.wait(WAIT)


@pytest.fixture
def processes() -> Iterator[Processes]:
    """Return a starter of processes in a ROS domain of their own, which this process shares."""
    prepare_environment()
    with domain_id() as domain:
        started = Processes(domain)
        rclpy.init(domain_id=domain)
        yield started
        started.end()
        rclpy.try_shutdown()


def wait_until(what, node: Node | None = None) -> None:
    deadline = time.monotonic() + WAIT
    while not what():
        assert time.monotonic() < deadline, "this took too long"
        if node is not None:
            rclpy.spin_once(node, timeout_sec=0.05)
        else:
            time.sleep(0.05)


def call(node: Node, kind, name: str, request):
    client = node.create_client(kind, name)
    assert client.wait_for_service(WAIT)
    future = client.call_async(request)
    rclpy.spin_until_future_complete(node, future, timeout_sec=WAIT)
    return future.result()


def test_a_bag_that_is_played_and_recorded_again_is_the_same(processes, made_up_bag, tmp_path):
    original = Bag(made_up_bag(run=MadeUpRun(duration=10.0)))
    recorder = processes.record(tmp_path / "again")
    player = processes.start("play.player_node", str(original.path), "--rate", "10", "--delay", "2")
    assert player.wait(WAIT) == 0
    time.sleep(0.5)
    recorder.send_signal(signal.SIGINT)
    assert recorder.wait(WAIT) == 0
    again = Bag(tmp_path / "again")
    for topic in TYPES:
        played = [m.data for m in again.messages([topic]) if b"recorder: recording" not in m.data]
        assert played == [m.data for m in original.messages([topic])], topic
        recorded = again.topics[topic]
        assert (recorded.type, recorded.schema) == (original.topics[topic].type, original.topics[topic].schema)
        assert recorded.qos[0].durability == original.topics[topic].qos[0].durability
    assert again.topics["/clock"].message_count > 10
    assert not [note for note in read_run(again.path).notes if "end normally" in note], "Ctrl-C is how recording ends"


def test_topics_whose_types_are_not_installed_are_left_out_with_a_warning(processes, tmp_path):
    writer = BagWriter(tmp_path / "bag")
    writer.add_topic("/chatter", "std_msgs/msg/String")
    writer.add_foreign_topic(TopicSummary("/events/write_split", "rosbag2_interfaces/msg/WriteSplitEvent"), "string a")
    writer.add_foreign_topic(TopicSummary("/fly", "antigravity/msg/Fly"), "string a")
    writer.add_foreign_topic(TopicSummary("/no name", "std_msgs/msg/String"), "string data")
    for topic in ("/chatter", "/events/write_split", "/fly", "/no name"):
        writer.write(topic, 1_000_000, b"\x00\x01\x00\x00\x02\x00\x00\x00a\x00")
    writer.close()
    player = processes.start("play.player_node", str(tmp_path / "bag"), "--delay", "0")
    assert player.wait(WAIT) == 0
    said = player.stderr.read()
    assert "/events/write_split is skipped: rosbag2_interfaces/msg/WriteSplitEvent is not installed here" in said
    assert "/fly is skipped: antigravity/msg/Fly is not installed here" in said
    assert "'/no name' is not a topic name" in said
    assert "Traceback" not in said
    only = processes.start("play.player_node", str(tmp_path / "bag"), "--delay", "0", "--exclude", "/chatter")
    assert only.wait(WAIT) == 1
    assert only.stderr.read().strip().splitlines()[-1].startswith("player: ")


def test_the_player_pauses_and_steps_on_request(processes, made_up_bag):
    bag = made_up_bag(run=MadeUpRun(duration=5.0))
    player = processes.start("play.player_node", str(bag), "--paused", "--delay", "0")
    node = rclpy.create_node("asker")
    answer = call(node, PlaybackControl, "player/control", PlaybackControl.Request(paused=True, step=7))
    assert (answer.success, answer.message) == (True, "t = 0.050 s, rate 1, paused")
    refused = call(node, PlaybackControl, "player/control", PlaybackControl.Request(paused=False, rate=-1.0))
    assert not refused.success
    assert "must be above 0" in refused.message
    assert call(node, PlaybackControl, "player/control", PlaybackControl.Request(rate=100.0)).success
    assert player.wait(WAIT) == 0
    node.destroy_node()


def test_a_recorder_starts_stops_splits_and_takes_snapshots_by_service(processes, tmp_path):
    recorder = processes.record(tmp_path / "bag", "record:=false", "snapshot_duration:=60.0")
    node = rclpy.create_node("talker")
    publisher = node.create_publisher(String, "/chatter", 100)
    wait_until(lambda: publisher.get_subscription_count() > 0, node)

    def say(count: int) -> None:
        for number in range(count):
            publisher.publish(String(data=f"{number}"))
        assert publisher.wait_for_all_acked(rclpy.duration.Duration(seconds=5))
        time.sleep(0.5)

    say(3)
    assert call(node, StartRecording, "recorder/start", StartRecording.Request()).message == str(tmp_path / "bag")
    assert not call(node, StartRecording, "recorder/start", StartRecording.Request()).success
    say(5)
    assert call(node, Trigger, "recorder/split", Trigger.Request()).success
    say(7)
    assert call(node, Trigger, "recorder/stop", Trigger.Request()).success
    assert not call(node, Trigger, "recorder/stop", Trigger.Request()).success
    snapshot = call(node, SaveSnapshot, "recorder/snapshot", SaveSnapshot.Request())
    recorder.send_signal(signal.SIGINT)
    assert recorder.wait(WAIT) == 0
    node.destroy_node()
    assert [len(list(Bag(path).messages(["/chatter"]))) for path in Bag(tmp_path / "bag").files] == [5, 7]
    assert len(list(Bag(snapshot.message).messages(["/chatter"]))) == 15


def test_a_live_recorder_that_is_killed_leaves_what_it_had_acknowledged(processes, tmp_path):
    recorder = processes.record(tmp_path / "bag")
    node = rclpy.create_node("talker")
    publisher = node.create_publisher(String, "/chatter", 1000)
    wait_until(lambda: publisher.get_subscription_count() > 0, node)
    for number in range(500):
        publisher.publish(String(data=f"{number}"))
    publisher.wait_for_all_acked(rclpy.duration.Duration(seconds=5))
    time.sleep(0.8)  # some times the 0.2 s after which what has come is journalled
    recorder.kill()
    recorder.wait()
    node.destroy_node()
    bag = Bag(tmp_path / "bag")
    said = [message.data for _, message in bag.decoded(["/chatter"])]
    assert said == [f"{number}" for number in range(500)]
    assert "its writer did not finish" in str(bag.losses[0])


def test_a_recorder_that_was_stopped_for_a_while_says_what_it_missed(processes, tmp_path):
    """SIGSTOP stands for a machine that has no time for the recorder: what the middleware drops has numbers."""
    recorder = processes.record(tmp_path / "bag")
    node = rclpy.create_node("talker")
    publisher = node.create_publisher(String, "/chatter", 10)
    wait_until(lambda: publisher.get_subscription_count() > 0, node)
    sent = 0

    def say(count: int) -> None:
        nonlocal sent
        for _ in range(count):
            publisher.publish(String(data="x" * 1000))
            sent += 1
            time.sleep(0.0005)

    say(20)
    time.sleep(0.5)
    recorder.send_signal(signal.SIGSTOP)
    say(5000)
    recorder.send_signal(signal.SIGCONT)
    time.sleep(1.0)
    say(20)
    time.sleep(0.5)
    recorder.send_signal(signal.SIGINT)
    assert recorder.wait(WAIT) == 1
    assert "dropped by the middleware before the recorder took them: /chatter" in recorder.stderr.read()
    node.destroy_node()
    bag = Bag(tmp_path / "bag")
    held = bag.topics["/chatter"].message_count
    (loss,) = bag.losses
    assert held < sent
    assert held + loss.messages == sent
    assert bag.outcome["ended"] != "complete"


def test_a_recorder_that_may_not_write_says_so_in_one_line(processes, tmp_path):
    (tmp_path / "taken").mkdir()
    recorder = processes.record(tmp_path / "taken")
    assert recorder.wait(WAIT) == 1
    assert recorder.stderr is not None
    assert recorder.stderr.read().strip() == f"recorder: {tmp_path / 'taken'} exists already: a bag needs a new folder"
