"""The thin ROS shell of every node of the suite: lifecycle, parameters, ports, diagnostics, one way to end.

Nodes do not derive from `HeaveNode` but from `participant.ParticipantNode` or, for the one that steps the clock,
`master.ClockMasterNode`.
"""

from __future__ import annotations

import inspect
import socket
import time
import traceback
from collections.abc import Callable

from builtin_interfaces.msg import Time
from heave_msgs.msg import TickJoin, TickStatus
from rclpy.clock import Clock, ClockType
from rclpy.lifecycle import LifecycleState, TransitionCallbackReturn
from rclpy.qos_overriding_options import InvalidQosOverridesError
from rclpy.task import Future
from rclpy.timer import Timer

from heave_node.errors import NodeError, one_line
from heave_node.interface import topics
from heave_node.interface.alarm import NODE_ALARMS
from heave_node.interface.codes import OPERATOR, time_key, timed_message
from heave_node.interface.topic import Topic
from heave_node.ros.diagnostics import Health, Level, alarm_health, diagnostic_array
from heave_node.ros.input_timing import TickTiming
from heave_node.ros.ported_node import PortedNode
from heave_node.ros.transport.real_time import collect_between_ticks, take_priority
from heave_node.tick.tick import Tick

JOIN_PERIOD = 0.05
"""Wall time between two TickJoin messages while the run has not started [s]."""
DIAGNOSTICS_PERIOD = 1.0
"""Simulated time between two DiagnosticArray messages [s]."""


class HeaveNode(PortedNode):
    """What participants and the clock master have in common.

    Attributes
    ----------
    has_joined : it is configured, or was about to be: it has its part of the tick protocol
    is_active : it takes part in ticks
    failure : why the node ended, "" while nothing went wrong; `failed_at` when [s of monotonic wall time]
    was_ended : a signal or a transition, not an error, ended it
    own_time : of this node's part of each tick
    """

    def __init__(self) -> None:
        super().__init__()
        self.finished: Future[None] = Future()

    def _begin_unconfigured(self) -> None:
        super()._begin_unconfigured()
        self.failure, self.failed_at = "", 0.0
        self.has_joined = self.is_active = self.was_ended = False
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

    # Lifecycle -----------------------------------------------------------------------------------------------------

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Build the component and join the tick protocol; `state` is the lifecycle state before."""
        self._ports.before = self._entities()
        self._ports.join = self.make_publisher(topics.TICK_JOIN)
        self._ports.part = self.add_plain(self.part_topic)
        try:
            self._diagnostics = self.add_output(topics.DIAGNOSTICS)
            self.own_time = TickTiming(self.name, self.run.time_budget_of(self.name), self.run.tick_period)
            self.join_protocol()
            self.has_joined = True
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
            JOIN_PERIOD,
            lambda: join_timer.cancel() if self.has_started else self.publish_join(),
            clock=steady_clock(),
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

    def is_ready(self) -> bool:
        """Return whether this node could begin tick 1."""
        return self.is_active

    def publish_join(self, waiting_for: str = "") -> None:
        """Tell the clock master what this node publishes and subscribes to, and why it has ended where it has.

        `waiting_for` says in words what the node lacks in this tick.
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

    def reset_run(self) -> None:
        """Drop what came late of the previous run, in real time, and make a new component."""
        if not self.run.is_lockstep:
            self.gate.clear()
            self.own_time.broke_off()
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

    def report(self, tick: Tick, *, is_answered: bool) -> None:
        """Publish the health of this node: with its part of `tick`, or in real time once that `is_answered`.

        How far a node is behind that lags is chance in lockstep: it would describe the machine, not the run.
        """
        is_due = not (is_answered or self.lag) if self.run.is_lockstep else is_answered
        if is_due:
            self.publish_diagnostics(tick)

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
        return [
            *self.own_time.diagnose(),
            *(part for timing in self._ports.timings.values() for part in timing.diagnose()),
        ]

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
            for code, count in (("INPUT_EARLY", port.early), ("INPUT_LATE", port.late)):
                if count:
                    parts.append(alarm_health(f"input {port.name}", NODE_ALARMS.alarm(code, count=count)))
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
        when = f" at t = {self.tick.time:.3f} s" if self.tick is not None and " t = " not in reason else ""
        self.failure, self.failed_at = f"{reason}{when}", time.monotonic()
        if error is not None:
            self.get_logger().debug("".join(traceback.format_exception(error)))
        self.finish()

    def finish(self) -> None:
        """End the spin loop."""
        if not self.finished.done():
            self.finished.set_result(None)

    def on_idle(self) -> None:
        """Look at the wall clock; called a few times per second from the spin loop."""


def steady_clock() -> Clock:
    """Return the clock for waits in wall time, which simulated time does not stop."""
    return Clock(clock_type=ClockType.STEADY_TIME)
