"""A controller in lockstep, written from docs/contract.md alone: it knows rclpy and heave_msgs, not the suite.

It holds the load by `payout_rate` = heave rate, and takes part in each tick by the protocol for other languages.
"""

import rclpy
from heave_msgs.msg import MruSample, TickDone, TickJoin, TickRoster, TickStart, TickStatus, WinchCommand, WinchState
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile

NAME = "winch_controller"
INPUTS = {"/mru": MruSample, "/winch/state": WinchState}
OUTPUT = "/winch/command"
BEFORE = "wave_vessel"  # acts before the controller
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Controller(Node):
    def __init__(self) -> None:
        super().__init__(NAME)
        self.entries: list[tuple[str, str]] = []
        self.received: dict[str, list] = {topic: [] for topic in INPUTS}
        self.start = self.done_before = None
        self.answered, self.sent, self.is_over = 0, [], False
        self.command = self.create_publisher(WinchCommand, OUTPUT, 200)
        self.done = self.create_publisher(TickDone, f"/_tick/done/{NAME}", 200)
        self.joins = self.create_publisher(TickJoin, "/_tick/join", 200)
        self.readers = [
            self.create_subscription(kind, topic, lambda message, topic=topic: self.hear(topic, message), 200)
            for topic, kind in INPUTS.items()
        ]
        self.create_subscription(TickRoster, "/_tick/roster", self.on_roster, LATCHED)
        self.create_subscription(TickStatus, "/_tick/status", self.on_status, LATCHED)
        self.create_subscription(TickStart, "/_tick/start", self.on_start, 200)
        self.create_subscription(TickDone, f"/_tick/done/{BEFORE}", self.on_done_before, 200)
        self.timer = self.create_timer(0.05, self.join)

    def join(self) -> None:
        own = [info for info in self.get_publishers_info_by_topic(OUTPUT) if info.node_name == NAME]
        identity = bytes(own[0].endpoint_gid)[:12].hex() if own else ""
        self.joins.publish(
            TickJoin(
                node=NAME,
                identity=identity,
                ready=bool(identity),
                after=[BEFORE],
                outputs=[OUTPUT],
                matched_subscriptions=[self.command.get_subscription_count()],
                inputs=list(INPUTS),
                matched_publishers=[self.count_publishers(topic) for topic in INPUTS],
            )
        )

    def on_roster(self, message: TickRoster) -> None:
        self.entries = list(zip(message.nodes, message.topics, strict=True))
        self.timer.cancel()

    def on_status(self, message: TickStatus) -> None:
        self.is_over = bool(self.entries) and message.state >= TickStatus.ENDED

    def on_start(self, message: TickStart) -> None:
        if message.tick == self.answered:
            for publisher, sent in self.sent:
                publisher.publish(sent)
        self.start = message
        self.try_to_answer()

    def on_done_before(self, message: TickDone) -> None:
        self.done_before = message
        self.try_to_answer()

    def hear(self, topic: str, message: object) -> None:
        if message not in self.received[topic][-5:]:
            self.received[topic].append(message)
        self.try_to_answer()

    def has_all(self) -> bool:
        """Return whether every message is here that start and answer before count."""
        if self.done_before is None or self.done_before.tick < self.start.tick:
            return self.start.flush
        of_before = [topic for node, topic in self.entries if node == BEFORE]
        counted = dict(zip(of_before, self.done_before.published, strict=True))
        for (_, topic), count in zip(self.entries, self.start.published, strict=True):
            if topic in INPUTS and len(self.received[topic]) < max(count, counted.get(topic, 0)):
                return False
        return True

    def try_to_answer(self) -> None:
        start = self.start
        if start is None or start.tick <= self.answered or not self.entries or not self.has_all():
            return
        self.sent = []
        if not start.flush:
            newest = self.received["/mru"][-1] if self.received["/mru"] else MruSample()
            command = WinchCommand(sequence=start.tick, payout=newest.heave, payout_rate=newest.heave_rate)
            command.header.stamp = start.stamp
            self.sent.append((self.command, command))
        published = start.tick - start.flush
        self.sent.append((self.done, TickDone(epoch=start.epoch, tick=start.tick, published=[published])))
        self.answered = start.tick
        for publisher, message in self.sent:
            publisher.publish(message)


rclpy.init()
node = Controller()
while not node.is_over:
    rclpy.spin_once(node, timeout_sec=0.1)
