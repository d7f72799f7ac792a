"""A stream of bytes as lines of text, whatever pieces it comes in."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable

from heave_devices.formats.sample import Counters, Sample

LONGEST_LINE = 1024
"""Bytes of a line; of a longer one nothing is used."""


class LineDecoder(ABC):
    """A decoder of lines, each a sample or none, that ends with a carriage return or a line feed: see `Decoder`."""

    def __init__(self) -> None:
        self.counters = Counters()
        self._rest = b""

    def feed(self, data: bytes) -> list[Sample]:
        """Return what is complete with the next bytes of a stream, `data`."""
        self.counters.bytes += len(data)
        *complete, rest = (self._rest + data).replace(b"\r", b"\n").split(b"\n")
        self._rest = rest[: LONGEST_LINE + 1]
        return [sample for piece in complete for sample in self._samples(piece, self._read)]

    def end(self) -> list[Sample]:
        """Return what the end of a datagram or of a file completes."""
        rest, self._rest = self._rest, b""
        return self._samples(rest, self._read_unended)

    def _samples(self, piece: bytes, read: Callable[[str], Sample | None]) -> list[Sample]:
        """Return the sample, if there is one, of what stands between two ends of lines."""
        if len(piece) > LONGEST_LINE:
            self.counters.malformed += 1
            return []
        line = piece.decode("latin-1").strip()
        samples = [sample for sample in [read(line) if line else None] if sample is not None]
        self.counters.samples += len(samples)
        return samples

    def _read_unended(self, line: str) -> Sample | None:
        """Return the sample of the last line of a datagram or file, which nothing ends."""
        return self._read(line)

    @abstractmethod
    def _read(self, line: str) -> Sample | None:
        """Return the sample of a line; None where it holds none, which is counted."""
