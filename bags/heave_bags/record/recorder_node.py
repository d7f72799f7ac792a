"""The recorder of a run: every topic into one bag, complete in lockstep.

It takes part in the tick protocol, a few ticks behind the others. In lockstep it knows by count that it has
everything of a tick, and writes it in an order that depends on the run alone. In real time it writes what comes when
it comes, and no disk holds it up.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path

from heave_msgs.msg import TickJoin, TickRoster, TickStatus
from heave_node.cdr.definitions import schema_text
from heave_node.errors import NodeError
from heave_node.interface import topics
from heave_node.interface.topic import Role, Topic
from heave_node.ros.diagnostics import Health
from heave_node.ros.node import steady_clock
from heave_node.ros.participant import HELD_MESSAGES, ParticipantNode
from heave_node.ros.process import run_process
from heave_node.ros.release import DISTRIBUTION
from heave_node.ros.spin import sender_callback
from heave_node.tick.gate import has_stamp
from heave_node.tick.malformed import expect_no, expect_sender, fault_in_join
from heave_node.tick.protocol import Part
from heave_node.tick.speakers import Speakers, Standing
from heave_node.tick.tick import Tick

from heave_bags.cdr.canonical import Canonical
from heave_bags.errors import BagError
from heave_bags.mcap.bag_writer import Attachment, BagWriter
from heave_bags.mcap.files import COMPLETE
from heave_bags.mcap.storage import DirectStorage, open_in_background
from heave_bags.record.parameter_survey import ParameterSurvey
from heave_bags.record.parameters import RecorderParameters
from heave_bags.record.provenance import PARAMETERS_ATTACHMENT, describe_run, scenario_attachments
from heave_bags.record.recorder_services import RecorderServices, recording_health
from heave_bags.record.recording import TickOrder
from heave_bags.record.session import RecordingSession, missing_messages, missing_words
from heave_bags.record.topic_watch import TopicWatch

LOOK_PERIOD = 0.1
"""Wall time between two looks for new topics before the run starts [s]."""
LOOK_PERIOD_IN_RUN = 1.0
"""Wall time between two looks for new topics during the run, where a look costs time that messages need [s]."""


class RecorderNode(ParticipantNode):
    """Records a run."""

    name = "recorder"
    parameters_type = RecorderParameters
    lag = 20

    def on_build(self) -> None:
        """Open the bag and begin to look for topics."""
        self.session = self._make_session()
        self.watch = TopicWatch(self, self.parameters.exclude)
        self.survey = ParameterSurvey(self)
        self._joined: dict[str, tuple[str, ...]] = {}
        self._lagging: set[str] = set()
        self._order: TickOrder | None = None
        self._taken: set[str] = set()
        self._owned = {self.resolve_topic_name(t.name): t for t in topics.ALL_TOPICS if t.publisher}
        self._speakers: dict[str, Speakers] = {}
        self._before_roster: deque[Callable[[], None]] = deque(maxlen=HELD_MESSAGES)
        self._foreign: list[tuple[str, bytes]] = []
        self._carried: set[str] = set()
        self._identities: frozenset[str] = frozenset()
        self._tick_began = time.monotonic_ns()
        self._last_log_time = 0
        self._outcome: dict[str, str] = {}
        self._expected: dict[str, int] = {}
        self._topic_publishers: dict[str, str] = {}
        self._diagnostics_topic = self.resolve_topic_name(topics.DIAGNOSTICS.name)
        self.controls = RecorderServices(self, self.session, Path(self.parameters.directory))
        if self.parameters.record:
            try:
                self.session.start(Path(self.parameters.directory))
            except BagError as error:
                raise NodeError(str(error)) from error
        self.create_protocol_subscription(topics.TICK_JOIN, self._on_join)
        for node in self.run.participants:
            self.hear_parts(node)
        self._looked_at = 0.0
        self._look()
        self.create_timer(LOOK_PERIOD, self._look, clock=steady_clock())

    def _make_session(self) -> RecordingSession:
        run, parameters = self.run, self.parameters
        attachments = scenario_attachments(parameters.scenario_file)
        description = describe_run(
            scenario=parameters.scenario,
            seed=run.seed,
            pacing=run.pacing,
            tick_period=run.tick_period,
            transient=run.transient,
            composed=self.exchange is not None,
            replaced=parameters.replaced,
        )

        def make_writer(folder: Path) -> BagWriter:
            return BagWriter(
                folder,
                policy=parameters.policy(),
                run=description,
                attachments=attachments,
                ros_distro=DISTRIBUTION,
                opener=DirectStorage if run.is_lockstep else open_in_background,
                closing_attachments=self._parameter_attachment,
            )

        return RecordingSession(make_writer, parameters.ring(), survive=not run.is_lockstep)

    def _parameter_attachment(self) -> list[Attachment]:
        if self.survey.is_empty:
            return []
        return [Attachment(PARAMETERS_ATTACHMENT, "application/yaml", self.survey.to_yaml())]

    # Topics --------------------------------------------------------------------------------------------------------

    def _on_join(self, message: TickJoin, identity: str) -> None:
        expect_no(fault_in_join(message))
        expect_sender(identity, message.identity)
        is_master = self.resolve_topic_name(topics.CLOCK.name) in message.outputs
        if is_master or message.node in self.run.participants:
            self._joined.setdefault(message.node, tuple(message.outputs))
            self._lagging |= {message.node} if message.lag > 0 else set()

    def _announced(self) -> set[str]:
        """Return the topics that other participants say they publish within ticks."""
        outputs = {topic for node, outputs in self._joined.items() if node != self.name for topic in outputs}
        return {topic for topic in outputs if not topics.is_part(topic)}

    def is_ready(self) -> bool:
        """Return whether every participant has named its topics and all of them are subscribed to."""
        wanted = set(self.run.participants) - set(self.run.external) - {self.name}
        clock = self.resolve_topic_name(topics.CLOCK.name)
        has_master = any(clock in outputs for outputs in self._joined.values())
        return self.is_active and has_master and wanted <= set(self._joined) and self._announced() <= self._taken

    def _look(self) -> None:
        """Subscribe to what has appeared, and ask new nodes for their parameters."""
        if self.has_started and time.monotonic() - self._looked_at < LOOK_PERIOD_IN_RUN:
            return
        self._looked_at = time.monotonic()
        announced = self._announced()
        self.watch.look()
        other_systems = self._other_systems()
        for topic in self.watch.types:
            if topic in self._taken or not self._is_of_this_system(topic, other_systems):
                continue
            if topic in announced and not self.has_started:
                self._subscribe_ticked(topic)
            elif topic not in announced and (self.has_started or self.is_ready()):
                self._subscribe_foreign(topic)
        for topic in self.watch.outdated():
            self.watch.unsubscribe(topic)
            self._subscribe_foreign(topic)
        self.survey.ask(node for node in self._joined if node != self.name)

    def _other_systems(self) -> tuple[str, ...]:
        """Return what the topics of other runs in this ROS domain begin with: each has a clock master."""
        own = self.resolve_topic_name(topics.TICK_START.name)
        names = [name for name, _ in self.get_topic_names_and_types()]
        return tuple(name.removesuffix(topics.TICK_START.name) for name in names if _is_start_of_another(name, own))

    def _is_of_this_system(self, topic: str, other_systems: tuple[str, ...]) -> bool:
        """Return whether a topic belongs to this run: of a run in a namespace are the topics in it, and no others."""
        namespace = self.get_namespace().rstrip("/")
        if namespace:
            return topic.startswith(f"{namespace}/")
        return not topic.startswith(other_systems)

    def _take_topic(self, topic: str) -> None:
        self._taken.add(topic)
        problem = self.session.add_topic(topic, self.watch.types[topic], self.watch.offers[topic])
        if problem:
            self.get_logger().warning(problem)

    def _subscribe_ticked(self, topic: str) -> None:
        """Record what participants publish: it comes with their parts; of other programs it may come by itself."""
        self._take_topic(topic)
        publishers = [node for node, outputs in self._joined.items() if topic in outputs]
        foreign = next((node for node in publishers if node in self.run.foreign), "")
        if self.run.is_lockstep:
            latched = all(offer.durability == "transient_local" for offer in self.watch.offers[topic])
            role = Role.LATCHED if latched else Role.STREAM
            self.add_raw_input(Topic(topic, self.watch.types[topic], foreign, role))
        elif foreign or topic == self._diagnostics_topic:
            write = sender_callback(self._writer_of(topic))
            self._ports.subscriptions[topic] = self.watch.subscribe(topic, write)

    def take_messages(self, node: str, number: int, part: Part) -> bool:
        """See HeaveNode. In real time they are written when they come."""
        if self.run.is_lockstep:
            return super().take_messages(node, number, part)
        is_new = self.gate.take_part(node, number, ())
        for output, data in part.messages if is_new and self.is_active else ():
            topic = self._joined[node][output]
            if topic in self._taken:
                self._write(topic, data)
        return is_new

    def _write(self, topic: str, data: bytes) -> None:
        """Write a message now, and take a snapshot where it reports the fault for one."""
        self.session.write(topic, self._now(), data)
        if topic == self._diagnostics_topic and self.parameters.snapshot_duration > 0.0:
            self.controls.watch_for_faults(data)

    def _subscribe_foreign(self, topic: str) -> None:
        self._take_topic(topic)
        in_real_time = sender_callback(self._writer_of(topic))
        self.watch.subscribe(topic, self._keep_callback(topic) if self.run.is_lockstep else in_real_time)

    def _keep_callback(self, topic: str) -> Callable[[bytes], None]:
        """Return a callback that keeps an uncounted message for the tick in which it arrives."""

        def keep(data: bytes) -> None:
            if self.is_active:
                self._foreign.append((topic, data))

        return keep

    def _writer_of(self, topic: str) -> Callable[[bytes, str], None]:
        """Return what writes a message, with the identity of its sender, at once: at the simulated time of its arrival.

        On a topic that one node owns, only what that node says: what others say there is named, and no part of the run.
        """
        if topic in self._owned:
            speakers = Speakers(is_external=self.run.is_external(self._owned[topic]))
            self._speakers[topic] = speakers

            def take_lawful(data: bytes, identity: str) -> None:
                standing = speakers.standing(identity)
                if topic in self._carried:
                    return  # a copy of what comes with the parts
                if standing is Standing.LAWFUL:
                    self.session.write(topic, self._now(), data)
                elif standing is Standing.UNKNOWN:
                    self._before_roster.append(partial(take_lawful, data, identity))
                else:
                    self.strangers.refuse_speaker(topic, identity, speakers)

            return take_lawful

        def take(data: bytes, identity: str) -> None:
            is_copy = identity in self._identities and has_stamp(data)
            if self.is_active and not (topic == self._diagnostics_topic and is_copy):
                self._write(topic, data)

        return take

    def _now(self) -> int:
        """Return the simulated time [ns], interpolated by the wall clock within a tick; it never goes back."""
        if self.tick is None:
            return self._last_log_time
        elapsed = min(time.monotonic_ns() - self._tick_began, self.tick.period_nanoseconds - 1)
        self._last_log_time = max(self._last_log_time, self.tick.start_nanoseconds + elapsed)
        return self._last_log_time

    # Ticks ---------------------------------------------------------------------------------------------------------

    def on_roster(self, message: TickRoster) -> None:
        """Learn from `message` which nodes publish what: it fixes the order of the bag."""
        publishers: dict[str, set[str]] = {}
        for node, topic in zip(message.nodes, message.topics, strict=True):
            if node != self.name:
                publishers.setdefault(topic, set()).add(node)
        identities = dict(zip(message.nodes, message.identities, strict=True))
        self._identities = frozenset(message.identities)
        sends_parts = {node for node, topic in zip(message.nodes, message.topics, strict=True) if topics.is_part(topic)}
        self._carried = {topic for topic, nodes in publishers.items() if nodes <= sends_parts}
        for topic, speakers in self._speakers.items():
            if not speakers.is_external:
                speakers.appoint(identities[node] for node in publishers.get(topic, ()))
        early, self._before_roster = self._before_roster, deque(maxlen=HELD_MESSAGES)
        for take in early:
            take()
        clock = self.resolve_topic_name(topics.CLOCK.name)
        (master,) = publishers[clock]
        recorded = {topic: nodes for topic, nodes in publishers.items() if not topics.is_part(topic)}
        self._topic_publishers = {f"publishers.{topic}": " ".join(sorted(nodes)) for topic, nodes in recorded.items()}
        recorded = {topic: nodes for topic, nodes in publishers.items() if topic in self.gate.inboxes}
        shared = {topic: self._canonical_form(topic) for topic, nodes in recorded.items() if len(nodes) > 1}
        self._order = TickOrder(
            recorded, master, lambda topic, data: shared[topic](data) if topic in shared else data, self._lagging
        )
        super().on_roster(message)

    def _canonical_form(self, topic: str) -> Canonical:
        kind = self.watch.types[topic]
        return Canonical(kind, schema_text(kind))

    def on_tick(self, tick: Tick) -> None:
        """Write what has become complete by `tick`."""
        self._tick_began = time.monotonic_ns()
        if self.run.is_lockstep:
            self._write_complete(tick)
        else:
            self.session.acknowledge()

    def before_answer(self) -> None:
        """Let what was written survive a crash of this process."""
        self.session.acknowledge()

    def on_flush(self, tick: Tick) -> None:
        """Write the messages of the last tick."""
        if self.run.is_lockstep:
            self._write_complete(tick)

    def _write_complete(self, tick: Tick) -> None:
        assert self._order is not None
        before = max(tick.start_nanoseconds - tick.period_nanoseconds, tick.period_nanoseconds)
        self._order.write(self.session.write, self._take, tick_start=tick.start_nanoseconds, tick_before=before)
        self._last_log_time = tick.start_nanoseconds
        for topic, data in self._foreign:
            self.session.write(topic, self._last_log_time, data)
        self._foreign.clear()

    def _take(self, topic: str) -> list[bytes]:
        messages = self.gate.take(topic)
        if topic == self._diagnostics_topic and self.parameters.snapshot_duration > 0.0:
            for data in messages:
                self.controls.watch_for_faults(data)
        return messages

    def on_reset(self) -> None:
        """A run that starts again goes on in the same bag, in a file of its own."""
        if self.session.is_recording:
            self.session.split()

    def diagnose(self) -> list[Health]:
        """Report what is recorded and what cannot be."""
        return [recording_health(self.session, self.watch, self.session.state.problems)]

    # End -----------------------------------------------------------------------------------------------------------

    def on_run_ended(self, status: TickStatus) -> None:
        """Note from `status` how the run went, and how many messages the nodes say they published."""
        is_complete = status.state == TickStatus.ENDED
        self._outcome = {
            "ended": COMPLETE if is_complete else status.reason or "failed",
            **({"lost_on_the_way": status.reason} if is_complete and status.reason else {}),
            "ticks": str(status.tick),
            "real_time_factor": repr(status.real_time_factor),
            **{f"loop_age_{part}_s": repr(getattr(status, f"loop_age_{part}")) for part in ("p50", "p99", "max")},
            "missed_deadlines": str(status.missed_deadlines),
            "resends": str(status.resends),
        }
        self._expected = dict(zip(status.topics, status.published, strict=True))

    def on_exit(self) -> None:
        """Write what is left and close the bag, however the run ended."""
        session: RecordingSession | None = getattr(self, "session", None)
        if session is None:
            return
        if self._order is not None and self.run.is_lockstep:
            self._order.write_rest(session.write, self._take_everything, tick_start=self._last_log_time)
        problems = [*session.state.problems]
        missing = self._missing(self._expected) if session.is_recording else {}
        lost = missing_words(missing, self._expected)
        if lost:
            if self.run.is_lockstep:
                problems.append(f"messages were lost: {lost}")
            else:  # the run is over and the bag says so
                self.get_logger().error(f"messages were lost: {lost}")
            session.note_missed(sum(missing.values()), f"did not come to the recorder: {lost}")
        if session.is_recording:
            session.stop(self._final_metadata(lost))
        session.finish()
        if problems and not self.failure:
            raise NodeError("; ".join(problems))

    def _final_metadata(self, lost: str) -> dict[str, str]:
        now = time.time_ns()
        return {
            "ended": self.failure or "the recorder was stopped",
            **self._outcome,
            **self._topic_publishers,
            "ended_at_host_time_ns": str(now),
            "host_time_minus_log_time_ns": str(now - self._last_log_time),
            **({"lost": lost} if lost else {}),
        }

    def _take_everything(self, topic: str) -> list[bytes]:
        inbox = self.gate.inboxes[topic]
        return inbox.take(inbox.received)

    def missing(self, published: Sequence[int]) -> int:
        """See ParticipantNode: in real time no gate counts what comes, but the bag."""
        totals: dict[str, int] = {}
        for topic, count in zip(self._roster.topics if self._roster else (), published, strict=True):
            totals[topic] = totals.get(topic, 0) + count
        return super().missing(published) + sum(self._missing(totals).values())

    def _missing(self, published: Mapping[str, int]) -> dict[str, int]:
        """Return by how many messages topics hold fewer than were `published`; empty where all are there.

        Only of a bag that covers the whole run. The recorder's own /diagnostics are not in it.
        """
        if str(self.session.folder) != self.parameters.directory:
            return {}
        published = {topic: count for topic, count in published.items() if topic != self._diagnostics_topic}
        return missing_messages(published, self.session.counts())


def _is_start_of_another(name: str, own: str) -> bool:
    return name.endswith(f"/{topics.TICK_START.name}") and name != own


def main() -> None:
    """Run the recorder."""
    run_process(RecorderNode)


if __name__ == "__main__":
    main()
