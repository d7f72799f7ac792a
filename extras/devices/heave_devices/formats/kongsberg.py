"""Kongsberg's binary motion formats: KM Binary (`#KMB`) and EM Attitude 3000; neither has a checksum.

KM Binary, version 1: little-endian, 132 bytes; UTC, a word of status bits, position, roll, pitch, heading, heave and
their rates, velocities, errors, accelerations and delayed heave. Roll positive port side up, pitch positive bow up,
heave, vertical velocity and acceleration positive down. A bit of the status that is set calls data invalid: 1 roll and
pitch, 2 heading, 3 heave and vertical velocity, 4 acceleration, 5 delayed heave; the same plus 16: reduced performance.
Source: Simrad EK80 reference manual, "KM Binary datagram format".

EM Attitude 3000: 10 bytes; status, 90h, then roll, pitch, heave, heading of 16 bits, little-endian, in 0.01 degree and
0.01 m; roll positive port side up, pitch positive bow up, heave positive up. Status 90h full accuracy, 91h to 99h
reduced, 9Ah to 9Fh not valid, A0h to AFh sensor error, 00h: an EM 1000, which says no status. Source: the same manual,
"Kongsberg EM Attitude 3000 datagram format".
"""

from __future__ import annotations

import math
import struct

from heave_devices.formats.sample import Counters, Sample, TimeBase, sample_without

_DEGREE = math.radians(1.0)
_KMB = struct.Struct("<4sHHIIIdd21fIIf")
_KMB_HEAD = struct.Struct("<4sHH")
_KMB_LONGEST = 512
KMB_FIELDS = (
    *("ellipsoid_height", "roll", "pitch", "heading", "heave", "roll_rate", "pitch_rate", "yaw_rate"),
    *("north_velocity", "east_velocity", "heave_rate", "north_sigma", "east_sigma", "height_sigma"),
    *("roll_sigma", "pitch_sigma", "heading_sigma", "heave_sigma"),
    *("north_acceleration", "east_acceleration", "heave_acceleration", "delayed_heave"),
)
"""Fields of a frame, in their order; the delayed heave after two that are not used."""
_KMB_FACTORS = {
    **dict.fromkeys(("roll", "heading", "roll_rate", "roll_sigma", "pitch_sigma", "heading_sigma"), _DEGREE),
    **dict.fromkeys(("pitch", "pitch_rate", "yaw_rate"), -_DEGREE),
    **dict.fromkeys(("heave", "heave_rate", "heave_acceleration", "delayed_heave"), -1.0),
}
_KMB_INVALID = {
    0: ("north_velocity", "east_velocity"),
    1: ("roll", "pitch", "roll_rate", "pitch_rate"),
    2: ("heading", "yaw_rate"),
    3: ("heave", "heave_rate"),
    4: ("north_acceleration", "east_acceleration", "heave_acceleration"),
    5: ("delayed_heave",),
}


class KmBinaryDecoder:
    """Reads KM Binary."""

    def __init__(self) -> None:
        self.counters = Counters()
        self._rest = b""

    def feed(self, data: bytes) -> list[Sample]:
        """See Decoder."""
        self.counters.bytes += len(data)
        self._rest += data
        samples: list[Sample] = []
        while (start := self._rest.find(b"#KMB")) >= 0:
            self._rest = self._rest[start:]
            if len(self._rest) < _KMB_HEAD.size:
                return samples
            _, length, version = _KMB_HEAD.unpack_from(self._rest)
            if not (_KMB.size <= length <= _KMB_LONGEST and version in (1, 2)):
                self.counters.malformed += 1
                self._rest = self._rest[4:]
                continue
            if len(self._rest) < length:
                return samples
            sample = self._sample(self._rest[:length])
            self._rest = self._rest[length:] if sample is not None else self._rest[4:]
            samples += [] if sample is None else [sample]
        self._rest = self._rest[-3:]
        return samples

    def end(self) -> list[Sample]:
        """See Decoder."""
        self.counters.incomplete_lines += self._rest.startswith(b"#KMB")
        self._rest = b""
        return []

    def _sample(self, frame: bytes) -> Sample | None:
        """Return what a whole frame holds; None where its numbers are none of a motion sensor's."""
        _, _, _, seconds, nanoseconds, status, _, _, *numbers = _KMB.unpack_from(frame)
        values = {
            name: _KMB_FACTORS.get(name, 1.0) * value
            for name, value in zip(KMB_FIELDS, [*numbers[: len(KMB_FIELDS) - 1], numbers[-1]], strict=True)
            if math.isfinite(value) and not (name.endswith("_sigma") and value < 0.0)
        }
        if nanoseconds >= 1_000_000_000 or abs(values.get("roll", 0.0)) > math.pi or b"#KMB" in frame[4:]:
            self.counters.malformed += 1  # a frame that another one has cut off reads like this
            return None
        self.counters.samples += 1
        bad = frozenset(name for bit, names in _KMB_INVALID.items() if status >> bit & 1 for name in names)
        time = seconds + 1e-9 * nanoseconds
        return sample_without("KMB", values, bad, time=time, time_base=TimeBase.UNIX)


_EM = struct.Struct("<BBhhhH")
_EM_SYNC = 0x90
_MOST_HEADING, _MOST_ANGLE, _MOST_HEAVE = 35_999, 17_999, 999


class EmAttitudeDecoder:
    """Reads EM Attitude 3000.

    Its start is two bytes that may stand anywhere in it: until two frames follow each other, none is taken.
    """

    def __init__(self) -> None:
        self.counters = Counters()
        self._rest = b""
        self._is_in_step = False

    def feed(self, data: bytes) -> list[Sample]:
        """See Decoder."""
        self.counters.bytes += len(data)
        self._rest += data
        samples = []
        while len(self._rest) >= _EM.size + (0 if self._is_in_step else 2):
            frame, following = self._rest[: _EM.size], self._rest[_EM.size : _EM.size + 2]
            if not _is_frame(frame) or not (self._is_in_step or _is_start(following)):
                self.counters.malformed += self._is_in_step
                self._is_in_step = False
                self._rest = self._rest[1:]
                continue
            self._is_in_step = True
            self._rest = self._rest[_EM.size :]
            samples.append(self._sample(frame))
        return samples

    def end(self) -> list[Sample]:
        """See Decoder."""
        rest, self._rest, self._is_in_step = self._rest, b"", False
        if len(rest) == _EM.size and _is_frame(rest):
            return [self._sample(rest)]
        self.counters.incomplete_lines += bool(rest)
        return []

    def _sample(self, frame: bytes) -> Sample:
        self.counters.samples += 1
        status, _, roll, pitch, heave, heading = _EM.unpack(frame)
        angle = 0.01 * _DEGREE
        values = {"roll": angle * roll, "pitch": -angle * pitch, "heave": 0.01 * heave, "heading": angle * heading}
        return Sample("EM3000", {}, frozenset(values)) if status >= 0x9A else Sample("EM3000", values)


def _is_start(two: bytes) -> bool:
    return len(two) == 2 and two[1] == _EM_SYNC and (two[0] == 0 or 0x90 <= two[0] <= 0xAF)


def _is_frame(frame: bytes) -> bool:
    """Return whether ten bytes begin as a frame does, and hold values in their valid ranges."""
    status, _, roll, pitch, heave, heading = _EM.unpack(frame)
    if not _is_start(frame[:2]):
        return False
    in_range = max(abs(roll), abs(pitch)) <= _MOST_ANGLE and abs(heave) <= _MOST_HEAVE and heading <= _MOST_HEADING
    return bool(in_range or status >= 0x9A)
