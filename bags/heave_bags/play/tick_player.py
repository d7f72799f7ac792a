"""The messages that a node published, tick by tick, from a bag by any recorder.

The suite's recorder writes the tick of a lockstep run as log time. Every other recorder writes the time of arrival, by
one clock or another, which may lie up to a tick before the stamp: there the stamps say in which tick a message belongs,
and the arrival only how much later than its stamp a reading is delivered.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from heave_node.cdr.unpacker import header_stamp
from heave_node.interface import topics
from heave_node.numerics.arrays import Array
from heave_node.run_parameters import RunParameters
from rclpy.serialization import deserialize_message

from heave_bags.cdr.columns import layouts_in_bag
from heave_bags.errors import BagError
from heave_bags.mcap.reader import Bag, RawMessage
from heave_bags.play.playback import in_order_of, publisher_of

TickOf = Callable[[RawMessage], int]
"""Finds in which tick of the bag a message was published."""

STAMPED_AT_THE_END = frozenset(
    topic.name for topic in (topics.BOOM_TIP, topics.VESSEL_ODOMETRY, topics.WAVE_ELEVATION, topics.WINCH_STATE)
)
"""Topics whose messages of tick k are stamped with the time at which it ends; all others with that of its start."""

UNDELAYED = (
    *(topics.BOOM_TIP.name, topics.UNIT_ODOMETRY.name, topics.CABLE_STATE.name, topics.WINCH_STATE.name),
    *(topics.CONTROLLER_STATE.name, topics.WINCH_COMMAND.name),
)
"""Topics that are published in every tick without delay: by their arrival that of others is judged."""

_STAMP_END = 12
_SECOND = 1_000_000_000


def has_stamp(message: RawMessage) -> bool:
    """Return whether the stamp of a message with a header is set."""
    return len(message.data) >= _STAMP_END and message.data[4:_STAMP_END] != bytes(8)


class TickPlayer:
    """The messages that a node published in each tick.

    Parameters
    ----------
    bag, node : whose messages
    period : length of a tick [ns]

    Attributes
    ----------
    topics : what the node published, but for /clock and /diagnostics, by the names of the bag
    namespace : in which the bag's run was, "" for none
    last_tick : of the run that the bag reaches to

    Raises BagError if the bag has nothing of the node, was recorded with another tick, or holds several runs.
    """

    def __init__(self, bag: Bag, node: str, period: int) -> None:
        published = [name for name in bag.topics if node in publisher_of(bag, name)]
        self.namespace = _namespace_of(bag, published)
        self.topics = [name for name in published if self.name_in_run(name) != topics.CLOCK.name]
        if not self.topics:
            raise BagError(f"{bag.path}: no message in it was published by {node}")
        self._bag = bag
        self._node = node
        self._period = period
        self._check_tick()
        shared = (f"{self.namespace}/{topics.DIAGNOSTICS.name}",)
        self._wanted = [*self.topics, *(name for name in shared if name in bag.topics and name not in self.topics)]
        self._stamped = {name for name in self._wanted if _has_header(bag, name)}
        if bag.run.get("pacing") == "lockstep":
            self._tick_of: TickOf = lambda message: message.log_time // period
            last = bag.end_time // period
        else:
            arrivals = _Arrivals(bag, self.topics, self._stamped, period)
            self._tick_of, last = arrivals.tick_of, arrivals.last_tick
        self.last_tick = last
        self.restart()

    def name_in_run(self, topic: str) -> str:
        """Return the name of a `topic` of the bag as a node has it: relative, so that it goes into any namespace."""
        return topic.removeprefix(f"{self.namespace}/")

    def _check_tick(self) -> None:
        recorded = self._bag.run.get("tick_period_s")
        try:
            is_other = recorded is not None and round(float(recorded) * _SECOND) != self._period
        except (ValueError, OverflowError):
            is_other = True
        if is_other:
            raise BagError(
                f"{self._bag.path}: it was recorded with a tick of {recorded} s, but that "
                f"of the run is {self._period * 1e-9:g} s"
            )

    def restart(self) -> None:
        """Begin again at tick 1."""
        own = filter(self._is_own, self._bag.messages(self._wanted))
        self._messages = in_order_of((self._tick_of(message), message) for message in own)
        self._next = next(self._messages, None)

    def take(self, tick: int) -> list[tuple[str, bytes]]:
        """Return what the node published in a tick, in the order of the bag. Raises BagError behind the end of
        the bag.
        """
        if tick > self.last_tick:
            raise BagError(f"{self._bag.path}: it ends at t = {self.last_tick * self._period * 1e-9:g} s of this run")
        found: list[tuple[str, bytes]] = []
        while self._next is not None and self._next[0] <= tick:
            (_, message), self._next = self._next, next(self._messages, None)
            if message.topic not in self._stamped or has_stamp(message):
                found.append((message.topic, message.data))
        return found

    def _is_own(self, message: RawMessage) -> bool:
        """Tell whether the node itself published a message; /diagnostics has several publishers."""
        if self.name_in_run(message.topic) != topics.DIAGNOSTICS.name:
            return True
        array: DiagnosticArray = deserialize_message(message.data, DiagnosticArray)
        return bool(array.status) and array.status[0].hardware_id == self._node


def player_for(bag: Bag, node: str, run: RunParameters) -> TickPlayer:
    """Return the player of what a `node` published in the `bag`, for the whole of a `run`.

    Raises BagError where TickPlayer does, and for a bag that ends before the run.
    """
    player = TickPlayer(bag, node, run.tick_nanoseconds)
    if player.last_tick < run.tick_count:
        available = player.last_tick * run.tick_period
        raise BagError(
            f"{bag.path}: it has {available:g} s of {node}, but the run lasts {run.duration:g} s; "
            f"use --duration {available:g}"
        )
    return player


def _has_header(bag: Bag, name: str) -> bool:
    topic = bag.topics[name]
    try:
        return layouts_in_bag(topic.type, topic.schema).has_header
    except BagError:
        return False


class _Arrivals:
    """Works out the ticks of messages that were written at the time of their arrival, in one pass over the bag."""

    def __init__(self, bag: Bag, wanted: list[str], stamped: set[str], period: int) -> None:
        self._period = period
        self._stamped = stamped
        self._ahead = {name: int(_relative(name) in STAMPED_AT_THE_END) for name in bag.topics}
        self._delay = dict.fromkeys(bag.topics, 0)
        times = self._read(bag, wanted)
        if not times:
            raise BagError(f"{bag.path}: none of its messages has a time stamp, so their ticks cannot be determined")
        self.last_tick = max(int(ticks[-1]) for _, ticks in times.values())
        known = [name for name in wanted if _relative(name) in UNDELAYED and name in times]
        reference = max(known or times, key=lambda name: times[name][1].size)
        self._reference = times[reference]
        for name, (arrival, ticks) in times.items():
            late = float(np.median(np.interp(arrival, *self._reference) - ticks))
            self._delay[name] = 0 if name in known else max(0, round(late))

    def _read(self, bag: Bag, wanted: list[str]) -> Mapping[str, tuple[Array, Array]]:
        """Return the arrival of each stamped message [ns] and its tick without delay, by topic."""
        found: dict[str, tuple[list[int], list[int]]] = {}
        for message in bag.messages(wanted):
            if message.topic in self._stamped and has_stamp(message):
                arrival, ticks = found.setdefault(message.topic, ([], []))
                tick = self._undelayed(message)
                if ticks and tick < ticks[-1] - _SECOND // self._period:
                    raise BagError(f"{bag.path}: it holds several runs: stamps on {message.topic} go backwards")
                arrival.append(message.log_time)
                ticks.append(tick)
        return {name: _sorted(np.asarray(a, dtype=float), np.asarray(t, dtype=float)) for name, (a, t) in found.items()}

    def _undelayed(self, message: RawMessage) -> int:
        """Return the tick that begins at the stamp or next after it, or that ends there."""
        rounding = self._period // 1000
        return -((rounding - header_stamp(message.data)) // self._period) - self._ahead[message.topic]

    def tick_of(self, message: RawMessage) -> int:
        """Return the tick in which a message was published: by its stamp, or by its arrival where it has none."""
        if message.topic in self._stamped and has_stamp(message):
            return self._undelayed(message) + self._delay[message.topic]
        return int(np.interp(message.log_time, *self._reference))


def _sorted(arrival: Array, ticks: Array) -> tuple[Array, Array]:
    order = np.argsort(arrival, kind="stable")
    return arrival[order], ticks[order]


def _namespace_of(bag: Bag, published: list[str]) -> str:
    """Return the namespace of the run in a bag, "" for none: the shortest in which a node `published` what is known.

    Raises BagError where it published in several, none of which is in another.
    """
    known = [name for name in published if _relative(name) != name]
    found = sorted({name.removesuffix("/" + _relative(name)) for name in known}, key=len)
    if any(not f"{name}/".startswith(f"{found[0]}/") for name in found):
        raise BagError(f"{bag.path}: it holds several systems: {', '.join(found)}")
    return found[0] if found else ""


def _relative(name: str) -> str:
    """Return the name of a topic as the suite's table has it, whatever its namespace."""
    for known in topics.TOPIC_BY_NAME:
        if name == known or name.endswith("/" + known):
            return known
    return name
