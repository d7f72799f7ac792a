"""A node that takes part in each tick: it waits for its inputs, steps its component, answers the clock master."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial

from heave_msgs.msg import TickRoster, TickStatus
from rclpy.duration import Duration
from rclpy.lifecycle import LifecycleState, TransitionCallbackReturn

from heave_node.cdr.layout import LayoutError
from heave_node.interface import topics
from heave_node.ros.diagnostics import Health, Level
from heave_node.ros.node import HeaveNode, steady_clock
from heave_node.ros.silence import Patience, Silence
from heave_node.ros.transport.real_time import after_tick
from heave_node.tick import malformed
from heave_node.tick.malformed import ProtocolError, expect_no, expect_sender
from heave_node.tick.protocol import Part, Past
from heave_node.tick.punctuality import Punctuality
from heave_node.tick.roster import KnownRoster
from heave_node.tick.tick import Tick

CATCH_UP_SHARE = 0.4
"""Share of a tick for which a node that was held up takes messages in before it makes up for ticks."""
CATCH_UP_LIMIT = 0.2
"""Wall time for which a node makes up for the ticks that it is behind, before it jumps to the newest one [s]."""
REPORTED_TIMEOUT = 2.0
"""Wall time in which the clock master must be found, and hear why a node has ended [s]."""
HELD_MESSAGES = 1000
"""Messages of the protocol that wait at most for the roster to say who may publish."""


class ParticipantNode(HeaveNode):
    """Base of every node but the clock master.

    A node sets `name`, `parameters_type` and `after`, makes its component, inputs and outputs in `on_build`, and does
    its part of a tick in `on_tick`. `lag` is the number of ticks that it may be behind the others (a recorder).
    `starts_ahead`: it reads nothing within ticks, and begins each while the plant integrates to its start.
    `punctuality` reports, in real time, whether ticks began late or this node was. A node that is behind in real time
    makes up for the ticks that it missed, and, where that takes too long, jumps to the newest one: `on_left_out` gets
    those between.
    """

    starts_ahead: bool = False

    def on_tick(self, tick: Tick) -> None:
        """Do this node's part of `tick`: take the inputs, step the component, publish the outputs."""

    def on_inactive_tick(self, tick: Tick) -> None:
        """Let time pass in a `tick` in which this node is inactive: it gets no inputs and must publish nothing."""

    def on_left_out(self, tick: Tick) -> None:
        """Let time pass in a `tick` that this node, being behind in real time, jumps over; it must publish nothing."""

    def prepare(self, number: int) -> None:
        """Work out in advance, while the others are in their tick, what needs nothing of them in tick `number`."""

    def join_protocol(self) -> None:
        """Make the publisher and the subscriptions by which a participant follows the clock master and answers it."""
        self.punctuality = Punctuality()
        self._starts: deque[Part] = deque()
        self._done_with: Part | None = None
        self._answered = Part()
        self._sent: Part | None = None
        self._roster: TickRoster | None = None
        self._known = KnownRoster()
        self._early: deque[Callable[[], None]] = deque(maxlen=HELD_MESSAGES)
        self._silence = Silence()
        self._patience = Patience()
        self._left_out = self._lost = 0
        self._making_up_since = math.inf
        self._is_advancing = False
        self._done = self.add_apart(topics.tick_done_topic(self.name))
        self.create_protocol_subscription(topics.TICK_ROSTER, self._on_roster)
        if self.hears_past:
            self.subscribe_to_parts(topics.TICK_PAST, self._on_past, Past)
        else:
            self.subscribe_to_parts(topics.TICK_AHEAD if self.starts_ahead else topics.TICK_LEAD, self._on_lead)
        self.create_protocol_subscription(topics.TICK_STATUS, self._on_status)
        for node in self.gate.after:
            self.hear_parts(node)
        if not self.run.is_lockstep:
            wait = self.run.in_tick_wait * self.run.tick_period
            self._deadline = self.create_timer(wait, self._on_deadline, clock=steady_clock())
            self._deadline.cancel()
            self._catch_up = self.create_timer(
                CATCH_UP_SHARE * self.run.tick_period, self._on_catch_up, clock=steady_clock()
            )
            self._catch_up.cancel()

    def on_part(self, node: str, part: Part, identity: str, *, is_whole: bool = True) -> None:
        """See HeaveNode."""
        if not self.has_started:
            self._early.append(lambda: self.on_part(node, part, identity, is_whole=is_whole))
            return
        expect_sender(identity, self._known.identity_of(node))
        expect_no(malformed.fault_in_part(part, self._known.outputs_of(node)))
        if is_whole:
            self.take_messages(node, part.published[0], part)
        self.gate.peer_done(node, part.epoch, part.tick, part.published)
        self._advance()

    def _on_roster(self, message: TickRoster, identity: str) -> None:
        """Take the roster of the run that this very process takes part in, and the process that sent it as master."""
        expect_no(malformed.fault_in_roster(message))
        if self.has_started:
            expect_sender(identity, self._known.master)
            if message == self._roster:
                return  # sent again for one that has not got it
        elif (self.name, self.identity) not in zip(message.nodes, message.identities, strict=True):
            self._known.other_master = identity
            return
        self._roster = message
        self._known.take(identity, message.epoch, message.nodes, message.identities)
        self.on_roster(message)
        early, self._early = self._early, deque(maxlen=HELD_MESSAGES)
        for handle in early:
            with suppress(ProtocolError):  # of strangers, before the run began
                handle()

    def on_roster(self, message: TickRoster) -> None:
        """Begin a run: `message` says who takes part and how messages are counted."""
        self._silence.end()
        self.gate.set_roster(message.nodes, message.topics, message.identities)
        self.has_started = True
        self.look_for_hearers()
        if round(message.tick_period * 1e9) != self.run.tick_nanoseconds:
            self.fail(
                f"tick_period is {self.run.tick_period} s here, but {message.tick_period} s at the clock master: "
                "set it once, under /** of the scenario"
            )
        self._begin_next()

    def _on_past(self, past: Past, identity: str) -> None:
        """Take in what the nodes that this one hears have sent in a few ticks, in the order of the clock master."""
        if not self.has_started:
            self._early.append(lambda: self._on_past(past, identity))
            self._leave_foreign_run(past, identity)
            return
        expect_sender(identity, self._known.master)
        heard = {entry: node for entry, node in enumerate(self._known.nodes) if node in self._ports.of_past}
        try:
            for entry, part in past.parts_of({0, *heard}):
                if entry == 0:  # the clock master's come first
                    self._on_lead(part, identity)
                else:
                    self.on_part(heard[entry], part, self._known.identity_of(heard[entry]))
        except LayoutError:
            raise ProtocolError("it cannot be decoded") from None

    def _on_lead(self, message: Part, identity: str) -> None:
        """Queue a tick. A tick that came before is the master asking again for an answer that it did not get."""
        if not self.has_started:
            self._early.append(lambda: self._on_lead(message, identity))
            self._leave_foreign_run(message, identity)
            return
        expect_sender(identity, self._known.master)
        master = self._known.nodes[0]
        expect_no(malformed.fault_in_lead(message, len(self._known.nodes), self._known.outputs_of(master)))
        self.take_messages(master, message.published[0], message)
        self._silence.end()
        newest = self._starts[-1] if self._starts else self._done_with
        if newest is None or _order(message) > _order(newest):
            self._starts.append(message)
            if not self.run.is_lockstep:
                self.clock_of_run.tick_began(message.stamp, time.monotonic_ns())
                self.punctuality.entered(message.stamp, self.protocol_times.sent, time.time_ns())
            if not self.run.is_lockstep and self.punctuality.newest_of_node > self.run.tick_period:
                # held up: each tick that is made up for shall see its own readings, which come in first
                if self._catch_up.is_canceled():
                    self._catch_up.reset()
            elif len(self._starts) == 1:
                self._begin_next()
            elif not self.run.is_lockstep and self._is_in_tick() and not self._is_taking_in():
                self._step()
        elif _order(message) == _order(newest):
            self._answer_again()

    def _is_taking_in(self) -> bool:
        """Return whether a node that is behind takes messages in, before it does any tick."""
        return not self.run.is_lockstep and not self._catch_up.is_canceled()

    def _on_catch_up(self) -> None:
        """Make up for the ticks that have queued up, up to the newest one."""
        self._catch_up.cancel()
        if not self._is_in_tick():
            self._begin_next()
        while len(self._starts) > 1 and not self.failure:
            self._step()
        self._advance()

    def _jump_if_behind(self) -> None:
        """Where making up for ticks takes too long, leave out those in the queue but for the newest.

        The end of a run is no tick, and is not left out.
        """
        now = time.monotonic()
        if len(self._starts) < 2:
            self._making_up_since = math.inf
        self._making_up_since = min(self._making_up_since, now)
        if now - self._making_up_since < CATCH_UP_LIMIT:
            return
        self._making_up_since = math.inf
        while len(self._starts) > 1 and not self._starts[0].flush:
            tick = Tick(self._starts.popleft().tick, self.epoch, self.run.tick_nanoseconds)
            self._left_out += 1
            self.fail_on_error(partial(self.on_left_out, tick))

    def diagnose_timing(self) -> list[Health]:
        """Add how many ticks this node had to leave out."""
        if not self._left_out:
            return super().diagnose_timing()
        text = f"{self._left_out} ticks left out: this node takes too long"
        return [Health("ticks", Level.WARN, text), *super().diagnose_timing()]

    def _leave_foreign_run(self, message: Part | Past, identity: str) -> None:
        """End this node where the run that is under way began without it."""
        if self.run.is_lockstep and self._known.other_master == identity and message.tick > 1 + self.lag:
            self.fail(
                f"started too late: a run is already at tick {message.tick} in this ROS domain; wait for its end, or "
                "set another ROS_DOMAIN_ID"
            )

    def _begin_next(self) -> None:
        """Enter the oldest tick of the queue, once its roster is known."""
        if not self.run.is_lockstep:
            self._jump_if_behind()
        if not self._starts or self._starts[0].epoch > self._known.epoch:
            return
        start = self._starts[0]
        if start.epoch > self.epoch:
            if self.epoch > 0:
                self.reset_run()
            self.epoch = start.epoch
        self.tick = Tick(start.tick, start.epoch, self.run.tick_nanoseconds)
        self.gate.begin(start.epoch, start.tick, start.published)
        if not self.run.is_lockstep:
            self._deadline.reset()
        if start.flush:
            self._patience = Patience()
        self._advance()

    def _advance(self) -> None:
        if self._is_advancing:
            return
        self._is_advancing = True
        while self._is_in_tick() and not self._is_taking_in() and self._is_complete() and not self.failure:
            self._step()
        self._is_advancing = False

    def _is_complete(self) -> bool:
        """Return whether this node can do its part of the tick; at the end in real time what is lost must be known."""
        start = self._starts[0]
        is_last = start.flush and not self.run.is_lockstep
        return self.gate.is_complete() and not (is_last and self.missing(start.published))

    def missing(self, published: Sequence[int]) -> int:
        """Return how many messages have not come to this node; asked at the end of a run in real time.

        `published` counts the messages of the run, per entry of the roster.
        """
        del published  # the gate has counted them
        return self.gate.lost()

    def _is_in_tick(self) -> bool:
        """Return whether this node has entered the oldest tick of the queue."""
        if not self._starts or self.tick is None:
            return False
        return (self.tick.epoch, self.tick.number) == (self._starts[0].epoch, self._starts[0].tick)

    def _on_deadline(self) -> None:
        """Step with what has arrived: in real time a node waits no longer."""
        self._deadline.cancel()
        if self._is_in_tick() and not self._is_taking_in() and not self._starts[0].flush:
            self._step()

    def _step(self) -> None:
        """Do this node's part of the tick, answer, and enter the next tick if one is queued."""
        if not self.run.is_lockstep:
            self.own_time.began()
        start = self._starts.popleft()
        tick = self.tick
        assert tick is not None
        if start.flush:
            self._lost = 0 if self.run.is_lockstep else self.missing(start.published)
            self.fail_on_error(lambda: self.on_flush(tick))
            self.gate.end_run()
        else:
            self.fail_on_error(lambda: self._do_tick(tick))
        if self.failure:
            return
        self._done_with = start
        self._answer(start, is_due=start.flush or self.answers(start.tick))
        if not self.run.is_lockstep:
            self.own_time.ended(1e-9 * (self.clock_of_run.now(time.monotonic_ns()) - start.stamp))
            if self.is_active and not start.flush:
                self.fail_on_error(lambda: self.report(tick, is_answered=True))
        if not self._starts and not start.flush and start.tick < self.run.tick_count:
            self.fail_on_error(lambda: self.prepare(start.tick + 1))
        after_tick()
        self._begin_next()

    def _do_tick(self, tick: Tick) -> None:
        if self.is_active:
            self.on_tick(tick)
            self.report(tick, is_answered=False)
        else:
            self.gate.clear()
            self.on_inactive_tick(tick)

    def on_flush(self, tick: Tick) -> None:
        """Take the last messages of a run; `tick` follows the last one and has no step of its own."""

    def answers(self, tick: int) -> bool:
        """Return whether this node answers for the tick of this number: one that may lag does so for many at a time."""
        return tick % max(1, self.lag // 2) == 0

    def before_answer(self) -> None:
        """Make what was done so far last: an answer vouches for it."""

    def _answer(self, start: Part, *, is_due: bool) -> None:
        """Send this node's part of the tick that began with `start`; one that `is_due` says that the tick is done."""
        if is_due:
            self.fail_on_error(self.before_answer)
            if self.failure:
                return
            self._answered = start
        if not is_due and not self._ports.carried:
            return
        carried, done = self.take_carried(), self._answered
        lost = self._lost if done.flush else 0
        self._sent = Part(done.tick, done.epoch, self.published_counts(), carried, lost)
        self.send_part(self._sent)
        if is_due and self._done.is_heard:
            self._done.publish_uncounted(self._sent.to_done())

    def _answer_again(self) -> None:
        """Send this tick's messages and answer again, or say what is missing."""
        if self._starts or self._done_with is None:
            self.publish_join(self.gate.missing())
            return
        if self._sent is not None:
            self.send_again_alone(self._sent)
            self.send_part(self._sent)
        if self._answered is not self._done_with:
            self._answer(self._done_with, is_due=True)
        elif self._sent is not None and self._done.is_heard:
            self._done.publish_uncounted(self._sent.to_done())

    def _on_status(self, message: TickStatus, identity: str) -> None:
        if self.has_started:
            expect_sender(identity, self._known.master)
        expect_no(malformed.fault_in_status(message))
        self._silence.end()
        if self.protocol_times.sent:
            delay = 1e-9 * (time.time_ns() - self.protocol_times.sent)
            self.protocol_times.least_delay = min(delay, self.protocol_times.least_delay or delay)
        if message.state in (TickStatus.ENDED, TickStatus.FAILED) and self.has_started and not self.finished.done():
            self.fail_on_error(lambda: self.on_run_ended(message))
            self.finish()

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Wait for the clock master from now on; `state` is the lifecycle state before."""
        self._silence.end()
        return super().on_activate(state)

    def on_idle(self) -> None:
        """End the node when the clock master has been silent for too long, and a wait for what does not come."""
        if not self.has_joined:
            return
        if not self.run.is_lockstep and self._is_in_tick() and self._starts[0].flush:
            self._advance()
            if self._starts and self._patience.is_over(self.missing(self._starts[0].published)):
                self._step()
        limit = self.run.participant_timeout if self.has_started else self.run.start_timeout
        silence = self._silence.look()
        if (self.is_active or self.has_started) and silence > limit:
            name = "".join(f" {node}" for node in self._known.nodes[:1])
            self.fail(f"no message from the clock master{name} for {silence:.1f} s{self._where_it_is()}")

    def _where_it_is(self) -> str:
        """Return in words, for one that has not been heard in a run yet, whether there is a clock master at all."""
        if self.has_started:
            return ""
        seen = self.count_publishers(self.resolve_topic_name(topics.TICK_STATUS.name))
        return ": it is in this ROS domain, but cannot be heard" if seen else ": there is none in this ROS domain"

    def wait_until_heard(self) -> None:
        """Let the clock master know why this node has ended before the run, so that nobody waits for it.

        In real time another process may take the place of one that was ended by a signal: there the run goes on.
        """
        is_of_run = bool(self.failure) and self.exchange is None and (self.run.is_lockstep or not self.was_ended)
        if not is_of_run:
            return
        deadline = time.monotonic() + REPORTED_TIMEOUT
        while not self.has_started and not self._ports.join.get_subscription_count() and time.monotonic() < deadline:
            time.sleep(0.02)
        self.publish_join()
        self._ports.join.wait_for_all_acked(Duration(seconds=REPORTED_TIMEOUT))


def _order(message: Part) -> tuple[int, int]:
    return (message.epoch, message.tick)
