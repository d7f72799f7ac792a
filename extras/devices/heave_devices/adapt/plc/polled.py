"""A PLC that is polled for its values and sent its orders, by a thread of its own that opens the link again."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Protocol

from heave_devices.adapt.links import LinkThread
from heave_devices.formats.sample import Sample
from heave_devices.maps.link import Link

ANSWER_TIME = 0.4
"""A PLC that has not answered after this time is lost [s]."""


class LinkLostError(OSError):
    """The link is gone, and must be opened again; the message says why."""


class RefusedError(OSError):
    """The PLC has answered, but not with what it was asked for; the message says what, and what to do."""


class Exchange(Protocol):
    """What a protocol does. Each call ends within a second, or raises LinkLostError or RefusedError."""

    def open(self) -> None:
        """Connect."""

    def read(self) -> Sample:
        """Return the fields of the map as they are now."""

    def write(self, values: Mapping[str, float]) -> None:
        """Write `values` by the names of the map's registers or nodes."""

    def close(self) -> None:
        """End the connection; nothing if there is none."""


class PolledLink(LinkThread):
    """Reads a PLC once per period, and writes each order as soon as it is there.

    Parameters
    ----------
    link : of the map
    exchange : the protocol
    on_sample : called, in the thread of this link, with each reading

    Attributes
    ----------
    reads, writes, refusals : counted so far
    unsent_since : monotonic time of the oldest order that has not reached the PLC [s]; None: all have
    """

    def __init__(self, link: Link, exchange: Exchange, on_sample: Callable[[Sample], None]) -> None:
        super().__init__(link)
        self.reads = self.writes = self.refusals = 0
        self.unsent_since: float | None = None
        self._exchange = exchange
        self._on_sample = on_sample
        self._order: Mapping[str, float] | None = None

    def put(self, order: Mapping[str, float]) -> None:
        """Let `order`, values by name, be written next; it replaces one that has not been."""
        with self._changed:
            self._order = order
            self.unsent_since = time.monotonic() if self.unsent_since is None else self.unsent_since
            self._changed.notify()

    def _leave(self) -> None:
        with suppress(Exception):  # a session that is gone cannot be ended
            self._exchange.close()

    def _serve(self) -> None:
        self._exchange.open()
        self.opened += 1
        self._poll()
        self._try("write", self._write)  # the last order

    def _poll(self) -> None:
        due = time.monotonic()
        while not self._is_ended:
            if time.monotonic() >= due:
                self._try("read", self._read)
                due = max(due + self.link.period, time.monotonic())
            self._try("write", self._write)
            with self._changed:
                self._changed.wait_for(
                    lambda: self._is_ended or self._order is not None, max(0.0, due - time.monotonic())
                )

    def _try(self, what: str, act: Callable[[], None]) -> None:
        """Read or write; what the PLC refuses is reported and counted, and tried again."""
        try:
            act()
        except (RefusedError, ValueError) as error:
            self.refusals += 1
            self._problems[what] = str(error)
            time.sleep(self.link.period)

    def _read(self) -> None:
        sample = self._exchange.read()
        self.reads += 1
        self._problems["read"] = ""
        self._on_sample(sample)

    def _write(self) -> None:
        with self._changed:
            order, self._order = self._order, None
        if order is None:
            return
        self._exchange.write(order)
        self.writes += 1
        self._problems["write"] = ""
        with self._changed:
            self.unsent_since = None if self._order is None else time.monotonic()
