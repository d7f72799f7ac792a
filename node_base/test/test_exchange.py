"""Topics in memory: every reader gets every message, in the order of publishing; others get what they are to see."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from heave_node.interface import topics
from heave_node.interface.topic import Topic
from heave_node.ros.transport import exchange as module
from heave_node.ros.transport.exchange import Exchange, LocalPublisher
from heave_node.tick.protocol import Part
from heave_node.tick.tick import stamp_of
from rclpy.serialization import deserialize_message
from rosgraph_msgs.msg import Clock


def make_publisher(exchange: Exchange, topic: Topic) -> tuple[LocalPublisher, list[bytes]]:
    """Return a publisher and the messages that others get."""
    outside: list[bytes] = []
    name = f"/{topic.name}"
    stands_in: Any = SimpleNamespace(topic_name=name, publish=outside.append, get_subscription_count=lambda: 1)
    return exchange.add_publisher(topic, stands_in, "own"), outside


def test_readers_get_messages_in_the_order_of_publishing_also_those_published_while_one_reads():
    exchange = Exchange(is_public=False)
    first, _ = make_publisher(exchange, topics.BOOM_TIP)
    second, _ = make_publisher(exchange, topics.WINCH_STATE)
    heard: list[tuple[str, bytes]] = []

    def answer(data: bytes, identity: str, sent: int) -> None:
        assert sent > 0
        assert identity == "own"
        heard.append(("answering", data))
        second.publish(b"answer to " + data)

    exchange.subscribe("/boom_tip", answer)
    exchange.subscribe("/boom_tip", lambda data, *_: heard.append(("beside it", data)))
    exchange.subscribe("/winch/state", lambda data, *_: heard.append(("winch", data)))
    assert not exchange.wake.done()
    first.publish(b"1")
    first.publish(b"2")
    assert (heard, exchange.wake.done()) == ([], True)
    exchange.deliver(10.0)
    assert heard == [
        *(("answering", b"1"), ("beside it", b"1"), ("answering", b"2"), ("beside it", b"2")),
        *(("winch", b"answer to 1"), ("winch", b"answer to 2")),
    ]
    assert not exchange.wake.done()


def test_a_delivery_ends_with_its_time_and_what_is_left_waits():
    exchange = Exchange(is_public=False)
    publisher, _ = make_publisher(exchange, topics.BOOM_TIP)
    heard = []
    exchange.subscribe("/boom_tip", lambda data, *_: heard.append(data))
    publisher.publish(b"1")
    exchange.deliver(0.0)
    assert (heard, exchange.wake.done()) == ([], True)
    exchange.deliver(10.0)
    assert heard == [b"1"]


def test_who_publishes_and_who_reads_is_counted():
    exchange = Exchange(is_public=False)
    publisher, _ = make_publisher(exchange, topics.BOOM_TIP)
    subscription = exchange.subscribe("/boom_tip", lambda *_: None)
    exchange.subscribe("/winch/state", lambda *_: None)
    assert (publisher.get_subscription_count(), subscription.get_publisher_count()) == (2, 1), "one is outside"


@pytest.mark.parametrize(
    ("topic", "is_public", "expected"),
    [
        (topics.CABLE_STATE, False, [b"0", b"4"]),
        (topics.CABLE_STATE, True, [b"0", b"1", b"2", b"3", b"4"]),
        (topics.DIAGNOSTICS, False, [b"0", b"1", b"2", b"3", b"4"]),
        (topics.SEA_STATE, False, [b"0", b"1", b"2", b"3", b"4"]),
    ],
)
def test_others_get_every_message_or_a_glance(monkeypatch, topic, is_public, expected):
    now = [100.0]
    monkeypatch.setattr(module, "time", SimpleNamespace(monotonic=lambda: now[0], time_ns=lambda: 1))
    publisher, outside = make_publisher(Exchange(is_public=is_public), topic)
    for number in range(5):
        publisher.publish(b"%d" % number)
        now[0] += 0.3 * module.GLANCE
    assert outside == expected


def test_nothing_is_shown_where_nobody_looks():
    publisher, outside = make_publisher(Exchange(is_public=False), topics.CABLE_STATE)
    publisher._outside.get_subscription_count = lambda: 0
    publisher.publish(b"unseen")
    assert outside == []


def test_a_part_of_a_tick_comes_as_it_is_and_goes_out_as_bytes():
    exchange = Exchange(is_public=True)
    publisher, outside = make_publisher(exchange, topics.TICK_LEAD)
    heard: list[Part] = []
    exchange.subscribe("/_tick/lead", lambda part, *_: heard.append(part))
    part = Part(tick=3, epoch=1, published=(4, 5), messages=[(1, b"message")])
    publisher.publish(part)
    exchange.deliver(10.0)
    assert heard == [part]
    assert Part.of(outside[0]) == part


def test_a_message_of_ros_is_serialised_once_for_all():
    exchange = Exchange(is_public=True)
    publisher, outside = make_publisher(exchange, topics.CLOCK)
    heard: list[bytes] = []
    exchange.subscribe("/clock", lambda data, *_: heard.append(data))
    publisher.publish(Clock(clock=stamp_of(7)))
    exchange.deliver(10.0)
    assert heard == outside
    assert deserialize_message(heard[0], Clock).clock.nanosec == 7
