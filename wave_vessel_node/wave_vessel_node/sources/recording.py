"""Recordings of boom-tip motion or of wave elevation, from CSV or from a bag (MCAP).

CSV: comment lines begin with #, then a header and rows. Motion: columns time_s and z_m (or heave_m), x_m and y_m if
there are; elevation: time_s and elevation_m.
"""

from __future__ import annotations

import csv
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from heave_node.files.given_files import read_given
from heave_node.numerics.arrays import Array
from mcap.exceptions import McapError
from mcap.reader import make_reader

_LONGEST_GAP = 2.0  # s between samples; longer gaps cannot be interpolated
_COLUMNS = {"x_m": 0, "y_m": 1, "z_m": 2, "heave_m": 2, "elevation_m": 2}


class RecordingError(ValueError):
    """A recording that cannot be used; the message names file, place and what was expected."""


@dataclass(frozen=True)
class Recording:
    """A record in order of time.

    Attributes
    ----------
    path : file or folder that it was read from
    time : [s] from the first sample, shape (n,)
    position : x, y, z of the motion, or 0, 0, elevation [m], shape (n, 3), about its mean
    warnings : what was left out
    """

    path: str
    time: Array
    position: Array
    warnings: tuple[str, ...]


def read_recording(path: str | Path, topic: str = "boom_tip") -> Recording:
    """Read a recording.

    Parameters
    ----------
    path : a .csv file, an .mcap file, or a bag folder with one
    topic : last part of the topic's name in a bag

    The mean is taken out, time begins at 0. Samples that are not numbers or not later than the one before are left
    out, with a warning. Raises RecordingError when the file is missing, of another kind, has a gap of more than 2 s, or
    fewer than 10 samples.
    """
    path = Path(path)
    if not path.exists():
        raise RecordingError(f"{path}: no such file or folder")
    if path.suffix.lower() == ".csv":
        samples = list(_csv_samples(path))
    elif path.is_dir() or path.suffix.lower() == ".mcap":
        samples = list(_bag_samples(path, topic))
    else:
        raise RecordingError(f"{path}: expected a .csv file, an .mcap file or a bag folder")
    return _checked(path, np.array(samples).reshape(-1, 4))


def _checked(path: Path, samples: Array) -> Recording:
    good = np.isfinite(samples).all(axis=1)
    warnings = []
    if not good.all():
        warnings.append(f"{path}: {int((~good).sum())} non-numeric samples skipped")
    samples = samples[good]
    if len(samples):
        later = np.concatenate(([True], samples[1:, 0] > np.maximum.accumulate(samples[:, 0])[:-1]))
        if not later.all():
            warnings.append(f"{path}: {int((~later).sum())} samples not later than their predecessor skipped")
        samples = samples[later]
    if len(samples) < 10:
        raise RecordingError(f"{path}: has {len(samples)} usable samples: at least 10 are needed")
    gap = np.diff(samples[:, 0])
    if gap.max() > _LONGEST_GAP:
        raise RecordingError(
            f"{path}: no sample for {gap.max():.1f} s after {samples[np.argmax(gap), 0]:g} s: "
            f"gaps may be at most {_LONGEST_GAP:g} s"
        )
    position = samples[:, 1:] - samples[:, 1:].mean(axis=0)
    return Recording(str(path), samples[:, 0] - samples[0, 0], position, tuple(warnings))


def _csv_samples(path: Path) -> Iterator[tuple[float, float, float, float]]:
    try:
        lines = read_given(path).splitlines()
    except ValueError as error:
        raise RecordingError(f"{path}: {error}") from error
    numbered = [(n, line) for n, line in enumerate(lines, 1) if line.strip() and not line.startswith("#")]
    if not numbered:
        raise RecordingError(f"{path}: is empty")
    rows = csv.reader(line for _, line in numbered)
    header = [name.strip() for name in next(rows)]
    places = {_COLUMNS[name]: header.index(name) for name in header if name in _COLUMNS}
    if "time_s" not in header or 2 not in places:
        raise RecordingError(f"{path}: line {numbered[0][0]}: expected columns time_s and z_m, heave_m or elevation_m")
    time = header.index("time_s")
    for (number, _), row in zip(numbered[1:], rows, strict=True):
        if len(row) != len(header):
            raise RecordingError(f"{path}: line {number}: {len(row)} values where the header has {len(header)} columns")
        try:
            x, y, z = (float(row[places[axis]]) if axis in places else 0.0 for axis in range(3))
            yield float(row[time]), x, y, z
        except ValueError as error:
            raise RecordingError(f"{path}: line {number}: {error}") from None


def _bag_samples(path: Path, topic: str) -> Iterator[tuple[float, float, float, float]]:
    files = sorted(path.glob("*.mcap")) if path.is_dir() else [path]
    if not files:
        raise RecordingError(f"{path}: the folder has no .mcap file")
    found = set()
    matched = False
    for file in files:
        try:
            with file.open("rb") as stream:
                for schema, channel, message in make_reader(stream).iter_messages():
                    found.add(channel.topic)
                    if channel.topic.rsplit("/", 1)[-1] != topic:
                        continue
                    decode = _DECODERS.get(schema.name if schema else "")
                    if decode is None:
                        known = ", ".join(sorted(_DECODERS))
                        raise RecordingError(f"{path}: topic {channel.topic} has the wrong type: expected {known}")
                    matched = True
                    yield decode(_Cdr(message.data))
        except (McapError, struct.error) as error:
            raise RecordingError(f"{file}: is not a complete MCAP file: {error}") from error
    if not matched:
        raise RecordingError(f"{path}: there is no topic {topic}; found {', '.join(sorted(found)) or 'none'}")


class _Cdr:
    """Reads the plain members of a serialised ROS message in order (little-endian CDR)."""

    def __init__(self, data: bytes) -> None:
        self._data = data[4:]
        self._at = 0

    def read(self, kind: str) -> float:
        size = struct.calcsize(kind)
        self._at += -self._at % size
        value = struct.unpack_from("<" + kind, self._data, self._at)[0]
        self._at += size
        return value  # type: ignore[no-any-return]  # struct cannot know

    def header(self) -> float:
        """Return the stamp [s] and step over the frame."""
        seconds, nanoseconds = self.read("i"), self.read("I")
        length = int(self.read("I"))
        self._at += length
        return seconds + 1e-9 * nanoseconds


def _point_motion(cdr: _Cdr) -> tuple[float, float, float, float]:
    time = cdr.header()
    return time, cdr.read("d"), cdr.read("d"), cdr.read("d")


def _mru_sample(cdr: _Cdr) -> tuple[float, float, float, float]:
    time = cdr.header()
    cdr.read("I")
    cdr.read("B")
    return time, 0.0, 0.0, cdr.read("d")


def _wave_elevation(cdr: _Cdr) -> tuple[float, float, float, float]:
    return cdr.header(), 0.0, 0.0, cdr.read("d")


_DECODERS: dict[str, Callable[[_Cdr], tuple[float, float, float, float]]] = {
    "heave_msgs/msg/PointMotion": _point_motion,
    "heave_msgs/msg/MruSample": _mru_sample,
    "heave_msgs/msg/WaveElevation": _wave_elevation,
}
