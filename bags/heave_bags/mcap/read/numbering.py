"""Numbers that the recorders of this project give messages of a topic without gaps: what is missing, what repeated."""

from __future__ import annotations

from collections.abc import Mapping, MutableMapping

from mcap.records import Channel


class Numbering:
    """Follows the numbers of the messages of one file.

    Parameters
    ----------
    channels : of the file, by id
    carried : the next number of each topic's messages, carried from one file of a bag to the next; a topic that is not
        in it begins with 1. None where the files before this one are not known.

    Attributes
    ----------
    is_on : the messages are numbered, as far as they were read
    missing : messages that gaps in the numbers say are not there
    """

    def __init__(self, channels: Mapping[int, Channel], carried: MutableMapping[str, int] | None) -> None:
        self.is_on = False
        self.missing = 0
        self._channels = channels
        self._carried = carried
        self._next: dict[int, int] = {}

    def is_repeated(self, channel: int, sequence: int) -> bool:
        """Return whether message number `sequence` of a `channel` was read before; count those missing before it."""
        if not sequence:  # numbers begin with 1: these messages have none
            self.is_on = False
            return False
        expected = self._next.get(channel)
        if expected is None:
            topic = self._channels[channel].topic
            expected = sequence if self._carried is None else self._carried.get(topic, 1)
        if sequence < expected:
            return True
        self.missing += sequence - expected
        self._next[channel] = sequence + 1
        return False

    def carry_on(self) -> None:
        """Hand the next numbers on to the file that follows."""
        if self._carried is not None:
            self._carried.update({self._channels[key].topic: number for key, number in self._next.items()})
