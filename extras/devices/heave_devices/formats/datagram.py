"""Datagrams of a fixed layout that a map states: sequence number, time, numbers and a check, in both directions.

A layout is the list of fields in their order, each with its kind. Names with a meaning of their own:

- `sequence` counts datagrams and begins again after its largest number. A datagram that is not newer than the newest
  one is not used; after 100 that are missing backwards, two in a row restart, as in RFC 3550, appendix A.1, after
  a restart of the sender.
- `time_ms`, `time_us` : the sender's clock, in milliseconds or microseconds.
- `crc` : last, over all bytes before it; `crc32` (ISO-HDLC, as in Ethernet and zlib) or `crc16` (as in Modbus RTU).

A kind with a number behind it, `uint16=0x4857`, is a mark that must be there.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from heave_devices.formats.number_kinds import KINDS, ORDERS_OF_BYTES, packed, size_of, unpacked, wrapped
from heave_devices.formats.sample import Counters, Sample, TimeBase

DATAGRAM = "datagram"
"""The name of this format in a map."""
LARGEST = 1400
"""Bytes of a datagram that one packet of Ethernet holds."""
MISORDER = 100
"""A datagram at most so many behind the newest one is late; one further behind is of a sender that restarted."""
CLOCKS = {"time_ms": 1e-3, "time_us": 1e-6}
"""Fields that hold the sender's time, with their unit [s]."""
_CHECKS = {"crc32": 4, "crc16": 2}
_ALLOWED = {"sequence": ("uint8", "uint16", "uint32"), "time_ms": ("uint32", "uint64"), "time_us": ("uint64",)}


def crc16(data: bytes) -> int:
    """Return the CRC-16 of Modbus RTU (polynomial 0xA001 reflected, start 0xFFFF) of `data`.

    >>> hex(crc16(b"123456789"))
    '0x4b37'
    """
    value = 0xFFFF
    for byte in data:
        value ^= byte
        for _ in range(8):
            value = value >> 1 ^ (0xA001 if value & 1 else 0)
    return value


_COMPUTE: Mapping[str, Callable[[bytes], int]] = {"crc32": zlib.crc32, "crc16": crc16}


@dataclass(frozen=True)
class Layout:
    """The layout of a datagram."""

    fields: Mapping[str, str]  # kinds by name, in their order
    marks: Mapping[str, int]  # numbers that must be there, by name
    check: str = ""  # of `crc`, at the end; "": none
    byte_order: str = "big"  # big, little

    @property
    def size(self) -> int:
        """Bytes of a datagram."""
        return sum(map(size_of, self.fields.values())) + _CHECKS.get(self.check, 0)

    def pack(self, values: Mapping[str, float]) -> bytes:
        """Return the datagram with `values`; a field without one is 0. Raises ValueError where one does not fit."""
        parts = []
        for name, kind in self.fields.items():
            parts.append(packed(kind, self.marks.get(name, values.get(name, 0.0)), self.byte_order, name))
        data = b"".join(parts)
        return data + self._check_of(data)

    def unpack(self, data: bytes) -> dict[str, float]:
        """Return the numbers in a datagram of the right size, `data`, by name."""
        values, place = {}, 0
        for name, kind in self.fields.items():
            values[name] = unpacked(kind, data[place : place + size_of(kind)], self.byte_order)
            place += size_of(kind)
        return values

    def is_whole(self, data: bytes) -> bool:
        """Return whether the check of a datagram of the right size, `data`, fits."""
        length = _CHECKS.get(self.check, 0)
        return not length or self._check_of(data[:-length]) == data[-length:]

    def _check_of(self, data: bytes) -> bytes:
        if not self.check:
            return b""
        return _COMPUTE[self.check](data).to_bytes(_CHECKS[self.check], self.byte_order)  # type: ignore[arg-type]


def layout_of(fields: Mapping[str, str], byte_order: str = "big") -> Layout:
    """Return the layout with `fields`, kinds or `crc` by name, in a `byte_order`.

    Raises ValueError for what cannot be.
    """
    kinds, marks, check = {}, {}, ""
    if byte_order not in ORDERS_OF_BYTES:
        raise ValueError(f"byte_order = {byte_order!r} must be one of {', '.join(ORDERS_OF_BYTES)}")
    for name, text in fields.items():
        if check:
            raise ValueError(f"{name}: nothing may follow crc")
        if name == "crc":
            if text not in _CHECKS:
                raise ValueError(f"crc: {text} must be one of {', '.join(_CHECKS)}")
            check = text
            continue
        kind, _, mark = text.partition("=")
        if kind not in KINDS:
            raise ValueError(f"{name}: {kind} must be one of {', '.join(KINDS)}")
        kinds[name] = kind
        if mark:
            try:
                marks[name] = int(mark, 0)
            except ValueError:
                raise ValueError(f"{name}: {mark!r} is no whole number such as 7 or 0x4857") from None
            packed(kind, marks[name])
    for name, allowed in _ALLOWED.items():
        if name in kinds and kinds[name] not in allowed:
            raise ValueError(f"{name}: must be one of {', '.join(allowed)}")
    layout = Layout(kinds, marks, check, byte_order)
    if not kinds or layout.size > LARGEST:
        raise ValueError(f"has {layout.size} bytes: a datagram has 1 to {LARGEST}")
    return layout


class DatagramDecoder:
    """Reads datagrams of one `layout`: see `Decoder`."""

    def __init__(self, layout: Layout) -> None:
        self.counters = Counters()
        self._layout = layout
        self._data = b""
        self._newest: int | None = None
        self._anew: int | None = None

    def feed(self, data: bytes) -> list[Sample]:
        """Take bytes of a datagram, `data`; it is complete at its end."""
        self.counters.bytes += len(data)
        self._data = (self._data + data)[: LARGEST + 1]
        return []

    def end(self) -> list[Sample]:
        """Return what the datagram that ends here holds."""
        data, self._data = self._data, b""
        if len(data) != self._layout.size:
            self.counters.malformed += bool(data)
            return []
        if not self._layout.is_whole(data):
            self.counters.checksum_errors += 1
            return []
        values = self._layout.unpack(data)
        if any(values[name] != mark for name, mark in self._layout.marks.items()):
            self.counters.note_unknown(data[:4].hex())
            return []
        if "sequence" in values and not self._is_newer(int(values["sequence"])):
            return []
        self.counters.samples += 1
        clock = next((name for name in CLOCKS if name in values), "")
        if not clock:
            return [Sample("DATAGRAM", values)]
        return [Sample("DATAGRAM", values, time=CLOCKS[clock] * values[clock], time_base=TimeBase.COUNTER)]

    def _is_newer(self, sequence: int) -> bool:
        """Return whether a datagram is newer than all before it, and count what is missing, double or late."""
        if self._newest is None:
            self._newest = sequence
            return True
        kind = self._layout.fields["sequence"]
        wrap = 2 ** (8 * size_of(kind))
        ahead = (sequence - self._newest) % wrap
        if 0 < ahead < wrap // 2:
            self.counters.lost += ahead - 1
        elif ahead == 0:
            self.counters.repeated += 1
            return False
        elif wrap - ahead <= MISORDER:
            self.counters.late += 1
            self.counters.lost -= self.counters.lost > 0
            return False
        elif sequence != self._anew:
            self._anew = wrapped(kind, sequence + 1)
            return False
        self._newest, self._anew = sequence, None
        return True
