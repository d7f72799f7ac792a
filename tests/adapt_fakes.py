"""What stands in for a ROS node where a device is tested by itself."""

from types import SimpleNamespace


class Node:
    """Keeps what is published."""

    def __init__(self):
        self.callbacks, self.sent = {}, {}
        self.others, self.said = {}, []  # nodes that publish a topic too, by topic

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
        return len(self.get_publishers_info_by_topic(topic))

    def get_publishers_info_by_topic(self, topic):
        names = ["adapter"] * (topic in self.sent) + [name for of, name in self.others.items() if of == topic]
        return [SimpleNamespace(node_name=name) for name in names]

    def get_logger(self):
        return SimpleNamespace(info=self.said.append)
