"""Recordings of boom-tip motion, from CSV or from a bag (MCAP), and the source that replays them.

CSV: comment lines begin with #, then a header and rows, in any form of `heave_node.files.columns`: columns time_s and
z_m (or heave_m), x_m and y_m if there are.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy
from heave_node.files.columns import ColumnsError, read_columns
from heave_node.files.given_files import TextFileError, read_text
from heave_node.files.plausible import ACCEPT, question, refusal
from heave_node.numerics.arrays import Array

from wave_vessel_node.sources.bag_motion import BagMotionError, bag_samples
from wave_vessel_node.sources.motion_source import MotionSource
from wave_vessel_node.sources.scene import Scene
from wave_vessel_node.vessel.motion import HEAVE, VesselMotions

_LONGEST_GAP = 2.0  # s between samples; longer gaps cannot be interpolated
_LONGEST_STANDSTILL = 10.0
"""Longest time in which a ship at sea reads exactly the same [s]."""
_COLUMNS = {"x_m": 0, "y_m": 1, "z_m": 2, "heave_m": 2}


class RecordingError(ValueError):
    """A recording that cannot be used; the message names file, place and what was expected."""


@dataclass(frozen=True)
class Recording:
    """A record in order of time."""

    path: str  # file or folder that it was read from
    time: Array  # [s] from the first sample, shape (n,)
    position: Array  # x, y, z of the motion [m], shape (n, 3), about its mean
    warnings: tuple[str, ...]  # what was left out, and what of a bag could not be read


def read_recording(path: str | Path, *, accept_implausible: bool = False) -> Recording:
    """Read a recording.

    Parameters
    ----------
    path : a .csv file, an .mcap file, or a bag folder with one
    accept_implausible : take implausible figures as they are; they are in the warnings

    The mean is taken out, time begins at 0. Samples that are not numbers, that the MRU calls invalid, or that are not
    later than the one before are left out, with a warning. Raises RecordingError when the file is missing, of another
    kind, has a gap of more than 2 s, fewer than 10 samples, or implausible figures
    (`heave_node.files.plausible`).
    """
    path = Path(path)
    if not path.exists():
        raise RecordingError(f"{path}: no such file or folder")
    if not path.is_file() and not path.is_dir():
        raise RecordingError(f"{path}: is not a file")  # a pipe or a device may never end
    lost: list[str] = []
    if path.suffix.lower() == ".csv":
        samples = list(_csv_samples(path))
    elif path.is_dir() or path.suffix.lower() == ".mcap":
        # by their stamps: neither the names of split files nor the order in a file say what comes first
        try:
            unsorted, lost = bag_samples(path)
        except BagMotionError as error:
            raise RecordingError(str(error)) from error
        samples = sorted(unsorted, key=lambda sample: sample[0])
    else:
        raise RecordingError(f"{path}: expected a .csv file, an .mcap file or a bag folder")
    return _checked(path, np.array(samples).reshape(-1, 4), lost, accept_implausible)


def _checked(path: Path, samples: Array, lost: list[str], accept: bool) -> Recording:
    good = np.isfinite(samples).all(axis=1)
    warnings = [f"{path}: {text}" for text in lost]
    if not good.all():
        warnings.append(f"{path}: {int((~good).sum())} non-numeric or invalid samples skipped")
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
            f"gaps may be at most {_LONGEST_GAP:g} s{''.join(f'; {text}' for text in lost[:1])}"
        )
    objections = _questions(samples[:, 0], samples[:, 3])
    if objections and not accept:
        raise RecordingError(f"{path}: {refusal(objections, ACCEPT)}")
    warnings += [f"{path}: {text}" for text in (*objections, *_standstill(samples[:, 0], samples[:, 3]))]
    position = samples[:, 1:] - samples[:, 1:].mean(axis=0)
    return Recording(str(path), samples[:, 0] - samples[0, 0], position, tuple(warnings))


def _questions(time: Array, heave: Array) -> list[str]:
    """Return what is implausible about heave [m] over time [s]."""
    about = heave - np.median(heave)
    worst = int(np.argmax(np.abs(about)))
    asked = (
        question("heave", float(abs(about[worst])), f"at {time[worst]:g} s"),
        question("four standard deviations of heave", 4.0 * float(heave.std())),
    )
    return [objection for objection in asked if objection]


def _standstill(time: Array, heave: Array) -> list[str]:
    """Return the line that says for how long a heave that moves else stands still, if that is long."""
    starts = np.concatenate(([0], np.flatnonzero(np.diff(heave) != 0.0) + 1))
    lasted = time[np.append(starts[1:], heave.size) - 1] - time[starts]
    longest = int(np.argmax(lasted))
    if starts.size < 2 or lasted[longest] <= _LONGEST_STANDSTILL:
        return []
    return [f"stands still for {lasted[longest]:.1f} s from {time[starts[longest]]:g} s on: was the sensor stuck?"]


def _csv_samples(path: Path) -> Iterator[tuple[float, float, float, float]]:
    try:
        table = read_columns(read_text(path).lines, ("time_s", *_COLUMNS))
    except TextFileError as error:
        raise RecordingError(str(error)) from error
    except ColumnsError as error:
        raise RecordingError(f"{path}: {error}") from error
    header = table.header
    places = {_COLUMNS[name]: header.index(name) for name in header if name in _COLUMNS}
    if "time_s" not in header or 2 not in places:
        raise RecordingError(
            f"{path}: line {table.header_line}: expected columns time_s and z_m or heave_m; other logs are "
            "made to this by `heave import`"
        )
    wanted = [header.index("time_s"), *(places.get(axis, -1) for axis in range(3))]
    for number, row in zip(table.lines, table.rows, strict=True):
        if len(row) != len(header):
            raise RecordingError(f"{path}: line {number}: {len(row)} values where the header has {len(header)} columns")
        time, x, y, z = (table.number(row[place]) if place >= 0 else 0.0 for place in wanted)
        for place, value in zip(wanted, (time, x, y, z), strict=True):
            if math.isnan(value) and row[place].strip().lower().lstrip("+-") != "nan":
                raise RecordingError(f"{path}: line {number}: {row[place]!r} is not a number")
        yield time, x, y, z


def build(scene: Scene) -> MotionSource:
    """Return the source `file` of a scene; what was repaired in the file is added to the scene's warnings."""
    parameters = scene.parameters
    recording = read_recording(parameters.recording_file, accept_implausible=parameters.accept_implausible)
    scene.warnings.extend(recording.warnings)
    return RecordedSource(recording, scene.tick_period)


class RecordedSource(MotionSource):
    """Motion of the boom tip as it was recorded; the sea surface follows it.

    Between samples a cubic spline gives position, velocity and acceleration that fit one another.

    Parameters
    ----------
    recording : motion of the boom tip
    tick_period : [s]
    """

    def __init__(self, recording: Recording, tick_period: float) -> None:
        self._recording = recording
        self._spline = scipy.interpolate.CubicSpline(recording.time, recording.position)
        self._tick_period = tick_period

    def motions(self, ticks: range) -> VesselMotions:
        """See MotionSource. Raises RecordingError beyond the end of the recording."""
        last = self._recording.time[-1] + 1e-9
        there = range(ticks.start, next((tick for tick in ticks if tick * self._tick_period > last), ticks.stop))
        if not there:
            end = math.floor(self._recording.time[-1] / self._tick_period) * self._tick_period
            raise RecordingError(f"{self._recording.path}: ends after {end:g} s: give a shorter duration")
        motions = VesselMotions.still(there, self._tick_period)
        motions.six[:, :, :3] = np.stack([self._spline(motions.time, order) for order in range(3)], axis=1)
        motions.elevation = motions.six[:, 0, HEAVE].copy()
        return motions
