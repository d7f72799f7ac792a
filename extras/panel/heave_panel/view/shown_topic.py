"""A topic as viewers are given it: announced so that nobody misses it, and repeated where it is published only once."""

from __future__ import annotations

from foxglove import Channel, Schema

ANNOUNCEMENTS = 3
"""Times that a topic which appears beside viewers is announced, until one of them takes it."""
LOOKS_BETWEEN = 3
"""Calls of `repeat` from one announcement to the next."""


class ShownTopic:
    """A channel of the stream.

    The server of foxglove-sdk announces a new channel before it knows it: a viewer that asks for it at once is refused,
    and stays without it. So a channel that nobody takes is announced again.

    Parameters
    ----------
    name : that viewers see
    schema : definition of its messages
    is_latched : who comes later is to be given the newest message
    is_late : viewers may be connected when the topic appears
    """

    def __init__(self, name: str, schema: Schema, *, is_latched: bool, is_late: bool) -> None:
        self.name = name
        self._schema = schema
        self._is_latched = is_latched
        self._newest: bytes | None = None
        self._announcements_left = ANNOUNCEMENTS - 1 if is_late else 0
        self._looks = 0
        self._channel = self._announce()

    def show(self, message: bytes, nanoseconds: int) -> None:
        """Give viewers a serialised `message`; its time in `nanoseconds`."""
        if self._is_latched:
            self._newest = message
        self._channel.log(message, log_time=nanoseconds)

    def repeat(self, nanoseconds: int) -> None:
        """Repeat what a viewer may have missed; about once a second, the time then in `nanoseconds`."""
        if self._newest is not None:
            self._channel.log(self._newest, log_time=nanoseconds)
        if self._announcements_left == 0:
            return
        self._looks += 1
        if self._channel.has_sinks():
            self._announcements_left = 0
        elif self._looks % LOOKS_BETWEEN == 0:
            self._announcements_left -= 1
            self._channel.close()
            self._channel = self._announce()

    def _announce(self) -> Channel:
        return Channel(self.name, schema=self._schema, message_encoding="cdr")
