"""The thin ROS shell of every node of the suite: lifecycle, parameters, ports, diagnostics, one way to end.

Nodes do not derive from `HeaveNode` but from `participant.ParticipantNode` or, for the one that steps the clock,
`master.ClockMasterNode`.
"""

from __future__ import annotations

import inspect
import math
import socket
import time
import traceback
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

from builtin_interfaces.msg import Time
from heave_msgs.msg import TickJoin, TickStatus
from rclpy.client import Client
from rclpy.clock import Clock, ClockType
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.qos_overriding_options import InvalidQosOverridesError, QoSOverridingOptions
from rclpy.serialization import deserialize_message
from rclpy.service import Service
from rclpy.subscription import Subscription
from rclpy.task import Future
from rclpy.timer import Timer

from heave_node.errors import NodeError, one_line
from heave_node.interface import topics
from heave_node.interface.alarm import NODE_ALARMS
from heave_node.interface.codes import OPERATOR, time_key, timed_message
from heave_node.interface.messages import message_type
from heave_node.interface.topic import LASTING, Topic
from heave_node.ros.diagnostics import Health, Level, alarm_health, diagnostic_array
from heave_node.ros.input_timing import InputTiming, timing_health
from heave_node.ros.node_parameters import read_parameters
from heave_node.ros.ports import Input, Output, Ports, decoder_of, of_any_machine, stamped
from heave_node.ros.spin import timed_callback
from heave_node.ros.transport.exchange import Exchange, LocalPublisher, LocalSubscription, Reader
from heave_node.ros.transport.identity import own_identity
from heave_node.ros.transport.qos import (
    PUBLISHER,
    SUBSCRIPTION,
    overriding_options,
    qos_of,
    reader_qos_of,
    unused_overrides,
)
from heave_node.ros.transport.real_time import collect_between_ticks, take_priority
from heave_node.ros.transport.strangers import Strangers
from heave_node.run_parameters import RunParameters
from heave_node.tick.durations import Durations
from heave_node.tick.external_clock import ExternalClock
from heave_node.tick.gate import Inbox, TickGate
from heave_node.tick.protocol import Part
from heave_node.tick.simulated_clock import SimulatedClock
from heave_node.tick.speakers import ANYONE
from heave_node.tick.tick import Tick

JOIN_PERIOD = 0.05
"""Wall time between two TickJoin messages while the run has not started [s]."""
LOOK_EVERY = 10
"""Ticks between two looks who hears the topics of a node by themselves."""
DIAGNOSTICS_PERIOD = 1.0
"""Simulated time between two DiagnosticArray messages [s]."""


class ProtocolError(Exception):
    """A message of the tick protocol that is rejected; says why, "" where its sender is not part of the run."""


def expect_no(fault: str) -> None:
    """Refuse a message of the protocol that has a `fault`; "" says that it has none."""
    if fault:
        raise ProtocolError(fault)


def expect_sender(identity: str, lawful: str) -> None:
    """Refuse a message of the protocol that comes from another process (`identity`) than the `lawful` one."""
    if ANYONE not in (identity, lawful) and identity != lawful:
        raise ProtocolError


@dataclass
class ProtocolTimes:
    """How old the messages of the protocol are."""

    sent: int = 0  # when the one that is handled now was sent, by its sender's clock [ns]
    # least time that a status of the clock master took, by the clocks of both hosts [s]; 0: none came
    least_delay: float = 0.0


