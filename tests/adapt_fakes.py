"""What stands in for a ROS node where a device is tested by itself."""

from types import SimpleNamespace


class Node:
    """Keeps what is published."""

    def __init__(self):
        self.callbacks, self.sent = {}, {}

    def create_subscription(self, kind, topic, callback, _):
        del kind
        self.callbacks[topic] = callback

    def create_publisher(self, kind, topic, _):
        del kind
        self.sent[topic] = []
        return SimpleNamespace(publish=self.sent[topic].append)
