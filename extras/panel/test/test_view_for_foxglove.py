"""The live stream as Foxglove sees it: definitions, messages, time, and the frame of the unit."""

import json
import re
import struct
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from domain_coordinator import domain_id
from nav_msgs.msg import Odometry
from rclpy.serialization import deserialize_message
from visualization_msgs.msg import MarkerArray
from websockets.sync.client import connect

from tests.loop_runs import command, environment, wait_until

PORT = 8769
LAYOUT = Path(__file__).parents[3] / "bags" / "config" / "heave.foxglove.json"
MESSAGE = 1
"""Opcode of a message in the protocol; then come the subscription, the time and the message."""


@pytest.mark.slow
@pytest.mark.long
def test_a_client_without_ros_is_given_all_that_it_needs_of_a_run_in_a_namespace(tmp_path):
    pytest.importorskip("foxglove")
    with domain_id() as domain:
        nobody = subprocess.run(
            command("view"), env=environment(domain), capture_output=True, text=True, timeout=60, check=False
        )
        assert nobody.returncode == 2
        assert nobody.stderr.startswith(f"heave: no run and no replayed bag in ROS domain {domain}: start one with ")
        log = (tmp_path / "run.log").open("w")
        where = ["--namespace", "ship"]
        general = ["--pacing", "lockstep", "--duration", "20000", "--no-report", "--bag", str(tmp_path / "run")]
        run = subprocess.Popen(
            command("run", "b2_calm_300", *general, *where), env=environment(domain), stdout=log, stderr=log
        )
        view = None
        try:
            wait_until(lambda: " x real time" in (tmp_path / "run.log").read_text(), 180.0)
            view = subprocess.Popen(
                command("view", "--port", str(PORT), *where), env=environment(domain), stdout=subprocess.PIPE, text=True
            )
            assert f"ws://localhost:{PORT}" in view.stdout.readline()
            look_as_foxglove()
            assert run.poll() is None
        finally:
            for process in (view, run):
                if process is not None:
                    process.send_signal(2)
                    process.wait(60.0)


@pytest.mark.slow
@pytest.mark.long
def test_a_replayed_bag_is_shown_like_a_run(calm_bag):
    pytest.importorskip("foxglove")
    with domain_id() as domain:
        there = environment(domain)
        replay = subprocess.Popen(command("replay", str(calm_bag), "--loop"), env=there, stdout=subprocess.DEVNULL)
        view = None
        try:
            time.sleep(5.0)  # a view looks for four seconds by itself
            view = subprocess.Popen(command("view", "--port", str(PORT)), env=there, stdout=subprocess.PIPE, text=True)
            assert f"ws://localhost:{PORT}" in view.stdout.readline()
            look_as_foxglove()
        finally:
            for process in (view, replay):
                if process is not None:
                    process.send_signal(2)
                    process.wait(60.0)


def paths_of(node) -> Iterator[str]:
    """Give the message paths and the topics that a layout, or a `node` of it, names."""
    for name, value in node.items() if isinstance(node, dict) else enumerate(node):
        if name == "topics":
            yield from value
        elif name in ("value", "topicToRender") and isinstance(value, str):
            yield value
        elif isinstance(value, dict | list):
            yield from paths_of(value)


def look_as_foxglove():
    """Connect as Foxglove does, and check what it would be shown with the shipped layout."""
    layout = json.loads(LAYOUT.read_text())
    paths = {path for path in paths_of(layout["configById"]) if path.startswith("/")}
    assert len(paths) > 15
    topics = {path.split(".")[0] for path in paths} | {"/sea_state", "/unit_frame"}
    channels, seen = subscribe_to(topics)
    for path in paths:
        topic, *fields = path.removesuffix(".@negative").split(".")
        for field in fields:
            assert re.search(rf" {field.split('[')[0]}\b", channels[topic]["schema"]), path
    state = channels["/controller/state"]
    assert (state["encoding"], state["schemaName"]) == ("cdr", "heave_msgs/msg/ControllerState")
    assert "string mode" in state["schema"]
    assert "MSG: std_msgs/Header" in state["schema"]
    # the camera follows the unit, wherever it is: its frame is where its odometry is
    assert channels["/unit_frame"]["schemaName"] == "foxglove.FrameTransform"
    assert layout["configById"]["3D!loop"]["followTf"] == "unit"
    nanoseconds = max(seen["/unit/odometry"].keys() & seen["/unit_frame"].keys())
    assert nanoseconds < 20000e9, "the time is simulated"
    odometry = deserialize_message(seen["/unit/odometry"][nanoseconds], Odometry)
    frame = seen["/unit_frame"][nanoseconds]
    assert odometry.pose.pose.position.z < -250.0
    assert struct.pack("<d", odometry.pose.pose.position.z) in frame
    assert b"world" in frame
    assert b"unit" in frame
    (marker, *_) = deserialize_message(max(seen["/markers"].items())[1], MarkerArray).markers
    assert marker.header.frame_id == "world"


def subscribe_to(topics: set[str]) -> tuple[dict[str, dict], dict[str, dict[int, bytes]]]:
    """Return the channels, and messages of each of the `topics` by their time, once every topic has some."""
    channels: dict[str, dict] = {}
    names: dict[int, str] = {}
    seen: dict[str, dict[int, bytes]] = {topic: {} for topic in topics}
    with connect(f"ws://127.0.0.1:{PORT}", subprotocols=["foxglove.sdk.v1"], max_size=None) as socket:
        deadline = time.monotonic() + 60.0
        while not all(seen.values()) or not seen["/unit/odometry"].keys() & seen["/unit_frame"].keys():
            assert time.monotonic() < deadline, [topic for topic in topics if not seen[topic]]
            message = socket.recv(timeout=60.0)
            if isinstance(message, bytes):
                if message[0] == MESSAGE:
                    number, nanoseconds = struct.unpack_from("<IQ", message, 1)
                    seen[names[number]][nanoseconds] = message[13:]
                continue
            for channel in json.loads(message).get("channels", []):
                channels[channel["topic"]] = channel
                if channel["topic"] in topics:
                    names[channel["id"]] = channel["topic"]
                    entry = {"id": channel["id"], "channelId": channel["id"]}
                    socket.send(json.dumps({"op": "subscribe", "subscriptions": [entry]}))
    return channels, seen
