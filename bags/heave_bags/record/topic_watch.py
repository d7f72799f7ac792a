"""Finds every topic that appears and subscribes to it, raw, with a quality of service that its publishers can meet."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fnmatch import fnmatch
from typing import Any

from heave_node.interface.messages import message_type
from rclpy.node import Node
from rclpy.subscription import Subscription

from heave_bags.mcap.ros.qos import OfferedQos
from heave_bags.mcap.ros.ros_qos import offered_qos, request_for


def is_hidden(topic: str) -> bool:
    """Return whether a topic is hidden: a token of its name begins with an underscore."""
    return any(token.startswith("_") for token in topic.split("/"))


class TopicWatch:
    """Looks for topics in the graph of a `node` each time `look` is called, but for hidden ones and those whose names
    fit patterns to `exclude`.
    """

    def __init__(self, node: Node, exclude: Sequence[str]) -> None:
        self._node = node
        self._exclude = tuple(exclude)
        self._subscriptions: dict[str, Subscription[Any]] = {}
        self._requests: dict[str, tuple[Any, Any]] = {}
        self.types: dict[str, str] = {}
        self.offers: dict[str, tuple[OfferedQos, ...]] = {}
        self.unreadable: dict[str, str] = {}

    def look(self) -> list[str]:
        """Return the names of topics that have appeared since the last look and can be recorded."""
        found = []
        for name, types in self._node.get_topic_names_and_types():
            if is_hidden(name) or any(fnmatch(name, pattern) for pattern in self._exclude):
                continue
            offers = self._offers(name)
            if not offers:
                continue
            self.offers[name] = offers
            if name not in self.types and self._is_readable(name, types):
                self.types[name] = types[0]
                found.append(name)
        return found

    def _offers(self, topic: str) -> tuple[OfferedQos, ...]:
        infos = self._node.get_publishers_info_by_topic(topic)
        unique = dict.fromkeys(offered_qos(info.qos_profile) for info in infos)
        return tuple(sorted(unique, key=repr))

    def _is_readable(self, topic: str, types: Sequence[str]) -> bool:
        """Return whether messages of a topic can be taken; why not is noted."""
        if len(types) != 1:
            self.unreadable[topic] = f"{topic} has several types: {', '.join(types)}"
            return False
        try:
            message_type(types[0])
        except (ImportError, AttributeError, ValueError):
            self.unreadable[topic] = f"{topic}: the package of {types[0]} is not installed here"
            return False
        self.unreadable.pop(topic, None)
        return True

    def subscribe(self, topic: str, callback: Callable[..., None]) -> Subscription[Any]:
        """Subscribe to a topic that `look` has found; call again when its offers change.

        Without a callback for the middleware's "message lost" event: under load it deadlocks with the events executor.
        """
        request = request_for(self.offers[topic])
        self._requests[topic] = (request.reliability, request.durability)
        subscription = self._node.create_subscription(
            message_type(self.types[topic]), topic, callback, request, raw=True
        )
        self._subscriptions[topic] = subscription
        return subscription

    def outdated(self) -> list[str]:
        """Return subscribed topics whose publishers now offer something other than was requested."""
        changed = []
        for topic, asked in self._requests.items():
            request = request_for(self.offers[topic])
            if (request.reliability, request.durability) != asked:
                changed.append(topic)
        return changed

    def unsubscribe(self, topic: str) -> None:
        """Drop the subscription of a topic."""
        self._requests.pop(topic, None)
        subscription = self._subscriptions.pop(topic, None)
        if subscription is not None:
            self._node.destroy_subscription(subscription)
