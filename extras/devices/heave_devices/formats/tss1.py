"""TSS1: motion as a line of 25 fixed characters, without time and without a checksum.

`:XXAAAASMHHHHQMRRRRSMPPPP`: horizontal acceleration XX (unsigned hexadecimal, 3.83 cm/s^2), vertical acceleration AAAA
(hexadecimal in two's complement, 0.0625 cm/s^2), heave HHHH (1 cm), status Q, roll and pitch (0.01 degree); S a space,
M a space or a minus sign. Vertical acceleration and heave positive up, roll positive port side up, pitch positive bow
up; a capital Q, or a space (TSS 335B), is settled, a small letter settling. Sources: Norwegian Subsea, API
documentation "TSS1"; NovAtel OEM7 log 1456; Kongsberg Seapath 320 M300-62 rev. 2, A.12.
"""

from __future__ import annotations

import math
import re

from heave_node.interface.codes import MruStatus

from heave_devices.formats.lines import LineDecoder
from heave_devices.formats.sample import Sample

_LINE = re.compile(
    r"(?P<across>[0-9A-F]{2})(?P<up>[0-9A-F]{4})[ ](?P<heave>[ +-]\d{4})(?P<status>[UuGgHhFf ])"
    r"[ ]?(?P<roll>[ +-]\d{4})[ ](?P<pitch>[ +-]\d{4})"
)
_BEGUN = re.compile(r":[0-9A-F]{6} [ +-]?\d*\w?[ +-]?\d*[ +-]*\d*$")
"""A line that another one has cut off."""
_ACROSS, _UP, _CENTI = 0.0383, 0.000625, 0.01
"""Sizes of the last digit [m/s^2], [m/s^2], [m] or [degree]."""


class Tss1Decoder(LineDecoder):
    """Reads TSS1."""

    def _read(self, line: str) -> Sample | None:
        """Return the sample of a line, before which other text may stand."""
        begun, _, text = line.rpartition(":")
        found = _LINE.fullmatch(text)
        if found is None:
            is_cut = ":" in line and len(text) < 24
            self.counters.incomplete_lines += is_cut
            self.counters.malformed += not is_cut
            return None
        self.counters.incomplete_lines += _BEGUN.search(begun) is not None
        up = int(found["up"], 16)
        angle = math.radians(_CENTI)
        values = {
            "horizontal_acceleration": _ACROSS * int(found["across"], 16),
            "heave_acceleration": _UP * (up - 0x10000 if up & 0x8000 else up),
            "heave": _CENTI * int(found["heave"]),
            "roll": angle * int(found["roll"]),
            "pitch": -angle * int(found["pitch"]),
        }
        status = MruStatus.SETTLING if found["status"].islower() else MruStatus.OK
        return Sample("TSS1", values, status=status)
