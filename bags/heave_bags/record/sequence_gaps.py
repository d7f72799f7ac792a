"""Messages that the middleware dropped before a recorder took them: gaps in the numbers that publishers give."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from heave_node.ros.spin import with_information


class SequenceGaps:
    """Counts what is missing, by topic, and gives `report` the topic and the number of messages of each gap.

    What a publisher sent before its first message was taken does not count: the recorder may have come later. A
    middleware that gives no numbers shows no gaps.
    """

    def __init__(self, report: Callable[[str, int], None]) -> None:
        self._report = report
        self._last: dict[tuple[str, bytes], int] = {}

    def note(self, topic: str, information: Mapping[str, Any]) -> None:
        """Take note of the `information` that comes with a message of a `topic`."""
        number, publisher = information.get("publication_sequence_number"), information.get("publisher_gid")
        if number is None or publisher is None:
            return
        key = (topic, bytes(publisher["data"]))
        last = self._last.get(key, number - 1)
        if number > last:
            self._last[key] = number
        if number > last + 1:
            self._report(topic, number - last - 1)

    def noting(self, topic: str, callback: Callable[..., object]) -> Callable[..., None]:
        """Return the `callback` of a subscription to a `topic`, full name, which takes a message and its information,
        and takes note of what comes.
        """

        def take(message: bytes, information: Mapping[str, Any]) -> None:
            self.note(topic, information)
            callback(message, information)

        return with_information(take)
