"""Messages of ticks in an order that depends on the run alone: what makes two bags of one seed the same, byte for
byte.

Pure: raw messages go in and go on in order. A message carries the start of the tick in which it was published as log
time and publish time. Within a tick the clock master's topics come first, then those of the others, each by name and,
within a topic, as published.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence

from heave_node.cdr.unpacker import header_stamp

Write = Callable[[str, int, bytes], object]
"""What takes a message: topic, log time [ns] and data."""


class TickOrder:
    """Sorts what a recorder has received by tick `k` into the ticks in which it was published.

    A recorder that enters tick k has everything the master published up to tick k, and everything the others
    published up to tick k - 1.

    Parameters
    ----------
    publishers : per topic the names of the nodes that publish it
    master : name of the clock master
    canonical : turns equal messages of a topic into equal bytes; messages of several publishers are ordered by these
    lagging : names of nodes that may be behind the others. How early their messages come is chance: each counts in the
        tick of its stamp, by whose end it must have come
    """

    def __init__(
        self,
        publishers: Mapping[str, Collection[str]],
        master: str,
        canonical: Callable[[str, bytes], bytes] = lambda _, data: data,
        lagging: Collection[str] = (),
    ) -> None:
        self._canonical = canonical
        self._by_stamp = sorted(
            topic for topic, nodes in publishers.items() if len(set(nodes)) > 1 or set(nodes) & set(lagging)
        )
        self._of_master = sorted(topic for topic, nodes in publishers.items() if set(nodes) == {master})
        self._of_others = sorted(topic for topic in publishers if topic not in self._of_master)
        self._held: dict[str, list[bytes]] = {topic: [] for topic in self._by_stamp}

    def write(self, write: Write, take: Callable[[str], Sequence[bytes]], *, tick_start: int, tick_before: int) -> None:
        """`write` what has become complete by the tick that starts at `tick_start` [ns].

        `tick_before` is the start of the one before it [ns]; `take` hands over the messages of a topic.
        """
        for topic in self._of_others:
            messages = take(topic)
            for data in self._settled(topic, messages, tick_start) if topic in self._held else messages:
                write(topic, tick_before, data)
        for topic in self._of_master:
            for data in take(topic):
                write(topic, tick_start, data)

    def _settled(self, topic: str, arrived: Sequence[bytes], tick_start: int) -> list[bytes]:
        """Return the messages of a topic that were stamped before `tick_start`, in the order of stamps and bytes.

        Their order of arrival is chance; those of this tick wait until the others of it are here.
        """
        held = self._held[topic] + [self._canonical(topic, data) for data in arrived]
        self._held[topic] = [data for data in held if header_stamp(data) >= tick_start]
        return sorted(
            (data for data in held if header_stamp(data) < tick_start), key=lambda data: (header_stamp(data), data)
        )

    def write_rest(self, write: Write, take: Callable[[str], Sequence[bytes]], *, tick_start: int) -> None:
        """`write` what is left when a run ends, complete or not; `take` and `tick_start` as in `write`."""
        for topic in self._by_stamp:
            rest = self._held[topic] + [self._canonical(topic, data) for data in take(topic)]
            for data in sorted(rest, key=lambda data: (header_stamp(data), data)):
                write(topic, tick_start, data)
            self._held[topic] = []
        for topic in sorted({*self._of_master, *self._of_others} - {*self._by_stamp}):
            for data in take(topic):
                write(topic, tick_start, data)
