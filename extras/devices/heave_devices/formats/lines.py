"""A stream of bytes as lines of text, whatever pieces it comes in."""

from __future__ import annotations

from abc import ABC, abstractmethod

from heave_devices.formats.sample import Counters, Sample

LONGEST_LINE = 1024
"""Bytes of a line; of a longer one nothing is used."""


class LineSplitter:
    """Splits a stream at carriage returns and line feeds.

    Parameters
    ----------
    counters : in which lines that are too long, and half ones, are counted
    """

    def __init__(self, counters: Counters) -> None:
        self._counters = counters
        self._rest = b""

    def feed(self, data: bytes) -> list[str]:
        """Return the lines that end within the next bytes of the stream, `data`; empty ones are left out."""
        self._counters.bytes += len(data)
        *complete, rest = (self._rest + data).replace(b"\r", b"\n").split(b"\n")
        lines = [line for line in (self._checked(piece) for piece in complete) if line]
        self._rest = rest[: LONGEST_LINE + 1]
        return lines

    def end(self) -> str:
        """Return what is left, as a datagram's last line needs no end; "" where nothing is."""
        line = self._checked(self._rest)
        self._rest = b""
        return line

    def _checked(self, line: bytes) -> str:
        if len(line) > LONGEST_LINE:
            self._counters.malformed += 1
            return ""
        return line.decode("latin-1").strip()


class LineDecoder(ABC):
    """A decoder of lines, each of which is a sample or none: see `Decoder`."""

    def __init__(self) -> None:
        self.counters = Counters()
        self._lines = LineSplitter(self.counters)

    def feed(self, data: bytes) -> list[Sample]:
        """Return what is complete with the next bytes of a stream, `data`."""
        return [sample for line in self._lines.feed(data) if (sample := self._read(line)) is not None]

    def end(self) -> list[Sample]:
        """Return what the end of a datagram or of a file completes."""
        return self._last(self._lines.end())

    def _last(self, line: str) -> list[Sample]:
        sample = self._read(line) if line else None
        return [] if sample is None else [sample]

    @abstractmethod
    def _read(self, line: str) -> Sample | None:
        """Return the sample of a line; None where it holds none, which is counted."""
