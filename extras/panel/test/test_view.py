"""What viewers of the live stream are given of a topic: a real server and its protocol, without ROS."""

import json
import struct

import pytest

foxglove = pytest.importorskip("foxglove")
from heave_panel.view.shown_topic import LOOKS_BETWEEN, ShownTopic  # noqa: E402
from websockets.sync.client import connect  # noqa: E402

SCHEMA = foxglove.Schema(name="test/msg/Number", encoding="ros2msg", data=b"float64 number")


@pytest.fixture
def viewer():
    """A connected viewer."""
    server = foxglove.start_server(name="test", host="127.0.0.1", port=0, supported_encodings=["cdr"])
    with connect(f"ws://127.0.0.1:{server.port}", subprotocols=["foxglove.sdk.v1"]) as socket:
        yield socket
    server.stop()


def next_of(socket, operation):
    while True:
        said = socket.recv(timeout=10.0)
        if isinstance(said, str) and json.loads(said)["op"] == operation:
            return json.loads(said)


def subscribe(socket, channel):
    socket.send(json.dumps({"op": "subscribe", "subscriptions": [{"id": 7, "channelId": channel["id"]}]}))


def test_a_viewer_that_was_refused_a_new_topic_is_offered_it_again_and_given_what_was_published_once(viewer):
    topic = ShownTopic("/sea_state", SCHEMA, is_latched=True, is_late=True)
    (refused,) = next_of(viewer, "advertise")["channels"]
    topic.show(b"sea", 5)
    for _ in range(LOOKS_BETWEEN):
        topic.repeat(6)
    (channel,) = next_of(viewer, "advertise")["channels"]
    assert (channel["topic"], refused["topic"]) == ("/sea_state", "/sea_state")
    assert channel["id"] != refused["id"]
    subscribe(viewer, channel)
    message = None
    while not isinstance(message, bytes):
        topic.repeat(8)
        try:
            message = viewer.recv(timeout=0.1)
        except TimeoutError:
            continue
    assert struct.unpack_from("<IQ", message, 1) == (7, 8)
    assert message[13:] == b"sea"


def test_a_topic_that_nobody_takes_is_announced_a_few_times_and_one_that_was_there_before_the_viewers_once(viewer):
    topics = [
        ShownTopic(name, SCHEMA, is_latched=False, is_late=is_late)
        for name, is_late in (("/late", True), ("/old", False))
    ]
    for _ in range(10 * LOOKS_BETWEEN):
        for topic in topics:
            topic.repeat(1)
    announced = []
    with pytest.raises(TimeoutError):
        while True:
            said = json.loads(viewer.recv(timeout=1.0))
            announced += [channel["topic"] for channel in said.get("channels", []) if said["op"] == "advertise"]
    assert sorted(name for name in announced if name in ("/late", "/old")) == ["/late", "/late", "/late", "/old"]
