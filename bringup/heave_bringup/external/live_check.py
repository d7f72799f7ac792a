"""Listens to a live external node, and plays its fellow: the clock, a quiet sea, commands that never move."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from operator import attrgetter
from typing import Any

from heave_node.interface import topics
from heave_node.interface.messages import message_type
from heave_node.ros.process import leave_ros, node_beside
from heave_node.ros.spin import Spinner
from heave_node.ros.transport.environment import prepare_environment
from heave_node.ros.transport.identity import node_of_endpoint
from heave_node.ros.transport.qos import qos_of, reader_qos_of
from heave_node.tick.clock_rule import ClockRule
from heave_node.tick.tick import seconds_of, stamp_of_seconds
from rclpy.qos import QoSCompatibility, qos_check_compatible

from heave_bringup.errors import CommandError
from heave_bringup.external.check import Finding, Heard, Plan, WinchTrial, is_plausible, judge_topic, judge_winch
from heave_bringup.external.contract import TICK, Contract, Port

DISCOVERY = 1.5
"""Wall time in which nodes find each other [s]."""
SETTLING = 0.5
"""Wall time in which a node may say anything, while it hears its first messages [s]."""
QUIET_SEA = (0.05, 8.0)
"""Amplitude [m] and period [s] of the heave that a controller is shown."""
ME = "heave_check"


def check_node(
    contract: Contract, seconds: float, rule: ClockRule = ClockRule.DETECT, namespace: str = ""
) -> list[Finding]:
    """Listen to the live node that a contract is for, and return what was found.

    Parameters
    ----------
    contract : of the node
    seconds : wall time of each phase of the listening [s]
    rule : how the node stamps, as declared
    namespace : in which its topics are; "": none

    Raises CommandError where a run is under way in this ROS domain: the node would then take part in that run.
    """
    prepare_environment()
    listener = _Listener(contract, seconds, namespace)
    try:
        return listener.listen(rule)
    finally:
        listener.close()


class _Listener:
    """The other side of an external node."""

    def __init__(self, contract: Contract, seconds: float, namespace: str) -> None:
        self._contract = contract
        self._node = node_beside(ME, namespace)
        self._spinner = Spinner(self._node)
        self._plan = Plan(seconds, 2 * seconds, 2 * seconds + 2.5, 2 * seconds + 3.5, 2 * seconds + 6.0)
        self._heard = {port.topic.name: Heard() for port in contract.publishes}
        self._trial: list[WinchTrial] = []
        self._newest: dict[str, Any] = {}
        self._sequence = 0
        self._began = math.inf  # nothing counts before the clock runs
        self._publishers = {
            port.topic.name: self._node.create_publisher(
                message_type(port.topic.type), port.topic.name, qos_of(port.topic.role)
            )
            for port in contract.hears
            if port.topic in (topics.CLOCK, topics.MRU, topics.WINCH_STATE, topics.WINCH_COMMAND)
        }
        for port in contract.publishes:
            self._subscribe(port)

    def close(self) -> None:
        self._spinner.close()
        leave_ros(self._node)

    def listen(self, rule: ClockRule) -> list[Finding]:
        """Go through the plan and judge what came from a node whose clock has a `rule`."""
        self._spinner.spin_for(DISCOVERY)
        if self._node.count_publishers(topics.CLOCK.name) > 1:
            raise CommandError("a run is in progress in this ROS domain: end it, or set another ROS_DOMAIN_ID")
        self._began = time.monotonic()
        tick = 0
        while self._time < self._plan.end:
            tick += 1
            self._publish(tick)
            self._spinner.spin_for(max(tick * TICK - self._time, 0.0))
        for port in self._contract.publishes:
            self._survey(port)
        heard = [(port, self._heard[port.topic.name]) for port in self._contract.publishes]
        found = [line for port, came in heard for line in judge_topic(port, came, rule)]
        if not any(came.publishers for _, came in heard):
            found.insert(0, Finding("all", "publisher", is_good=False, words=self._elsewhere()))
        return found + (judge_winch(self._plan, self._trial) if self._trial else [])

    @property
    def _time(self) -> float:
        return time.monotonic() - self._began

    @property
    def _is_silent(self) -> bool:
        return self._plan.phase(self._time) == "silent"

    def _elsewhere(self) -> str:
        """Return in words where topics of these names have publishers, if not here."""
        wanted = tuple("/" + port.topic.name for port in self._contract.publishes)
        names = [name for name, _ in self._node.get_topic_names_and_types() if name.endswith(wanted)]
        there = sorted(name for name in names if self._node.count_publishers(name))
        if there:
            return f"nobody publishes any of these topics here; but there is {', '.join(there)}: see --namespace"
        return "nobody publishes any of these topics: is the node running, in this ROS_DOMAIN_ID, on this machine?"

    def _survey(self, port: Port) -> None:
        """Note who publishes a topic, and what does not match."""
        heard = self._heard[port.topic.name]
        for info in self._node.get_publishers_info_by_topic(port.topic.name):
            heard.publishers.append(node_of_endpoint(info))
            heard.types.append(info.topic_type)
            compatibility, reason = qos_check_compatible(
                info.qos_profile, reader_qos_of(port.topic.role, is_external=True)
            )
            if compatibility == QoSCompatibility.ERROR:
                heard.refusals.append(" ".join(reason.replace("ERROR: ", "").split()).rstrip(";"))

    def _subscribe(self, port: Port) -> None:
        heard = self._heard[port.topic.name]
        fields: dict[str, Callable[[Any], Any]] = {name: attrgetter(name) for name, _ in port.numbers}

        def on_message(message: Any) -> None:
            self._newest[port.topic.name] = message
            if port.topic == topics.WINCH_STATE:
                self._note_winch(message)
            if not SETTLING < self._time < self._plan.released:
                return  # it may not have heard the clock yet, or fall silent when it hears nothing
            heard.arrivals.append(time.monotonic())
            heard.stamps.append(seconds_of(message.header.stamp))
            heard.clock.append(self._simulated + time.monotonic() - self._ticked_at)
            for name, largest in port.numbers:
                value = fields[name](message)
                is_missing = name in port.may_be_missing and math.isnan(value)
                if not (is_missing or is_plausible(value, largest)):
                    heard.bad[name] = heard.bad.get(name, 0) + 1
            if port.counter:
                heard.counter.append(int(getattr(message, port.counter)))

        self._node.create_subscription(
            message_type(port.topic.type),
            port.topic.name,
            on_message,
            reader_qos_of(port.topic.role, is_external=True),
        )

    def _note_winch(self, state: Any) -> None:
        said = WinchTrial(self._time, self._sequence, state.command_sequence, state.brake, state.fault, state.release)
        self._trial.append(said)

    # the fellow

    _simulated = _ticked_at = 0.0

    def _publish(self, tick: int) -> None:
        """Publish what the node hears in `tick`; in the silent phase the clock alone."""
        self._simulated, self._ticked_at = tick * TICK, time.monotonic()
        stamp = stamp_of_seconds(self._simulated)
        made = {
            topics.WINCH_COMMAND.name: self._command,
            topics.MRU.name: self._sample,
            topics.WINCH_STATE.name: self._state,
        }
        for name, publisher in self._publishers.items():
            if name != topics.CLOCK.name and not self._is_silent:
                message = made[name](tick)
                message.header.stamp = stamp
                publisher.publish(message)
        clock = message_type(topics.CLOCK.type)(clock=stamp)
        self._publishers[topics.CLOCK.name].publish(clock)

    def _command(self, tick: int) -> Any:
        """Return a command that holds the drum where it is."""
        del tick
        self._sequence += 1
        state = self._newest.get(topics.WINCH_STATE.name)
        command = message_type(topics.WINCH_COMMAND.type)(sequence=self._sequence)
        command.brake = self._plan.phase(self._time).startswith("braked")
        command.payout = state.encoder_payout if state is not None and math.isfinite(state.encoder_payout) else 0.0
        command.mean_payout = command.payout
        return command

    def _sample(self, tick: int) -> Any:
        amplitude, period = QUIET_SEA
        omega = 2.0 * math.pi / period
        sine, cosine = math.sin(omega * tick * TICK), math.cos(omega * tick * TICK)
        sample = message_type(topics.MRU.type)(sequence=tick, heave_sigma=0.01, heave_rate_sigma=0.01)
        sample.heave, sample.heave_rate = amplitude * sine, amplitude * omega * cosine
        sample.heave_acceleration = -amplitude * omega**2 * sine
        return sample

    def _state(self, tick: int) -> Any:
        """Return a winch at rest that accepts every command."""
        del tick
        command = self._newest.get(topics.WINCH_COMMAND.name)
        state = message_type(topics.WINCH_STATE.type)()
        state.brake = command is None or command.brake
        state.command_sequence = 0 if command is None else command.sequence
        return state