class HeaveNode(LifecycleNode):
    """What participants and the clock master have in common.

    Class attributes that a node sets
    ---------------------------------
    name : node name
    parameters_type : parameter set of the node's own parameters (those of RunParameters are added)
    after : nodes whose part of a tick comes before this node's own
    lag : ticks that the node may be behind the others; NOT_WAITED_FOR: nobody waits for it

    Attributes
    ----------
    run : parameters of the run
    parameters : the node's own
    gate : messages received, and whether those of the tick are complete
    tick, epoch : the tick and the run the node is in
    failure : why the node ended, "" while nothing went wrong; `failed_at` when [s of monotonic wall time]
    was_ended : a signal or a transition, not an error, ended it
    identity : of this node's process, as the others see it on each of its messages
    clocks : of the external inputs, by topic
    clock_of_run : simulated time by monotonic wall time [ns]
    strangers : processes noticed that are not part of the run
    protocol_times : how old the messages of the protocol are
    work : this node's own time in each tick, in real time
    exchange : of the topics of a run whose nodes share one process; None: they go through the middleware
    """

    name: ClassVar[str]
    parameters_type: ClassVar[type[Any]]
    after: ClassVar[tuple[str, ...]] = ()
    lag: int = 0
    exchange: ClassVar[Exchange | None] = None

    def __init__(self) -> None:
        super().__init__(self.name, automatically_declare_parameters_from_overrides=True)
        self.run: RunParameters
        self.parameters: Any
        self.run, self.parameters = read_parameters(self, self.parameters_type)
        self.identity = own_identity(self)
        self.finished: Future[None] = Future()
        self._begin_unconfigured()

    def _begin_unconfigured(self) -> None:
        """Be as before the first transition: without ports, in no run."""
        in_protocol = set(self.run.participants) - set(self.run.external)
        self.gate = TickGate((), [node for node in self.after if node in in_protocol], lockstep=self.run.is_lockstep)
        self.strangers = Strangers(self, self.identity)
        self.failure, self.failed_at = "", 0.0
        self.was_ended = False
        self.tick: Tick | None = None
        self.epoch = 0
        self.has_started = self.is_active = False
        self.clocks: dict[str, ExternalClock] = {}
        self.clock_of_run = SimulatedClock()
        self.protocol_times = ProtocolTimes()
        self.work = Durations()
        self._ports = Ports()
        self._asked: dict[str, str] = {}

    # What a node fills in ------------------------------------------------------------------------------------------

    def on_build(self) -> None:
        """Make the component, inputs and outputs; compile what the first tick would otherwise wait for."""
        raise NodeError(f"{self.name} does not define on_build")

    def on_reset(self) -> None:
        """Make a new component for another run with the same inputs and outputs."""
        raise NodeError(f"{self.name} cannot be reset")

    def diagnose(self) -> list[Health]:
        """Return the health of the parts of this node; called once per simulated second.

        In lockstep it must depend on the run alone, not on the machine: it is recorded.
        """
        return []

    def on_run_ended(self, status: TickStatus) -> None:
        """Called when the run is over; `status` says how it ended."""

    def on_exit(self) -> None:
        """Release what the node holds, such as files; called once, however the node ends."""

    def wait_until_heard(self) -> None:
        """Wait until others have what they must hear last; called after `on_exit`, and cut short where it hangs."""

    # Ports ---------------------------------------------------------------------------------------------------------

    def add_output(self, topic: Topic) -> Output:
        """Publish `topic` within ticks; one that is external comes from outside, and this node keeps silent on it."""
        name = self.resolve_topic_name(topic.name)
        if topic.name in self.run.external:
            return Output(name, None)
        options = overriding_options(self, name, PUBLISHER, is_lockstep=self.run.is_lockstep)
        number, ports = len(self._ports.outputs), self._ports
        output = Output(
            name,
            self._publisher(topic, options),
            is_lasting=topic.role in LASTING,
            carry=lambda data: ports.carried.append((number, data)),
        )
        ports.outputs.append(output)
        return output

    def add_input(
        self,
        topic: Topic,
        fields: Sequence[str] | None = None,
        *,
        check_stamps: bool = True,
        lifespan: float = math.inf,
        holds_ahead: bool = False,
        settles: bool = False,
    ) -> Input:
        """Read a topic within ticks.

        Messages of hardware get stamps of simulated time by the rule of its clock, and are never refused for them.

        Parameters
        ----------
        topic : its name, type, publisher and role
        fields : dotted names of the numbers that are read: the input gives a WireReading of each message, which takes a
            tenth of the time of a whole one. None: it gives messages
        check_stamps : refuse messages that are stamped in the future or out of order
        lifespan : real time: messages older than this are late and not used [s]
        holds_ahead : real time: what was measured after the start of a tick waits for the next one, also where this
            node is behind the others
        settles : lockstep: a message is taken in the tick after the one that it is stamped with, however early it came:
            so a run depends on its seed alone also where the publisher may lag
        """
        is_external = self.run.is_external(topic)
        life = math.inf if self.run.is_lockstep else lifespan
        port = Input(
            self,
            topic,
            self.gate,
            check_stamps=check_stamps and not is_external,
            lifespan=life,
            holds_ahead=holds_ahead and not self.run.is_lockstep,
            settles=settles and self.run.is_lockstep,
        )
        self._ports.inputs.append(port)
        decode = decoder_of(topic, fields)

        def decode_external(data: bytes) -> tuple[int | None, Any]:
            self._ports.timings[port.name].arrived()
            stamp, content = decode(data)
            if stamp is None:
                return stamp, content
            wall = time.monotonic_ns()
            stamp = max(0, clock.simulated_time(stamp, self.clock_of_run.now(wall), wall))
            return stamp, stamped(content, stamp)

        if is_external:
            self._ports.timings[port.name] = InputTiming(port.name)
            clock = self.clocks[port.name] = ExternalClock(*self.run.stamping(topic))
        self.add_raw_input(topic, decode_external if is_external else decode)
        return port

    def add_raw_input(
        self,
        topic: Topic,
        decode: Callable[[bytes], Any] = bytes,
        on_stranger: Callable[[str, bytes], None] | None = None,
        *,
        comes_alone: bool = False,
    ) -> None:
        """Let the gate wait for the messages of a topic.

        Parameters
        ----------
        topic : its name, type, publisher and role
        decode : makes of the bytes of a message what the gate holds
        on_stranger : gets identity and bytes of messages of processes that may not publish here; None names them
        comes_alone : the topic is heard by itself, not with each part of its publisher: it has a message now and then
        """
        name = self.resolve_topic_name(topic.name)

        def refuse(identity: str, _: bytes) -> None:
            self.strangers.refuse(name, identity)
            if self.strangers.has_left(name, inbox.speakers):
                inbox.speakers.release()

        is_external = self.run.is_external(topic)
        inbox = self.gate.add_inbox(
            Inbox(name, decode, is_external=is_external, comes_alone=comes_alone, on_stranger=on_stranger or refuse)
        )
        if not comes_alone:
            self.hear_parts(topic.publisher)
            if not is_external and topic.publisher not in self.run.foreign:
                return

        def on_data(data: bytes, identity: str, _: int) -> None:
            if is_external and not self.has_started:
                return  # there is no simulated time yet
            try:
                is_new = inbox.put(data, identity)
            except (RuntimeError, ValueError):
                self.strangers.refuse(name, identity, "it cannot be decoded")
                return
            if is_new:
                self._advance()

        qos = reader_qos_of(topic.role, is_external=is_external)
        options = overriding_options(self, name, SUBSCRIPTION, is_lockstep=self.run.is_lockstep)
        self._ports.subscriptions[name] = self._subscription(topic, on_data, qos, options)

    def hear_parts(self, node: str) -> None:
        """Take in the parts of ticks of a `node`, if it is a participant other than this one."""
        topic = topics.tick_part_topic(node)
        is_participant = node in self.run.participants and node not in self.run.external and node != self.name
        if is_participant and self.resolve_topic_name(topic.name) not in self._ports.subscriptions:
            self.subscribe_to_parts(topic, lambda part, identity: self.on_part(node, part, identity))
            if node in self.run.foreign:
                done = topics.tick_done_topic(node)
                self.create_protocol_subscription(
                    done, lambda part, identity: self.on_part(node, part, identity, is_whole=False), Part.of_done
                )

    def subscribe_to_parts(self, topic: Topic, callback: Callable[[Part, str], None]) -> None:
        """Subscribe to a `topic` of parts; the start of the run waits for its publisher. `callback` gets each one."""
        name = self.resolve_topic_name(topic.name)
        self._ports.subscriptions[name] = self.create_protocol_subscription(topic, callback, _part_of)

    def on_part(self, node: str, part: Part, identity: str, *, is_whole: bool = True) -> None:
        """Take in what a `node`, as the process of an `identity`, says of its `part` of a tick.

        Not `is_whole`: its messages come by themselves.
        """

    def take_messages(self, node: str, number: int, part: Part) -> None:
        """Let the gate take what a `part` of this `number` of a `node` carries. Raises ProtocolError for nonsense."""
        try:
            self.gate.take_part(node, number, part.messages)
        except (RuntimeError, ValueError):
            raise ProtocolError("it cannot be decoded") from None

    def take(self, port: Input) -> list[Any]:
        """Return what is new in this tick on the input `port`, oldest first."""
        assert self.tick is not None
        if port.name in self._ports.timings:
            self._ports.timings[port.name].used()
        return port.take(self.tick)

    def create_protocol_subscription(
        self, topic: Topic, callback: Callable[[Any, str], None], decode: Callable[[bytes], Any] | None = None
    ) -> Subscription[Any] | LocalSubscription:
        """Subscribe to a topic of the tick protocol, and return the subscription.

        Parameters
        ----------
        topic : of the protocol
        callback : gets each message and the identity of the process that sent it. It raises ProtocolError for one that
            is refused
        decode : makes of the bytes what the callback gets; None: a message of ROS
        """
        name, kind = self.resolve_topic_name(topic.name), message_type(topic.type)
        read = of_any_machine(decode, kind) if decode else partial(deserialize_message, message_type=kind)

        def on_data(data: bytes, identity: str, sent: int) -> None:
            self.protocol_times.sent = sent
            try:
                message = read(data)
            except (RuntimeError, ValueError):  # of the middleware, and of text that is not UTF-8
                self.strangers.refuse(name, identity, "it cannot be decoded")
                return
            try:
                callback(message, identity)
            except ProtocolError as error:
                self.strangers.refuse(name, identity, str(error))

        return self._subscription(topic, on_data, reader_qos_of(topic.role, is_external=False))

    def create_protocol_publisher(self, topic: Topic) -> Publisher[Any] | LocalPublisher:
        """Return a publisher of a `topic` of the tick protocol."""
        return self._publisher(topic)

    def _publisher(self, topic: Topic, options: QoSOverridingOptions | None = None) -> Publisher[Any] | LocalPublisher:
        """Return a publisher by the way that the nodes of this run hand each other messages."""
        kind, qos = message_type(topic.type), qos_of(topic.role)
        publisher = self.create_publisher(kind, topic.name, qos, qos_overriding_options=options)
        if self.exchange is None:
            return publisher
        local = self.exchange.add_publisher(topic, publisher, self.identity)
        self._ports.local.append(local)
        return local

    def _subscription(
        self, topic: Topic, on_data: Reader, qos: QoSProfile, options: QoSOverridingOptions | None = None
    ) -> Subscription[Any] | LocalSubscription:
        """Subscribe by the way that the nodes of this run hand each other messages."""
        name = self.resolve_topic_name(topic.name)
        if self.exchange is not None:
            local = self.exchange.subscribe(name, on_data)
            self._ports.local.append(local)
            return local
        callback = timed_callback(on_data)
        kind = message_type(topic.type)
        return self.create_subscription(kind, name, callback, qos, raw=True, qos_overriding_options=options)

    # Lifecycle -----------------------------------------------------------------------------------------------------

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Build the component and join the tick protocol; `state` is the lifecycle state before."""
        self._ports.before = self._entities()
        self._ports.join = self.create_protocol_publisher(topics.TICK_JOIN)
        part = self.part_topic
        self._ports.part = Output(self.resolve_topic_name(part.name), self.create_protocol_publisher(part))
        self._ports.outputs.append(self._ports.part)
        try:
            self._diagnostics = self.add_output(topics.DIAGNOSTICS)
            self.join_protocol()
            self._ports.has_joined = True
            self.on_build()
            self._refuse_unused_overrides()
            # The first line of a log looks for its caller among all modules, which takes up to a second: not in a tick.
            inspect.getmodule(inspect.currentframe())
            self._prepare_real_time()
        except InvalidQosOverridesError as error:
            self.fail(" ".join(str(error).split()), error)
            return TransitionCallbackReturn.ERROR
        except Exception as error:  # rclpy would swallow it and say only that the transition failed
            self.fail(one_line(error, type(self)), error)
            return TransitionCallbackReturn.ERROR
        join_timer: Timer = self.create_timer(
            JOIN_PERIOD, lambda: self._join_until_started(join_timer), clock=steady_clock()
        )
        return super().on_configure(state)

    def _prepare_real_time(self) -> None:
        """Collect garbage between ticks; with a priority where the run wants one and others wait for this node."""
        if self.run.is_lockstep:
            return
        collect_between_ticks()
        if self.run.realtime_priority and self.lag == 0:
            for refused in take_priority(self.run.realtime_priority):
                self.get_logger().warning(refused)

    def _refuse_unused_overrides(self) -> None:
        """Refuse a quality of service for a topic that this node does not have: it would be lost silently."""
        publishers = {(output.topic, PUBLISHER) for output in self._ports.outputs}
        readers = {(topic, SUBSCRIPTION) for topic in self._ports.subscriptions}
        unused = unused_overrides(self, publishers | readers)
        if unused:
            known = sorted({topic for topic, _ in publishers | readers})
            raise NodeError(
                f"{unused[0]}: {self.name} has no such publisher or subscription; topics: {', '.join(known)}"
            )

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Take part in the run from now on, also in one that is under way; `state` is the lifecycle state before."""
        self.is_active = True
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Do and publish nothing from now on; a run under way goes on. `state` is the lifecycle state before."""
        self.is_active = False
        return super().on_deactivate(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Leave the run and all that was made in it; `state` is the lifecycle state before."""
        self._leave_run("cleaned up")
        return super().on_cleanup(state)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Leave the run, and end; `state` is the lifecycle state before."""
        self._leave_run("shut down")
        self.finish()
        return super().on_shutdown(state)

    def _leave_run(self, how: str) -> None:
        """Let go of a run: one in lockstep ends with the reason that this node was, say, cleaned up (`how`)."""
        if not self.has_joined or self.finished.done():
            return
        self.is_active = False
        self.publish_join()
        self.was_ended, self.failure = True, f"it was {how}" if self.has_started else ""
        self.on_exit()
        if self.has_started:
            self.wait_until_heard()
        if self.exchange is not None:
            self.exchange.leave(self._ports.local)
        self._destroy(self._entities() - self._ports.before)
        self._begin_unconfigured()

    def _entities(self) -> set[Any]:
        """Return what this node has of the middleware."""
        kinds = (self.publishers, self.subscriptions, self.clients, self.services, self.timers, self.waitables)
        return {entity for kind in kinds for entity in kind}

    def _destroy(self, entities: Iterable[Any]) -> None:
        """Destroy `entities` of this node; those of actions last, which are made of others."""
        by_kind: dict[type[Any], Callable[[Any], object]] = {
            Publisher: self.destroy_publisher,
            Subscription: self.destroy_subscription,
            Client: self.destroy_client,
            Service: self.destroy_service,
            Timer: self.destroy_timer,
        }
        for entity in entities:
            for kind, destroy in by_kind.items():
                if isinstance(entity, kind):
                    destroy(entity)
        for entity in set(entities) & set(self.waitables):
            entity.destroy()

    @property
    def has_joined(self) -> bool:
        """Whether it is configured, or was about to be: it has its part of the tick protocol."""
        return self._ports.has_joined

    @property
    def next_tick(self) -> int:
        """Number of the tick that this node works out next."""
        return 1 if self.tick is None else self.tick.number + 1

    # Tick protocol: what both sides do -----------------------------------------------------------------------------

    @property
    def part_topic(self) -> Topic:
        """Topic on which this node sends its parts of ticks."""
        return topics.tick_part_topic(self.name)

    def join_protocol(self) -> None:
        """Make the publishers and subscriptions of the tick protocol."""

    def _advance(self) -> None:
        """Do the tick's work if everything of the tick is here; called after each message."""

    def is_ready(self) -> bool:
        """Return whether this node could begin tick 1."""
        return self.is_active

    def _join_until_started(self, timer: Timer) -> None:
        if self.has_started:
            timer.cancel()
        else:
            self.publish_join()

    def look_for_hearers(self) -> None:
        """Look who hears the topics of this node by themselves: what nobody hears is not sent."""
        for output in (*self._ports.outputs, *self._ports.apart):
            output.look()

    def add_apart(self, topic: Topic) -> Output:
        """Return an output for a `topic` of the protocol that only nodes of other programs hear."""
        output = Output(self.resolve_topic_name(topic.name), self.create_protocol_publisher(topic))
        self._ports.apart.append(output)
        return output

    def publish_join(self, waiting_for: str = "") -> None:
        """Tell the clock master what this node publishes and subscribes to, and why it has ended where it has.

        Parameters
        ----------
        waiting_for : what the node lacks in this tick, in words
        """
        self._ports.join.publish(
            TickJoin(
                node=self.name,
                identity=self.identity,
                host=socket.gethostname(),
                ready=self.is_ready(),
                lag=self.lag,
                after=list(self.gate.after),
                outputs=[output.topic for output in self._ports.outputs],
                matched_subscriptions=[output.hearers for output in self._ports.outputs],
                inputs=list(self._ports.subscriptions),
                matched_publishers=[s.get_publisher_count() for s in self._ports.subscriptions.values()],
                waiting_for=waiting_for,
                least_delay=self.protocol_times.least_delay,
                failure=self.failure,
            )
        )

    def begin_outputs(self) -> None:
        """Discard on every output the messages of the previous tick; look now and then who hears them."""
        if self.tick is not None and self.tick.number % LOOK_EVERY == 0:
            self.look_for_hearers()
        for output in self._ports.outputs:
            output.begin_tick()

    def take_carried(self) -> list[tuple[int, bytes]]:
        """Return the messages of this tick for its part, which is counted now."""
        carried, self._ports.carried = self._ports.carried, []
        self._ports.part.published += 1
        return carried

    def send_part(self, part: Part) -> None:
        """Send a `part`, also again: whoever has it knows it by its number."""
        self._ports.part.publish_uncounted(part.to_bytes() if self.exchange is None else part)

    def resend_outputs(self) -> None:
        """Send again every message of this tick that was sent by itself."""
        for output in self._ports.outputs:
            output.resend()

    def published_counts(self) -> list[int]:
        """Return the number of messages published so far on each output."""
        return [output.published for output in self._ports.outputs]

    def reset_run(self) -> None:
        """Drop what came late of the previous run, in real time, and make a new component."""
        if not self.run.is_lockstep:
            self.gate.clear()
        self._asked.clear()
        for port in self._ports.inputs:
            port.reset()
        self.fail_on_error(self.on_reset)

    def has_urgent_news(self) -> bool:
        """Whether the health of this node must be reported in this tick; for a node to say otherwise."""
        return False

    def note_request(self, time: float, words: str) -> None:
        """Report in the next diagnostics what an operator has requested, in `words`, from `time` [s] of the run on."""
        key = time_key(time)
        self._asked[key] = f"{self._asked[key]}, {words}" if key in self._asked else words

    def publish_diagnostics(self, tick: Tick) -> None:
        """Publish the health of this node if it is due at `tick`: once per simulated second, strangers at once."""
        every = max(1, round(DIAGNOSTICS_PERIOD / self.run.tick_period))
        if self.has_urgent_news() or tick.number % every == 1 % every or self.strangers.has_news:
            asked, self._asked = self._asked, {}
            requests = [Health(OPERATOR, Level.OK, timed_message(asked), asked)] if asked else []
            inputs = [*self.diagnose_inputs(), *self.diagnose_timing(), *self.strangers.health()]
            parts = [*self.diagnose(), *requests, *inputs] or [Health("node")]
            self._diagnostics.publish(diagnostic_array(self.name, tick.stamp, parts))

    def publish_protocol_notice(self, text: str, level: Level) -> None:
        """Publish on /diagnostics, as `text`, what is wrong in wall time, and how much (`level`).

        Its stamp of 0 keeps it out of counts and recordings.
        """
        part = Health("tick protocol", level, text)
        self._diagnostics.publish_uncounted(diagnostic_array(self.name, Time(), [part]))

    def diagnose_timing(self) -> list[Health]:
        """Return this node's own time and how the messages of external nodes arrive, in wall time; not in lockstep."""
        own = [timing_health("work in a tick", self.work.to_values())] if len(self.work) else []
        return [*own, *(part for timing in self._ports.timings.values() for part in timing.diagnose())]

    def diagnose_inputs(self) -> list[Health]:
        """Return what is to be said of the clocks of external nodes, and of messages that were refused."""
        parts = [
            alarm_health(
                f"clock of {topic}", NODE_ALARMS.alarm("CLOCK_VIOLATION", topic=topic, violation=clock.violation)
            )
            if clock.violation
            else Health(f"clock of {topic}", Level.OK, clock.describe())
            for topic, clock in self.clocks.items()
        ]
        for port in self._ports.inputs:
            if port.early:
                parts.append(alarm_health(f"input {port.name}", NODE_ALARMS.alarm("INPUT_EARLY", count=port.early)))
            if port.late:
                parts.append(alarm_health(f"input {port.name}", NODE_ALARMS.alarm("INPUT_LATE", count=port.late)))
        return parts

    # Ends ----------------------------------------------------------------------------------------------------------

    def fail_on_error(self, work: Callable[[], None]) -> None:
        """Call `work`, a part of the component; an error in it ends this node with one line."""
        try:
            work()
        except Exception as error:  # whatever a component raises must end the run with a reason
            self.fail(one_line(error, type(self)), error)

    def fail(self, reason: str, error: Exception | None = None) -> None:
        """End this node with a one-line `reason`; the traceback of `error` goes to the debug log."""
        if self.failure:
            return
        when = f" at t = {self.tick.time:.3f} s" if self.tick is not None else ""
        self.failure, self.failed_at = f"{reason}{when}", time.monotonic()
        if error is not None:
            self.get_logger().debug("".join(traceback.format_exception(error)))
        self.finish()

    def finish(self) -> None:
        """End the spin loop."""
        if not self.finished.done():
            self.finished.set_result(None)

    def service_pause(self) -> float:
        """Return for how long callbacks may now wait to be served together [s of wall time]; see `spin`."""
        return 0.0

    def on_idle(self) -> None:
        """Look at the wall clock; called a few times per second from the spin loop."""


def _part_of(data: bytes | Part) -> Part:
    """Return the part that a message is; within a process it comes as it is."""
    return data if isinstance(data, Part) else Part.of(data)


def steady_clock() -> Clock:
    """Return the clock for waits in wall time, which simulated time does not stop."""
    return Clock(clock_type=ClockType.STEADY_TIME)
