"""The clock master: it begins each tick when all have done the previous one (lockstep), or by the wall clock (real
time).

The node that derives from `ClockMasterNode` owns the plant: it publishes what holds at t_k, and integrates to t_{k+1}
when the others have answered.
"""

from __future__ import annotations

import time

from heave_msgs.msg import TickJoin, TickRoster, TickStatus
from heave_msgs.srv import StepSimulation
from rclpy.duration import Duration
from rclpy.lifecycle import LifecycleState, TransitionCallbackReturn
from rclpy.timer import Timer
from std_srvs.srv import SetBool, Trigger

from heave_node.cdr.packer import Packer
from heave_node.interface import topics
from heave_node.interface.alarm import NODE_ALARMS
from heave_node.interface.topic import Topic
from heave_node.ros.diagnostics import Health, Level, alarm_health
from heave_node.ros.input_timing import timing_health
from heave_node.ros.node import HeaveNode, steady_clock
from heave_node.ros.ports import PassedOn
from heave_node.ros.silence import MasterWaits, Patience
from heave_node.ros.transport.host_clocks import HostClocks
from heave_node.ros.transport.identity import describe_sender, host_of, identity_of_endpoint
from heave_node.ros.transport.qos import mismatches
from heave_node.ros.transport.real_time import after_tick
from heave_node.tick import malformed
from heave_node.tick.loop_timing import LoopTiming
from heave_node.tick.malformed import ProtocolError, expect_no, expect_sender
from heave_node.tick.protocol import Part
from heave_node.tick.roster import NOT_WAITED_FOR, Participant, Roster
from heave_node.tick.speakers import Speakers
from heave_node.tick.tick import Tick

SUPERVISION_PERIOD = 0.05
"""Wall time between two checks for missing answers [s]."""
STATUS_PERIOD = 0.25
"""Wall time between two TickStatus messages [s]."""
RECENT_TICKS = 1000
"""Ticks that the loop age in a status covers; the one in the last status covers all."""
WARNING_PERIOD = 1.0
"""Wall time between two warnings about a missing node [s]."""
MISMATCH_PATIENCE = 0.5
"""Wall time for which publisher and reader must seem not to match before the run is refused [s]."""
STOP_RECORDING_TIME = 3.0
"""Real time: wall time for which a run goes on after a node failed, so that the bag shows how the winch stops [s]."""
LAST_STATUS_TIMEOUT = Duration(seconds=2)
"""Wall time that the last status may take to be acknowledged by every subscriber."""

_CLOCK = Packer(topics.CLOCK.type, ("clock",))


