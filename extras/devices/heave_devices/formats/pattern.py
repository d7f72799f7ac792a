"""Lines of any make by a regular expression: each named group that a line matches is a field.

A checksum, if the device sends one, is the group `checksum`; it covers what stands before it in the match, or the group
`covered` where there is one. Kinds: `xor` (two hexadecimal digits of what stands between `$` or `!` and `*`, as NMEA
0183 has it) and `sum` (decimal sum of the characters' codes, as the LCI-90 of Measurement Technology NW sends it,
operator manual section 6.6.4).
"""

from __future__ import annotations

import operator
import re
from collections.abc import Callable
from functools import reduce

from heave_devices.formats.lines import LineDecoder
from heave_devices.formats.sample import Sample, is_number, number

CHECKSUM, COVERED = "checksum", "covered"
CHECKSUMS: dict[str, tuple[Callable[[bytes], int], int]] = {
    "": (lambda _: 0, 10),
    "xor": (lambda data: reduce(operator.xor, data.lstrip(b"$!").rstrip(b"*"), 0), 16),
    "sum": (lambda data: sum(data) % 10_000, 10),
}
"""Kinds of checksum, "" for none: what is computed, and the base in which it is written."""


class PatternDecoder(LineDecoder):
    """Reads lines by a pattern.

    Parameters
    ----------
    pattern : regular expression that is looked for in each line; its named groups are the fields
    checksum : a kind of CHECKSUMS

    Raises ValueError where the pattern is no regular expression, has no field, or lacks the group of its checksum.
    """

    def __init__(self, pattern: str, checksum: str = "") -> None:
        super().__init__()
        try:
            self._pattern = re.compile(pattern)
        except re.error as error:
            raise ValueError(f"pattern: is no regular expression: {error}") from None
        names = set(self._pattern.groupindex)
        if not names - {CHECKSUM, COVERED}:
            raise ValueError("pattern: has no named group such as (?P<tension>[-0-9.]+)")
        if checksum not in CHECKSUMS:
            raise ValueError(f"checksum: must be one of {', '.join(filter(None, CHECKSUMS))}, not {checksum!r}")
        if bool(checksum) != (CHECKSUM in names):
            raise ValueError(
                f"checksum: needs its kind ({', '.join(filter(None, CHECKSUMS))}) and a group (?P<checksum>...)"
            )
        self.fields = frozenset(names - {CHECKSUM, COVERED})
        self._compute, self._base = CHECKSUMS[checksum]
        self._has_checksum = bool(checksum)

    def _read(self, line: str) -> Sample | None:
        found = self._pattern.search(line)
        if found is None:
            self.counters.note_unknown(line[:10])
            return None
        if self._has_checksum and not self._is_whole(found):
            self.counters.checksum_errors += 1
            return None
        given = {name: text.strip() for name, text in found.groupdict().items() if name in self.fields and text}
        values = {name: number(text) for name, text in given.items() if is_number(text)}
        return Sample("LINE", values, words={name: text for name, text in given.items() if name not in values})

    def _is_whole(self, found: re.Match[str]) -> bool:
        has_covered = COVERED in found.re.groupindex
        covered = found[COVERED] if has_covered else found.string[found.start() : found.start(CHECKSUM)]
        try:
            return int(found[CHECKSUM], self._base) == self._compute((covered or "").encode("latin-1"))
        except (TypeError, ValueError):
            return False
