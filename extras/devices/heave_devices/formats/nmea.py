"""Lines that look like NMEA 0183: framing and checksum by pynmea2, fields by `nmea_sentences`."""

from __future__ import annotations

import re

import pynmea2

from heave_devices.formats.lines import LineDecoder
from heave_devices.formats.nmea_sentences import SENTENCES, WITHOUT_CHECKSUM, Quality
from heave_devices.formats.sample import Sample

_NAME = re.compile(r"(P[A-Z0-9]{3,9}|[A-Z]{2}([A-Z]{3}))$")
_WRONG = (ValueError, LookupError, TypeError, AttributeError, OverflowError)


class NmeaDecoder(LineDecoder):
    """Reads sentences of a serial line, of datagrams or of a log, in which other text may stand before each.

    With `needs_checksum` a sentence without one is refused; sentences that never have one are taken all the same.
    """

    def __init__(self, *, needs_checksum: bool = True) -> None:
        super().__init__()
        self.needs_checksum = needs_checksum
        self._quality = Quality()

    def _read_unended(self, line: str) -> Sample | None:
        if "*" in line[-3:] or not self.needs_checksum:
            return self._read(line)
        self.counters.incomplete_lines += 1
        return None

    def _read(self, line: str) -> Sample | None:
        """Return the sample of the last sentence that a line holds."""
        *before, sentence = line.split("$")
        if not before:
            self.counters.malformed += 1
            return None
        self.counters.incomplete_lines += sum("*" not in part for part in before[1:])
        name, _, rest = sentence.partition(",")
        found = _NAME.match(name)
        reader = SENTENCES.get(found[2] or found[1]) if found else None
        if not self._is_whole(f"${sentence}", name):
            self.counters.checksum_errors += 1
            return None
        if reader is None:
            self.counters.note_unknown(name[:10])
            return None
        try:
            sample = reader(rest.partition("*")[0].split(","), self._quality)
        except _WRONG:
            self.counters.malformed += 1
            return None
        if sample is None:
            self.counters.note_unknown(f"{name},{rest.partition(',')[0]}"[:16])
            return None
        return sample

    def _is_whole(self, sentence: str, name: str) -> bool:
        """Return whether the checksum of a sentence fits, or is not needed."""
        has_checksum = "*" in sentence
        if not has_checksum and (name in WITHOUT_CHECKSUM or not self.needs_checksum):
            return True
        try:
            pynmea2.parse(sentence, check=True)
        except (pynmea2.SentenceTypeError, IndexError):
            return True  # after the checksum was found to fit
        except pynmea2.ParseError:
            return False
        return True
