"""What stands in for a ROS node where a device is tested by itself."""

from types import SimpleNamespace


class Node:
    """Keeps what is published."""

    def __init__(self):
        self.callbacks, self.sent = {}, {}
        self.others, self.said = set(), []

    def create_subscription(self, kind, topic, callback, _):
        del kind
        self.callbacks[topic] = callback

    def create_publisher(self, kind, topic, _):
        del kind
        self.sent[topic] = []
        return SimpleNamespace(publish=self.sent[topic].append)

    def destroy_publisher(self, publisher):
        topic = next(name for name, sent in self.sent.items() if sent is publisher.publish.__self__)
        del self.sent[topic]

    def count_publishers(self, topic):
        return (topic in self.sent) + (topic in self.others)

    def get_logger(self):
        return SimpleNamespace(info=self.said.append)
