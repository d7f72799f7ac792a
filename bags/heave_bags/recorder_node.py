"""The recorder: every topic of a run into one bag, complete in lockstep.

It takes part in the tick protocol, a few ticks behind the others. In lockstep it knows by count that it has
everything of a tick, and writes
it in an order that depends on the run alone. In real time it writes what comes when it comes.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from heave_msgs.msg import TickJoin, TickRoster, TickStatus
from heave_node import topics
from heave_node.diagnostics import Health
from heave_node.node import NodeError, steady_clock
from heave_node.participant import ParticipantNode
from heave_node.process import run_node
from heave_node.tick import Tick
from heave_node.topics import Role, Topic

from heave_bags.bag_writer import BagWriter
from heave_bags.errors import BagError
from heave_bags.parameters import RecorderParameters
from heave_bags.provenance import describe_run, scenario_attachment
from heave_bags.recording import TickOrder
from heave_bags.topic_watch import TopicWatch

LOOK_PERIOD = 0.1
"""Wall time between two looks for new topics [s]."""


class RecorderNode(ParticipantNode):
    """Records a run."""

    name = "recorder"
    parameters_type = RecorderParameters
    lag = 20

    def on_build(self) -> None:
        """Open the bag and begin to look for topics."""
        self.writer = self._open_bag()
        self.watch = TopicWatch(self, self.parameters.exclude)
        self._joined: dict[str, tuple[str, ...]] = {}
        self._order: TickOrder | None = None
        self._ticked: set[str] = set()
        self._foreign: list[tuple[str, bytes]] = []
        self._tick_began = time.monotonic_ns()
        self._last_log_time = 0
        self._outcome: dict[str, str] = {}
        self._expected: dict[str, int] = {}
        self.listen(topics.TICK_JOIN, self._on_join)
        self._look()
        self.create_timer(LOOK_PERIOD, self._look, clock=steady_clock())

    def _open_bag(self) -> BagWriter:
        run = self.run
        attachments = []
        if self.parameters.scenario_file:
            attachments.append(scenario_attachment(Path(self.parameters.scenario_file)))
        description = describe_run(
            scenario=self.parameters.scenario,
            seed=run.seed,
            pacing=run.pacing,
            tick_period=run.tick_period,
            transient=run.transient,
        )
        try:
            return BagWriter(
                Path(self.parameters.directory),
                policy=self.parameters.policy(),
                run=description,
                attachments=attachments,
                ros_distro=os.environ.get("ROS_DISTRO", "kilted"),
            )
        except BagError as error:
            raise NodeError(str(error)) from error

    # Topics --------------------------------------------------------------------------------------------------------

    def _on_join(self, message: TickJoin) -> None:
        self._joined[message.node] = tuple(message.outputs)

    def _promised(self) -> set[str]:
        """Return the topics that other participants say they publish within ticks."""
        return {topic for node, outputs in self._joined.items() if node != self.name for topic in outputs}

    def is_ready(self) -> bool:
        """Tell whether every participant has named its topics and all of them are subscribed to."""
        wanted = set(self.run.participants) - set(self.run.external) - {self.name}
        clock = self.resolve_topic_name(topics.CLOCK.name)
        has_master = any(clock in outputs for outputs in self._joined.values())
        subscribed = self._promised() <= set(self._input_subscriptions)
        return self.is_active and has_master and wanted <= set(self._joined) and subscribed

    def _look(self) -> None:
        promised = self._promised()
        self.watch.look()
        for topic in self.watch.types:
            if topic in self._input_subscriptions:
                continue
            if topic in promised and not self.has_started:
                self._subscribe_ticked(topic)
            elif self._is_foreign(topic, promised):
                self._subscribe_foreign(topic)
        for topic in self.watch.outdated():
            self.watch.unsubscribe(topic)
            self._subscribe_foreign(topic)

    def _is_foreign(self, topic: str, promised: set[str]) -> bool:
        """Tell whether a topic belongs to nobody in the tick protocol; before the start that is known once all have
        joined.
        """
        return topic not in promised and topic not in self._ticked and (self.has_started or self.is_ready())

    def _add_to_bag(self, topic: str) -> None:
        problem = self.writer.add_topic(topic, self.watch.types[topic], self.watch.offers[topic])
        if problem:
            self.get_logger().warning(problem)

    def _subscribe_ticked(self, topic: str) -> None:
        self._add_to_bag(topic)
        self._ticked.add(topic)
        if not self.run.is_lockstep:
            self._input_subscriptions[topic] = self.watch.subscribe(topic, self._writer_of(topic))
            return
        latched = all(offer.durability == "transient_local" for offer in self.watch.offers[topic])
        self.add_input(Topic(topic, self.watch.types[topic], "", Role.LATCHED if latched else Role.STREAM))

    def _subscribe_foreign(self, topic: str) -> None:
        self._add_to_bag(topic)
        callback = self._keeper_of(topic) if self.run.is_lockstep else self._writer_of(topic)
        self.watch.subscribe(topic, callback)
        self._ticked.add(topic)

    def _keeper_of(self, topic: str) -> Callable[[bytes], None]:
        """Return a callback that keeps a message nobody counts for the tick in which it happens to come."""

        def keep(data: bytes) -> None:
            self._foreign.append((topic, data))

        return keep

    def _writer_of(self, topic: str) -> Callable[[bytes], None]:
        """Return a callback that writes a message at once, at the simulated time of its arrival."""

        def write(data: bytes) -> None:
            self.guard(lambda: self.writer.write(topic, self._now(), data))

        return write

    def _now(self) -> int:
        """Return the simulated time [ns], interpolated by the wall clock within a tick; it never goes back."""
        if self.tick is None:
            return self._last_log_time
        elapsed = min(time.monotonic_ns() - self._tick_began, self.tick.period_nanoseconds - 1)
        self._last_log_time = max(self._last_log_time, self.tick.start_nanoseconds + elapsed)
        return self._last_log_time

    # Ticks ---------------------------------------------------------------------------------------------------------

    def _on_roster(self, message: TickRoster) -> None:
        publishers: dict[str, set[str]] = {}
        for node, topic in zip(message.nodes, message.topics, strict=True):
            if node != self.name:
                publishers.setdefault(topic, set()).add(node)
        clock = self.resolve_topic_name(topics.CLOCK.name)
        (master,) = publishers[clock]
        recorded = {topic: nodes for topic, nodes in publishers.items() if topic in self.gate.inboxes}
        self._order = TickOrder(recorded, master)
        super()._on_roster(message)

    def on_tick(self, tick: Tick) -> None:
        """Write what has become complete."""
        self._tick_began = time.monotonic_ns()
        if self.run.is_lockstep:
            self._write_complete(tick)

    def on_flush(self, tick: Tick) -> None:
        """Write the messages of the last tick."""
        if self.run.is_lockstep:
            self._write_complete(tick)

    def _write_complete(self, tick: Tick) -> None:
        assert self._order is not None
        before = max(tick.start_nanoseconds - tick.period_nanoseconds, tick.period_nanoseconds)
        self._order.write(self.writer, self.gate.take, tick_start=tick.start_nanoseconds, tick_before=before)
        self._last_log_time = tick.start_nanoseconds
        for topic, data in self._foreign:
            self.writer.write(topic, self._last_log_time, data)
        self._foreign.clear()

    def on_reset(self) -> None:
        """A run that begins anew goes on in the same bag, in a file of its own."""
        self.writer.split()

    def publish_diagnostics(self, tick: Tick) -> None:
        """Say how recording goes, in real time only: in lockstep it would tell of the machine, not of the run."""
        if not self.run.is_lockstep:
            super().publish_diagnostics(tick)

    def diagnose(self) -> list[Health]:
        """Tell what is recorded and what cannot be."""
        return [Health("recording")]

    # End -----------------------------------------------------------------------------------------------------------

    def on_end(self, status: TickStatus) -> None:
        """Note how the run went, and compare what is in the bag with what the nodes say they published."""
        self._outcome = {
            "ended": "complete" if status.state == TickStatus.ENDED else status.reason or "failed",
            "ticks": str(status.tick),
            "real_time_factor": repr(status.real_time_factor),
            "loop_age_p50_s": repr(status.loop_age_p50),
            "loop_age_p99_s": repr(status.loop_age_p99),
            "loop_age_max_s": repr(status.loop_age_max),
            "missed_deadlines": str(status.missed_deadlines),
            "resends": str(status.resends),
        }
        self._expected = dict(zip(status.topics, status.published, strict=True))

    def on_leave(self) -> None:
        """Write what is left and close the bag, however the run ended."""
        writer: Any = getattr(self, "writer", None)
        if writer is None or writer.closed:
            return
        if self._order is not None and self.run.is_lockstep:
            self._order.write_rest(writer, self._take_everything, tick_start=self._last_log_time)
        lost = self._lost()
        outcome = {
            "ended": self.failure or "the recorder was stopped",
            **self._outcome,
            "ended_at_host_time_ns": str(time.time_ns()),
            "host_time_minus_log_time_ns": str(time.time_ns() - self._last_log_time),
            **({"lost": lost} if lost else {}),
        }
        writer.close(outcome)
        if lost and not self.failure:
            raise NodeError(f"messages were lost: {lost}")

    def _take_everything(self, topic: str) -> list[bytes]:
        inbox = self.gate.inboxes[topic]
        return inbox.take(inbox.received)

    def _lost(self) -> str:
        """Say which topics hold fewer messages than were published; "" where all are there."""
        own = self.resolve_topic_name(topics.DIAGNOSTICS.name)
        counts = {topic.name: topic.message_count for topic in self.writer.summary().topics}
        lost = [
            f"{topic} {published - counts[topic]} of {published}"
            for topic, published in self._expected.items()
            if topic in counts and counts[topic] < published and topic != own
        ]
        return ", ".join(lost)


def main() -> None:
    """Run the recorder."""
    sys.exit(run_node(RecorderNode))


if __name__ == "__main__":
    main()
