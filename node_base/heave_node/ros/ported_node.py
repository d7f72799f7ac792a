"""The ports of a node within ticks: what it publishes and reads, by whichever way the nodes of the run hand it over."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

from rclpy.lifecycle import LifecycleNode
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.serialization import deserialize_message
from rclpy.subscription import Subscription

from heave_node.errors import NodeError
from heave_node.interface import topics
from heave_node.interface.messages import message_type
from heave_node.interface.topic import LASTING, Topic
from heave_node.ros.input_timing import InputTiming
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
from heave_node.ros.transport.strangers import Strangers
from heave_node.tick.external_clock import ExternalClock
from heave_node.tick.gate import Inbox, TickGate
from heave_node.tick.malformed import ProtocolError
from heave_node.tick.protocol import Part, Past
from heave_node.tick.roster import NOT_WAITED_FOR
from heave_node.tick.simulated_clock import SimulatedClock
from heave_node.tick.tick import Tick


@dataclass
class ProtocolTimes:
    """How old the messages of the protocol are."""

    sent: int = 0  # when the one that is handled now was sent, by its sender's clock [ns]
    # least time that a status of the clock master took, by the clocks of both hosts [s]; 0: none came
    least_delay: float = 0.0


class PortedNode(LifecycleNode):
    """A node with ports within ticks; `HeaveNode` adds its life.

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
    identity : of this node's process, as the others see it on each of its messages
    gate : messages received, and whether those of the tick are complete
    tick, epoch : the tick and the run the node is in
    has_started : the run has begun
    clocks : of the external inputs, by topic
    clock_of_run : simulated time by monotonic wall time [ns]
    strangers : processes noticed that are not part of the run
    protocol_times : how old the messages of the protocol are
    exchange : of the topics of a run whose nodes share one process; None: they go through the middleware
    """

    name: ClassVar[str]
    parameters_type: ClassVar[type[Any]]
    after: ClassVar[tuple[str, ...]] = ()
    exchange: ClassVar[Exchange | None] = None
    lag: int = 0

    def __init__(self) -> None:
        super().__init__(self.name, automatically_declare_parameters_from_overrides=True)
        self.run, self.parameters = read_parameters(self, self.parameters_type)
        self.identity = own_identity(self)
        self._begin_unconfigured()

    def _begin_unconfigured(self) -> None:
        """Be as before the first transition: without ports, in no run."""
        in_protocol = set(self.run.participants) - set(self.run.external)
        self.gate = TickGate((), [node for node in self.after if node in in_protocol], lockstep=self.run.is_lockstep)
        self.strangers = Strangers(self, self.identity)
        self.tick: Tick | None = None
        self.epoch = 0
        self.has_started = False
        self.clocks: dict[str, ExternalClock] = {}
        self.clock_of_run = SimulatedClock()
        self.protocol_times = ProtocolTimes()
        self._ports = Ports()

    # Within ticks ----------------------------------------------------------------------------------------------------

    def add_output(self, topic: Topic) -> Output:
        """Publish `topic` within ticks; one that is external comes from outside, and this node keeps silent on it."""
        name = self.resolve_topic_name(topic.name)
        if topic.name in self.run.external:
            return Output(name, None)
        options = overriding_options(self, name, PUBLISHER, is_lockstep=self.run.is_lockstep)
        number, ports = len(self._ports.outputs), self._ports
        output = Output(
            name,
            self.make_publisher(topic, options),
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
        check_stamps, lifespan, holds_ahead, settles : see Input. Lifespan and holds_ahead count in real time, settles
            in lockstep: so a run depends on its seed alone also where the publisher may lag
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
            self.strangers.refuse_speaker(name, identity, inbox.speakers)

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

    def take(self, port: Input) -> list[Any]:
        """Return what is new in this tick on the input `port`, oldest first."""
        assert self.tick is not None
        if port.name in self._ports.timings:
            self._ports.timings[port.name].used()
        return port.take(self.tick)

    def look_for_hearers(self) -> None:
        """Look who hears the topics of this node by themselves: what nobody hears is not sent."""
        for output in (*self._ports.outputs, *self._ports.apart):
            output.look()

    def published_counts(self) -> list[int]:
        """Return the number of messages published so far on each output."""
        return [output.published for output in self._ports.outputs]

    # Parts of ticks --------------------------------------------------------------------------------------------------

    @property
    def hears_past(self) -> bool:
        """Whether the clock master passes on to this node what was sent, a few ticks at a time: it may be behind."""
        return self.lag == NOT_WAITED_FOR or (self.run.is_lockstep and self.lag > 0)

    def hear_parts(self, node: str) -> None:
        """Take in the parts of ticks of a `node`, if it is a participant other than this one."""
        topic = topics.tick_part_topic(node)
        is_participant = node in self.run.participants and node not in self.run.external and node != self.name
        if is_participant and self.hears_past and node not in self.run.foreign:
            self._ports.of_past.add(node)
        elif is_participant and self.resolve_topic_name(topic.name) not in self._ports.subscriptions:
            self.subscribe_to_parts(topic, lambda part, identity: self.on_part(node, part, identity))
            if node in self.run.foreign:
                done = topics.tick_done_topic(node)
                self.create_protocol_subscription(
                    done, lambda part, identity: self.on_part(node, part, identity, is_whole=False), Part.of_done
                )

    def subscribe_to_parts(
        self, topic: Topic, callback: Callable[[Any, str], None], kind: type[Part] | type[Past] = Part
    ) -> None:
        """Subscribe to a `topic` of parts; the start of the run waits for its publisher.

        `callback` gets each message as a `kind`.
        """

        def read(data: bytes | Part | Past) -> Part | Past:
            return kind.of(data) if isinstance(data, bytes) else data  # within a process it comes as it is

        name = self.resolve_topic_name(topic.name)
        self._ports.subscriptions[name] = self.create_protocol_subscription(topic, callback, read)

    def on_part(self, node: str, part: Part, identity: str, *, is_whole: bool = True) -> None:
        """Take in what a `node`, as the process of an `identity`, says of its `part` of a tick.

        Not `is_whole`: its messages come by themselves.
        """

    def take_messages(self, node: str, number: int, part: Part) -> bool:
        """Let the gate take what a `part` of this `number` of a `node` carries; return False where it had come before.

        Raises ProtocolError for nonsense.
        """
        try:
            return self.gate.take_part(node, number, part.messages)
        except (RuntimeError, ValueError):
            raise ProtocolError("it cannot be decoded") from None

    def take_carried(self) -> list[tuple[int, bytes]]:
        """Return the messages of this tick for its part, which is counted now."""
        carried, self._ports.carried = self._ports.carried, []
        self._ports.part.published += 1
        return carried

    def send_part(self, part: Part, output: Output | None = None) -> None:
        """Send a `part`, on the output of this node's parts or another, also again: it is known by its number."""
        (output or self._ports.part).publish_uncounted(part.to_bytes() if self.exchange is None else part)

    def send_again_alone(self, part: Part) -> None:
        """Send the messages of a `part` again by themselves, where programs take part that have no parts.

        Only they need it: whoever else hears a topic from outside hears each message once.
        """
        for number, data in part.messages if self.run.foreign else ():
            if self._ports.outputs[number].is_heard:
                self._ports.outputs[number].publish_uncounted(data)

    def _advance(self) -> None:
        """Do the tick's work if everything of the tick is here; called after each message."""

    # The tick protocol, and the way that messages take ---------------------------------------------------------------

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

    def make_publisher(
        self, topic: Topic, options: QoSOverridingOptions | None = None
    ) -> Publisher[Any] | LocalPublisher:
        """Return a publisher of a `topic`, with the `options` of a user, by the way that messages take here."""
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

    def add_plain(self, topic: Topic) -> Output:
        """Return an output for a `topic` of the protocol, for which the start of the run waits."""
        self._ports.outputs.append(Output(self.resolve_topic_name(topic.name), self.make_publisher(topic)))
        return self._ports.outputs[-1]

    def add_apart(self, topic: Topic) -> Output:
        """Return an output for a `topic` of the protocol that only nodes of other programs hear."""
        self._ports.apart.append(Output(self.resolve_topic_name(topic.name), self.make_publisher(topic)))
        return self._ports.apart[-1]

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

    def _entities(self) -> set[Any]:
        """Return what this node has of the middleware."""
        kinds = (self.publishers, self.subscriptions, self.clients, self.services, self.timers, self.waitables)
        return {entity for kind in kinds for entity in kind}

    def _destroy(self, entities: Iterable[Any]) -> None:
        """Destroy `entities` of this node; those of actions last, which are made of others."""
        ways: tuple[Callable[[Any], bool], ...] = (
            self.destroy_publisher,
            self.destroy_subscription,
            self.destroy_client,
            self.destroy_service,
            self.destroy_timer,
        )
        for entity in entities:
            any(destroy(entity) for destroy in ways)
        for entity in set(entities) & set(self.waitables):
            entity.destroy()
