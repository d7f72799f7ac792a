"""How far the clocks of other hosts are from this one's, by messages in both directions. Wall time, no ROS.

A message that is sent at s by one clock and arrives at r by another takes r - s: its delay and the clocks' offset.
In the other direction the offset has the other sign: half the difference of the least of both is the offset, half their
sum the delay, which bounds the error (RFC 5905, section 8).
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from heave_node.ros.silence import Patience

_SECOND = 1e9


@dataclass(frozen=True)
class ClockOffset:
    """How far another clock is ahead of this one: `offset` [s], by at most `error` more or less [s]."""

    offset: float
    error: float

    def __str__(self) -> str:
        return f"{1e3 * self.offset:+.1f} ms, to {1e3 * self.error:.1f} ms"


class HostClocks:
    """Offsets of the clocks of other nodes' hosts; `clock` returns the wall time [s]."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._from: dict[str, float] = {}
        self._to: dict[str, float] = {}
        self._patience = Patience(clock=clock)

    def heard(self, node: str, sent: int, arrived: int, least_delay: float) -> None:
        """Take in a message of a node.

        Parameters
        ----------
        node : its name
        sent : when it was sent, by its host's clock [ns]; 0: the middleware does not tell
        arrived : now, by this host's clock [ns]
        least_delay : of a message to it, by both clocks, as it says [s]; 0: it has heard none
        """
        if sent:
            self._from[node] = min(self._from.get(node, math.inf), (arrived - sent) / _SECOND)
        if least_delay:
            self._to[node] = least_delay

    def offset(self, node: str) -> ClockOffset | None:
        """Return how far the clock of a node's host is ahead of this one; None before a message in each direction."""
        if node not in self._from or node not in self._to:
            return None
        there, back = self._to[node], self._from[node]
        return ClockOffset(0.5 * (there - back), max(0.0, 0.5 * (there + back)))

    def awaited(self, nodes: Iterable[str]) -> list[str]:
        """Return those of the `nodes` whose offset is not known and may come yet: as long as one more becomes known.

        A program that does not take part in the measurement is waited for no longer than `FLUSH_PATIENCE`.
        """
        unknown = [node for node in nodes if self.offset(node) is None]
        return [] if unknown and self._patience.is_over(len(unknown)) else unknown

    def words(self, nodes: Mapping[str, str]) -> str:
        """Return the offsets of certain `nodes`, by name with the name of their host, in words; "" for none."""
        known = {node: self.offset(node) for node in nodes}
        return ", ".join(f"{node} on {nodes[node]} {offset}" for node, offset in known.items() if offset)

    def too_far(self, nodes: Mapping[str, str], limit: float) -> str:
        """Say in one line whose clock is further from this host's than a `limit` [s] allows; "" for nobody's.

        `nodes` are those that count, by name with the name of their host.
        """
        for node, host in nodes.items():
            found = self.offset(node)
            if found is not None and abs(found.offset) - found.error > limit:
                way = "ahead of" if found.offset > 0.0 else "behind"
                return (
                    f"the clock of {node}'s host {host} is {abs(found.offset):.3f} s {way} this host's, and "
                    f"clock_offset_limit is {limit:g} s: synchronise both (chrony, PTP) or set a larger limit"
                )
        return ""