class ClockMasterNode(HeaveNode):
    """Base of the node that steps the clock. It publishes in `on_readings` and integrates in `on_advance`."""

    # What a master fills in ----------------------------------------------------------------------------------------

    def on_readings(self, tick: Tick) -> None:
        """Publish the state and the sensor readings that are due at t_k, the start of `tick`."""

    def on_advance(self, tick: Tick) -> None:
        """Integrate from t_k to t_{k+1}, from start to end of `tick`, with the newest inputs."""

    # Start barrier -------------------------------------------------------------------------------------------------

    def join_protocol(self) -> None:
        """Make the publishers and subscriptions by which the master leads the participants, and its services."""
        peers = [name for name in self.run.participants if name not in self.run.external and name != self.name]
        self.roster = Roster([self.name, *peers])
        self.timing = LoopTiming()
        self.own_time.ages = self.timing.ages
        self._speakers: dict[str, Speakers] = {}
        self.run_state = TickStatus.WAITING
        self._reason = ""
        self._mismatch = Patience(MISMATCH_PATIENCE)
        self._stepped = True
        self._failed_participant: tuple[str, float] | None = None
        self._patience = Patience()
        self._host_clocks = HostClocks()
        self._pause_at: int | None = None
        self._reset_wanted = False
        self._clock_started_at = 0.0
        self._waits = MasterWaits()
        self._lead = self._ahead = Part()
        self._clock_output = self.add_output(topics.CLOCK)
        self._past = PassedOn(self.add_plain(topics.TICK_PAST), is_in_memory=self.exchange is not None)
        self._ahead_output = self.add_plain(topics.TICK_AHEAD)
        self._roster_publisher = self.make_publisher(topics.TICK_ROSTER)
        self._status_publisher = self.make_publisher(topics.TICK_STATUS)
        self._start = self.add_apart(topics.TICK_START)
        self.create_protocol_subscription(topics.TICK_JOIN, self._on_join)
        for node in peers:
            self.hear_parts(node)
        self.create_service(SetBool, "simulation/pause", self._serve_pause)
        self.create_service(StepSimulation, "simulation/step", self._serve_step)
        self.create_service(Trigger, "simulation/reset", self._serve_reset)
        self.create_timer(SUPERVISION_PERIOD, self._supervise, clock=steady_clock())
        # made here: an executor that takes in a new timer serves nobody meanwhile, for up to 0.1 s
        self._wall_clock: Timer = self.create_timer(self.run.tick_period, self._follow_wall_clock, clock=steady_clock())
        self._wall_clock.cancel()

    def _on_join(self, message: TickJoin, identity: str) -> None:
        expect_no(malformed.fault_in_join(message))
        expect_sender(identity, message.identity)
        self.strangers.note_host(identity, message.host)
        self._host_clocks.heard(message.node, self.protocol_times.sent, time.time_ns(), message.least_delay)
        if message.node not in self.roster.expected:
            return
        known = self.roster.participants.get(message.node)
        if known is not None and known.identity != message.identity:
            self._judge_second(known, message)
        if message.failure:
            self._note_failed(message)
        elif known is not None and self.has_started:
            known.waiting_for = message.waiting_for
        else:
            self.roster.join(
                Participant(
                    message.node,
                    identity=message.identity,
                    host=message.host,
                    ready=message.ready,
                    lag=message.lag,
                    outputs=dict(zip(message.outputs, message.matched_subscriptions, strict=True)),
                    inputs=dict(zip(message.inputs, message.matched_publishers, strict=True)),
                    waiting_for=message.waiting_for,
                )
            )

    def _note_failed(self, message: TickJoin) -> None:
        """End the run in which a node has failed: at once, in real time once the bag shows how the winch stops."""
        is_waited_for = message.lag != NOT_WAITED_FOR
        if is_waited_for and self._failed_participant is None:
            delay = 0.0 if self.run.is_lockstep or not self.has_started else STOP_RECORDING_TIME
            self._failed_participant = (f"{message.node}: {message.failure}", time.monotonic() + delay)

    def _judge_second(self, known: Participant, message: TickJoin) -> None:
        """Let a second process of a node's name take its place where the first has left; refuse it where not."""
        joined = self.resolve_topic_name(topics.TICK_JOIN.name)
        present = {identity_of_endpoint(info) for info in self.get_publishers_info_by_topic(joined)}
        if known.identity in present or (self.has_started and self.run.is_lockstep):
            raise ProtocolError(
                f"node {known.name} is already running on {known.host}; the second one, on {message.host}, is ignored"
            )
        known.identity, known.host = message.identity, message.host
        if self.has_started:
            self._publish_roster()
            self._speakers = self._appoint_speakers()

    def _external_topics(self, *, needed: bool = False) -> list[str]:
        """Return the resolved names of the topics of external nodes; `needed`: that the loop does not close without."""
        external = [topic for topic in topics.ALL_TOPICS if self.run.is_external(topic)]
        return [self.resolve_topic_name(topic.name) for topic in external if topic.is_needed or not needed]

    def _mismatch_of_external(self) -> str:
        """Return in words why an external node and a node of the run cannot hear each other; "" where they can.

        A mismatch counts when it has stood for MISMATCH_PATIENCE: before, the graph may not know all of it yet.
        """
        found = "; ".join(
            text for topic in self._external_topics() for text in mismatches(self, topic, self.roster.expected)
        )
        return found if self._mismatch.is_over(found) else ""

    def _rivals(self) -> list[str]:
        """Describe on which topics several external processes publish: none of them would be the right one."""
        found = []
        for name in self._external_topics():
            identities = {identity_of_endpoint(info) for info in self.get_publishers_info_by_topic(name)}
            if len(identities) > 1:
                who = " and ".join(describe_sender(self, name, one, self.identity) for one in sorted(identities))
                found.append(f"{who} to agree on who publishes {name}")
        return found

    def _try_to_start(self) -> None:
        mismatch = self._mismatch_of_external()
        if mismatch:
            self._end(TickStatus.FAILED, mismatch)
            return
        published = {topic: self.count_publishers(topic) for topic in self._external_topics()}
        lacking = [*self.roster.missing(published, self._external_topics(needed=True)), *self._rivals()]
        self._reason = "; ".join(lacking)
        if not lacking and self._may_start_by_clocks():
            self.roster.freeze()
            self._begin_run()
            if not self.run.is_lockstep:
                self._clock_started_at = time.monotonic()
                self._wall_clock.reset()

    def _on_other_hosts(self) -> dict[str, str]:
        """Return the names of the participants on other hosts, with the names of these."""
        here = host_of(self.identity)
        others = (p for p in self.roster.participants.values() if host_of(p.identity) not in ("", here))
        return {p.name: p.host for p in others}

    def _may_start_by_clocks(self) -> bool:
        """Show how far the clocks of other hosts are from this one's; in real time refuse a run where it is too far."""
        others = self._on_other_hosts()
        unknown = self._host_clocks.awaited(others)
        if unknown:
            self._reason = f"the clock of {', '.join(unknown)}"
            return False
        far = "" if self.run.is_lockstep else self._host_clocks.too_far(others, self.run.clock_offset_limit)
        if far:
            self._end(TickStatus.FAILED, far)
            return False
        if others:
            reported = self._host_clocks.words(others) or "not known"
            self.get_logger().info(f"clocks of other hosts, ahead of this one's: {reported}")
        return True

    def _begin_run(self) -> None:
        """Begin a run (an epoch): publish the order of the counters, and begin tick 1."""
        self.epoch += 1
        self._publish_roster()
        self._speakers = self._speakers or self._appoint_speakers()
        self.has_started = True
        self.look_for_hearers()
        self.run_state = TickStatus.RUNNING
        self.timing.run_began()
        if self.run.is_lockstep:
            self._begin_tick(1)

    def _publish_roster(self) -> None:
        self._roster_publisher.publish(
            TickRoster(
                epoch=self.epoch,
                nodes=self.roster.nodes,
                identities=self.roster.identities,
                topics=self.roster.topics,
                tick_period=self.run.tick_period,
                lockstep=self.run.is_lockstep,
            )
        )
        self.gate.set_roster(self.roster.nodes, self.roster.topics, self.roster.identities)

    def _appoint_speakers(self) -> dict[str, Speakers]:
        """Return who may publish on each topic that one node owns, by resolved name."""
        of_master = (topics.TICK_AHEAD, topics.TICK_LEAD, topics.TICK_PAST, topics.TICK_START)
        lawful = {topic.name: [self.identity] for topic in (*of_master, topics.TICK_ROSTER, topics.TICK_STATUS)}
        for p in self.roster.participants.values():
            of_node = (topics.tick_done_topic(p.name), topics.tick_part_topic(p.name))
            lawful |= {topic.name: [p.identity] for topic in of_node}
        owned = {topic.name: topic for topic in topics.ALL_TOPICS if topic.publisher}
        lawful |= {name: self.roster.identities_of(self.resolve_topic_name(name)) for name in owned}
        speakers: dict[str, Speakers] = {}
        for name, identities in lawful.items():
            is_external = name in owned and self.run.is_external(owned[name])
            speakers[self.resolve_topic_name(name)] = Speakers(is_external=is_external)
            if not is_external:
                speakers[self.resolve_topic_name(name)].appoint(identities)
        return speakers

    def diagnose_inputs(self) -> list[Health]:
        """Add which external node cannot be heard: one that came, or came again, when the run had begun."""
        mismatch = self._mismatch_of_external()
        if not mismatch:
            return super().diagnose_inputs()
        unheard = NODE_ALARMS.alarm("EXTERNAL_NODE_UNHEARD", mismatch=mismatch)
        return [*super().diagnose_inputs(), alarm_health("external nodes", unheard)]

    def diagnose_timing(self) -> list[Health]:
        """Add the loop age of every tick, those that missed their deadline too."""
        if self.run.is_lockstep or not len(self.timing.ages):
            return []
        reported = self._host_clocks.words(self._on_other_hosts())
        clocks = [Health("clocks of other hosts", Level.OK, reported)] if reported else []
        ages = timing_health("loop age", self.timing.ages, missed_deadlines=str(self.timing.missed_deadlines))
        return [ages, *clocks, *super().diagnose_timing()]

    # Ticks ---------------------------------------------------------------------------------------------------------

    @property
    def tick_number(self) -> int:
        """Number of the current tick; 0 before the first."""
        return 0 if self.tick is None else self.tick.number

    def _begin_tick(self, number: int) -> None:
        tick = Tick(number, self.epoch, self.run.tick_nanoseconds)
        self.tick, self._stepped = tick, False
        if not self.run.is_lockstep:
            self.clock_of_run.tick_began(tick.start_nanoseconds, time.monotonic_ns())
        self.timing.tick_began(number)
        self._clock_output.publish(_CLOCK.pack(tick.start_nanoseconds))
        self.fail_on_error(lambda: self._publish_readings(tick))
        if not self.failure:
            self._send_start(tick, flush=False)
            self.fail_on_error(lambda: self.report(tick, is_answered=True))

    def _publish_readings(self, tick: Tick) -> None:
        self.on_readings(tick)
        self.report(tick, is_answered=False)

    def _announce(self, tick: Tick, *, flush: bool = False) -> None:
        """Let those that read nothing in a `tick`, or in the `flush`, begin it; once."""
        if (self._ahead.tick, self._ahead.epoch) != (tick.number, tick.epoch):
            self._ahead = Part(tick.number, tick.epoch, self.roster.counters, (), 0, tick.start_nanoseconds, flush)
            self.send_part(self._ahead, self._ahead_output)

    def _send_start(self, tick: Tick, *, flush: bool) -> None:
        self._announce(tick, flush=flush)
        carried = self.take_carried()
        self.roster.answer(self.name, tick.number, self.published_counts())
        counters = self.roster.counters
        self.gate.begin(self.epoch, tick.number, counters)
        self._lead = Part(tick.number, self.epoch, counters, carried, 0, tick.start_nanoseconds, flush)
        self._send_lead()
        self._past.add(0, self._lead)
        if flush or self._past.is_due(tick.number):
            self._past.send(self.tick_number, self.epoch)
        if self._waits.has_recovered():
            self.get_logger().info("all nodes answer again")
            self.publish_protocol_notice("all nodes answer again", Level.OK)
        self._waits.sent(self.run.resend_period)

    def _send_lead(self) -> None:
        self.send_part(self._lead)
        if self._start.is_heard:
            self._start.publish_uncounted(self._lead.to_start())

    @property
    def part_topic(self) -> Topic:
        """See HeaveNode: the master's parts lead the others."""
        return topics.TICK_LEAD

    def on_part(self, node: str, part: Part, identity: str, *, is_whole: bool = True) -> None:
        """See HeaveNode."""
        participant = self.roster.participants.get(node)
        if participant is None or not self.has_started:
            return
        expect_sender(identity, participant.identity)
        expect_no(malformed.fault_in_part(part, len(participant.outputs)))
        if is_whole and self.take_messages(node, part.published[0], part) and part.messages and self.run.is_lockstep:
            self._past.add(participant.entry, part)
        if part.epoch == self.epoch:
            self.roster.answer(node, part.tick, part.published)
            participant.lost = part.lost
            self.gate.peer_done(node, part.epoch, part.tick, part.published)
            self.timing.answered_up_to(self.roster.answered_by_all())
            self._advance()

    def _advance(self) -> None:
        """End the tick as soon as all have answered and all inputs have come."""
        tick = self.tick
        if self._stepped or tick is None or self.failure:
            return
        if self.roster.unanswered(tick.number, flush=self._lead.flush) or not self._has_all_inputs():
            return
        self._stepped = True
        if self._lead.flush:
            self._end_of_flush()
            return
        if self.run.is_lockstep:
            self._end_tick(tick)
        else:
            after_tick()

    def _has_all_inputs(self) -> bool:
        """Return whether all inputs of the tick are here; at the end in real time, whether no more of them come."""
        if self.gate.is_complete():
            return True
        return self._lead.flush and not self.run.is_lockstep and self._patience.is_over(self.gate.lost())

    def _end_tick(self, tick: Tick) -> None:
        """Integrate to the end of a `tick`, and go on; who reads nothing in the next one works meanwhile."""
        last = self.run.tick_count if self._pause_at is None else min(self._pause_at, self.run.tick_count)
        if tick.number < last and not self._reset_wanted:
            self._announce(Tick(tick.number + 1, self.epoch, self.run.tick_nanoseconds))
        self.fail_on_error(lambda: self.on_advance(tick))
        self._begin_what_follows()

    def _begin_what_follows(self) -> None:
        """Go on after a tick: to the next one, to the end, to a pause or to a new run."""
        if self.failure:
            return
        if self._reset_wanted or self.tick_number >= self.run.tick_count:
            self._begin_flush()
        elif self._pause_at is not None and self.tick_number >= self._pause_at:
            self.run_state = TickStatus.PAUSED
            self._past.send(self.tick_number, self.epoch)
        else:
            self._begin_tick(self.tick_number + 1)

    def _follow_wall_clock(self) -> None:
        """Begin the ticks that are due; a machine that is late catches up, and its missed deadlines are counted.

        After a tick period of that what the others have sent is taken in, so that the plant does not live in the past.
        """
        began = time.monotonic()
        elapsed = round((began - self._clock_started_at) / self.run.tick_period)
        while self.run_state == TickStatus.RUNNING and not self.failure and not self._lead.flush:
            if self.tick_number >= elapsed or time.monotonic() - began > self.run.tick_period:
                return
            self.own_time.began()
            tick = self.tick
            if tick is not None:
                self._note_end_of(tick)
                self._end_tick(tick)
            else:
                self._begin_tick(1)
            self.own_time.ended()

    def _note_end_of(self, tick: Tick) -> None:
        """Count a tick that is over before its inputs came: nobody waits for what a recorder, which may lag, has."""
        if not self._stepped:
            has_inputs = self.roster.answered_by_all() >= tick.number and self.gate.is_complete()
            self.timing.missed_deadlines += not has_inputs
            after_tick()
        self._stepped = True

    # Pause, step, reset --------------------------------------------------------------------------------------------

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Resume the run where it is, or wait for its nodes; `state` is the lifecycle state before."""
        result = super().on_activate(state)
        if self.has_started:
            self._resume(until=None)
        else:
            self._waits = MasterWaits()
        return result

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop the clock after this tick: the run pauses. `state` is the lifecycle state before."""
        self._pause_at = self.tick_number
        return super().on_deactivate(state)

    def _serve_pause(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        response.success = self._may_be_controlled(response)
        if response.success and request.data:
            self._pause_at = self.tick_number
        elif response.success:
            self._resume(until=None)
        return response

    def _may_be_controlled(self, response: SetBool.Response | StepSimulation.Response | Trigger.Response) -> bool:
        """Say in the `response` where the run is, and refuse what an inactive clock cannot do."""
        response.message = f"tick {self.tick_number}" if self.is_active else f"{self.name} is inactive: activate it"
        return self.is_active

    def _serve_step(
        self, request: StepSimulation.Request, response: StepSimulation.Response
    ) -> StepSimulation.Response:
        response.success = self._may_be_controlled(response) and self.run_state == TickStatus.PAUSED
        if self.is_active and not response.success:
            response.message = "not paused"
        elif response.success and request.ticks > 0:
            self._resume(until=self.tick_number + request.ticks)
        return response

    def _resume(self, until: int | None) -> None:
        self._pause_at = until
        if self.run_state != TickStatus.PAUSED:
            return
        self.run_state = TickStatus.RUNNING
        # The time of a pause does not count as delay, nor as a period: the tick that follows begins now.
        self.own_time.broke_off()
        self._clock_started_at = time.monotonic() - (self.tick_number + 1) * self.run.tick_period
        self._begin_what_follows()

    def _serve_reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        is_under_way = self.run_state in (TickStatus.RUNNING, TickStatus.PAUSED)
        response.success = self._may_be_controlled(response) and is_under_way
        if self.is_active:
            response.message = "a new run starts" if response.success else "no run is under way"
        if response.success:
            self._reset_wanted = True
            self._pause_at = None
            if self.run_state == TickStatus.PAUSED:
                self._resume(until=None)
        return response

    # End -----------------------------------------------------------------------------------------------------------

    def _begin_flush(self) -> None:
        """Ask all to answer when they have every message of the run: a publisher must not end before."""
        self.tick = Tick(self.tick_number + 1, self.epoch, self.run.tick_nanoseconds)
        self._stepped = False
        self.timing.wait_began()
        self._patience = Patience()
        self._send_start(self.tick, flush=True)

    def _end_of_flush(self) -> None:
        if not self._reset_wanted:
            lost = 0 if self.run.is_lockstep else self.gate.lost()
            self._end(TickStatus.ENDED, self.roster.lost_words(lost))
            return
        self._reset_wanted = False
        self.gate.end_run()
        self.roster.restart()
        self.tick = None
        self._lead = Part()
        self.reset_run()
        self._clock_started_at = time.monotonic()
        self._begin_run()

    def _end(self, state: int, reason: str) -> None:
        self.run_state, self._reason = state, reason
        if state == TickStatus.FAILED:
            self.fail(reason)
        self.finish()

    def on_exit(self) -> None:
        """Tell the others how the run ended, whatever the reason."""
        if self.run_state != TickStatus.ENDED:
            self.run_state, self._reason = TickStatus.FAILED, self.failure
        self._past.send(self.tick_number, self.epoch)
        self._publish_status()

    def wait_until_heard(self) -> None:
        """Wait until the others have the last status."""
        self._status_publisher.wait_for_all_acked(LAST_STATUS_TIMEOUT)

    # Supervision in wall time --------------------------------------------------------------------------------------

    def _supervise(self) -> None:
        """Start the run when all are ready; name nodes that are missing, and end a run that waits too long."""
        if self.finished.done() or not (self.is_active or self.has_started):
            return
        if self._waits.is_status_due(STATUS_PERIOD):
            self._publish_status()
        self.strangers.look(self._speakers)
        if self._failed_participant is not None and time.monotonic() >= self._failed_participant[1]:
            self._end(TickStatus.FAILED, self._failed_participant[0])
        elif self.run_state == TickStatus.WAITING:
            self._try_to_start()
            self._warn_or_give_up(self._waits.age, "start_timeout", self._reason)
        elif not self._stepped:
            self._look_for_missing()
            if self._lead.flush and not self.finished.done():
                self._advance()

    def _look_for_missing(self) -> None:
        """Send an unanswered tick again, and name the nodes that have not answered."""
        if (self.run.is_lockstep or self._lead.flush) and self._waits.is_resend_due():
            self.timing.resends += 1
            self.send_again_alone(self._lead)
            self._publish_roster()
            self.send_part(self._ahead, self._ahead_output)
            self._send_lead()
            self._past.send(self.tick_number, self.epoch, again=True)
        behind = self.roster.unanswered(self.tick_number, flush=self._lead.flush)
        text = "; ".join(
            f"{p.name} has not finished tick {p.answered + 1}"
            + (f" (waiting for {p.waiting_for})" if p.waiting_for else "")
            for p in sorted(behind, key=lambda p: bool(p.waiting_for))  # who waits for nobody holds up the others
        )
        waited = self.timing.age_of_tick
        if not self.run.is_lockstep and behind:
            waited += (self.tick_number - 1 - min(p.answered for p in behind)) * self.run.tick_period
        self._warn_or_give_up(waited, "participant_timeout", text or self.gate.missing())

    def _warn_or_give_up(self, waited: float, parameter: str, text: str) -> None:
        """Report each second what is missing; end the run after the time that a `parameter` of the run sets."""
        if not text or waited < WARNING_PERIOD:
            return
        limit = getattr(self.run, parameter)
        if waited > limit:
            self._end(TickStatus.FAILED, f"{text}: gave up after waiting {limit:g} s ({parameter})")
        elif self._waits.is_warning_due(WARNING_PERIOD):
            is_starting = self.run_state == TickStatus.WAITING  # then it is normal that nodes are not there yet
            if not is_starting:
                self._waits.note_late()
            warning = str(NODE_ALARMS.alarm("PARTICIPANT_LATE", time=waited, missing=text))
            self.get_logger().warning(warning)
            self.publish_protocol_notice(warning, Level.OK if is_starting else Level.ERROR)

    def _publish_status(self) -> None:
        is_over = self.run_state in (TickStatus.ENDED, TickStatus.FAILED)
        p50, p99, largest = self.timing.loop_age(last=None if is_over else RECENT_TICKS)
        time_now = self.tick.time if self.tick is not None else 0.0
        factor = self.timing.overall_factor if is_over else self.timing.real_time_factor
        totals = self.roster.published_by_topic() if is_over else {}
        self._status_publisher.publish(
            TickStatus(
                state=self.run_state,
                reason=self._reason,
                epoch=self.epoch,
                tick=self.tick_number,
                simulated_time=time_now,
                real_time_factor=factor(time_now),
                loop_age_p50=p50,
                loop_age_p99=p99,
                loop_age_max=largest,
                missed_deadlines=self.timing.missed_deadlines,
                resends=self.timing.resends,
                topics=list(totals),
                published=list(totals.values()),
            )
        )
