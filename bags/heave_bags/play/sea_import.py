"""A ship's own records become a sea for the loop: bags with any topics, or CSV logs, to boom-tip motion.

A mapping says where heave, and if known surge, sway, roll and pitch, are found, and where the boom tip lies from
the sensor. The result is a CSV file with columns time_s, x_m, y_m, z_m, which `wave_vessel` plays with
`boom_tip_source: file`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from heave_node.files.bounded_yaml import parse_yaml
from heave_node.numerics.arrays import Array
from scipy.interpolate import CubicSpline

from heave_bags.errors import BagError
from heave_bags.mcap.reader import TIME, Bag
from heave_bags.play.ship_log import ShipLog
from heave_bags.play.stretches import longest_stretch
from heave_bags.play.window import Window
from heave_bags.signals import Signal

MOTIONS = ("surge", "sway", "heave", "roll", "pitch")
EULER_PARTS = ("roll", "pitch", "yaw")
LOGS = (".csv", ".txt", ".log", ".tsv")
"""Endings of files that are read as text."""
WHOLE = Window()
DEFAULT_CUT_OFF = 2.0 * math.pi / 40.0
"""Motion slower than this is taken out when acceleration is integrated [rad/s]: no sea is slower."""


@dataclass(frozen=True)
class Channel:
    """Where one motion is found.

    Attributes
    ----------
    topic, field : of a bag, such as "/imu/data", "linear_acceleration.z"; `field` may be a quaternion if `part`
        is given
    column : of a CSV log
    part : "roll", "pitch" or "yaw" of a quaternion [rad]
    scale, offset : motion = scale * value + offset, to metres or radians
    acceleration : the value is an acceleration [m/s^2]; it is integrated twice
    cut_off : what is slower is then taken out [rad/s]
    """

    topic: str = ""
    field: str = "data"
    column: str = ""
    part: str = ""
    scale: float = 1.0
    offset: float = 0.0
    acceleration: bool = False
    cut_off: float = DEFAULT_CUT_OFF


@dataclass(frozen=True)
class SeaMapping:
    """How a record becomes boom-tip motion.

    Attributes
    ----------
    channels : per motion (surge, sway, heave, roll, pitch); heave there must be
    lever_arm : boom tip from the sensor, x forward, y to port, z up [m]
    time_column, time_scale : of a log: its heading, or those of date and time ("": found by its name); numbers are
        seconds after the scale, or Unix time in any unit; texts are ISO 8601
    rate : samples per second of the result
    """

    channels: Mapping[str, Channel]
    lever_arm: tuple[float, float, float] = (0.0, 0.0, 0.0)
    time_column: str | Sequence[str] = ""
    time_scale: float = 1.0
    rate: float = 20.0


@dataclass
class ImportedSea:
    """Boom-tip motion about its mean.

    Attributes
    ----------
    time : from 0 [s]
    position : shape (n, 3) [m]
    notes : what is left out or bridged
    start : time of the record at which it begins [s]: Unix time, where the record has that
    """

    time: Array
    position: Array
    notes: list[str] = field(default_factory=list)
    start: float = 0.0


def read_mapping(path: Path) -> SeaMapping:
    """Read the mapping file `path` (YAML). Raises BagError with the file and the entry that is wrong."""
    try:
        content = parse_yaml(path.read_bytes())
    except (OSError, ValueError) as error:
        raise BagError(f"{path}: cannot be read as a mapping: {' '.join(str(error).split())}") from error
    if not isinstance(content, dict):
        raise BagError(f"{path}: a mapping must name heave and where it is found")
    entries = dict(content)
    channels = {name: _channel(path, name, entries.pop(name)) for name in MOTIONS if name in entries}
    if "heave" not in channels:
        raise BagError(f"{path}: heave is missing: give its topic and field, or its column")
    known = ("lever_arm", "time_column", "time_scale", "rate")
    unknown = sorted(set(entries) - set(known))
    if unknown:
        raise BagError(f"{path}: unknown entry {unknown[0]}; known: {', '.join((*MOTIONS, *known))}")
    try:
        arm = tuple(float(value) for value in entries.pop("lever_arm", (0.0, 0.0, 0.0)))
        mapping = SeaMapping(channels, arm, **entries)  # type: ignore[arg-type]
        if len(arm) != 3 or not mapping.rate > 0.0:
            raise ValueError("lever_arm must have three numbers, rate must be above 0")
    except (TypeError, ValueError) as error:
        raise BagError(f"{path}: {error}") from error
    return mapping


def _channel(path: Path, name: str, entry: Any) -> Channel:
    if not isinstance(entry, dict):
        raise BagError(f"{path}: {name} must give topic and field, or column")
    try:
        channel = Channel(**entry)
    except TypeError:
        known = ", ".join(Channel.__dataclass_fields__)
        raise BagError(f"{path}: {name} has an unknown entry; known: {known}") from None
    if bool(channel.topic) == bool(channel.column):
        raise BagError(f"{path}: {name} needs either a topic or a column")
    if channel.part and channel.part not in EULER_PARTS:
        raise BagError(f"{path}: {name}: part must be one of {', '.join(EULER_PARTS)}")
    return channel


def mapping_for_topic(bag: Bag, topic: str) -> SeaMapping:
    """Return the mapping that the standard type of a `topic` of `bag` suggests.

    That is Odometry, Imu, Float64, Float32, and the suite's own. Raises BagError for others.
    """
    name = bag.resolve(topic)
    kind = bag.topics[name].type
    positions = {
        "nav_msgs/msg/Odometry": "pose.pose.position",
        "geometry_msgs/msg/PoseStamped": "pose.position",
        "geometry_msgs/msg/PoseWithCovarianceStamped": "pose.pose.position",
        "geometry_msgs/msg/PointStamped": "point",
        "heave_msgs/msg/PointMotion": "position",
    }
    if kind in positions:
        at = positions[kind]
        named = {"surge": "x", "sway": "y", "heave": "z"}
        return SeaMapping({motion: Channel(topic=name, field=f"{at}.{axis}") for motion, axis in named.items()})
    heaves = {
        "std_msgs/msg/Float64": Channel(topic=name),
        "std_msgs/msg/Float32": Channel(topic=name),
        "heave_msgs/msg/MruSample": Channel(topic=name, field="heave"),
        "heave_msgs/msg/WaveElevation": Channel(topic=name, field="elevation"),
        "sensor_msgs/msg/Imu": Channel(topic=name, field="linear_acceleration.z", acceleration=True),
    }
    if kind not in heaves:
        raise BagError(f"{bag.path}: {name} is {kind}, which is not a motion by itself: write a mapping file")
    return SeaMapping({"heave": heaves[kind]})


def import_sea(source: Path, mapping: SeaMapping | str, window: Window = WHOLE) -> ImportedSea:
    """Read a bag or a log as boom-tip motion: the longest stretch without a gap that is too long.

    Parameters
    ----------
    source : bag, or text file with columns (.csv, .txt, .log, .tsv)
    mapping : where to find what; a text is the name of one topic of a bag
    window : what of the record is wanted

    Raises BagError if something named is missing, if nothing is in the window, or if there are fewer than 10 samples.
    """
    notes: list[str] = []
    if isinstance(mapping, str):
        mapping = mapping_for_topic(Bag(source), mapping)
    is_log = source.suffix.lower() in LOGS
    signals = _log_signals(source, mapping, notes) if is_log else _bag_signals(source, mapping, notes)
    checked = {name: _checked(source, name, signal, notes) for name, signal in signals.items()}
    try:
        start, end = longest_stretch(checked, window, notes)
    except BagError as error:
        raise BagError(f"{source}: {error}") from error
    count = math.floor((end - start) * mapping.rate + 1e-6) + 1
    if count < 10:
        raise BagError(f"{source}: the longest stretch has only {max(end - start, 0.0):.2f} s")
    time = np.arange(count) / mapping.rate
    motions = {
        name: _resampled(_near(signal, start, end, window.bridge), mapping.channels[name], start, time)
        for name, signal in checked.items()
    }
    position = boom_tip_motion(motions, mapping.lever_arm, count)
    return ImportedSea(time, position - position.mean(axis=0), notes, start)


def boom_tip_motion(motions: Mapping[str, Array], lever_arm: Sequence[float], count: int) -> Array:
    """Return the position of a point that is fixed to the vessel at `lever_arm` from the sensor, shape (count, 3) [m].

    Rotation by roll (starboard down positive, about x forward), then pitch (bow down positive, about y to port):
    REP-103. `motions` has each degree of freedom by name, `count` samples [m], [rad].
    """
    none = np.zeros(count)
    roll, pitch = motions.get("roll", none), motions.get("pitch", none)
    x, y, z = lever_arm
    y_rolled = y * np.cos(roll) - z * np.sin(roll)
    z_rolled = y * np.sin(roll) + z * np.cos(roll)
    return np.column_stack(
        (
            motions.get("surge", none) + x * np.cos(pitch) + z_rolled * np.sin(pitch),
            motions.get("sway", none) + y_rolled,
            motions["heave"] - x * np.sin(pitch) + z_rolled * np.cos(pitch),
        )
    )


def _bag_signals(source: Path, mapping: SeaMapping, notes: list[str]) -> dict[str, Signal]:
    bag = Bag(source)
    for name, channel in mapping.channels.items():
        if not channel.topic:
            raise BagError(f"{source}: {name} names a column, but this is a bag: name a topic")
    wanted: dict[str, set[str]] = {}
    for channel in mapping.channels.values():
        wanted.setdefault(channel.topic, set()).add(channel.field)
    columns = bag.columns(wanted)
    notes += [str(loss) for loss in bag.losses]
    signals = {}
    for name, channel in mapping.channels.items():
        topic = columns[channel.topic]
        names = [f"{channel.field}.{axis}" for axis in "xyzw"] if channel.part else [channel.field]
        missing = [column for column in names if column not in topic]
        if missing:
            raise BagError(f"{source}: {name}: {channel.topic} has no field {missing[0]}")
        values = [np.asarray(topic[column], dtype=float) for column in names]
        signals[name] = Signal(topic[TIME], euler_part(channel.part, *values) if channel.part else values[0])
    return signals


def euler_part(part: str, x: Array, y: Array, z: Array, w: Array) -> Array:
    """Return `part`, roll, pitch or yaw [rad] (about x, y, z, in the order z-y-x), of the quaternions x, y, z, w."""
    if part == "roll":
        return np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    if part == "pitch":
        return np.arcsin(np.clip(2.0 * (w * y - z * x), -1.0, 1.0))
    return np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def _log_signals(source: Path, mapping: SeaMapping, notes: list[str]) -> dict[str, Signal]:
    log = ShipLog(source)
    time, words = log.time(mapping.time_column, mapping.time_scale)
    notes += [words] if words else []
    for name, channel in mapping.channels.items():
        if not channel.column:
            raise BagError(f"{source}: {name} names a topic, but this is a log: name a column")
    return {name: Signal(time, log.numbers(channel.column, name)) for name, channel in mapping.channels.items()}


def _checked(source: Path, name: str, signal: Signal, notes: list[str]) -> Signal:
    good = np.isfinite(signal.value) & np.isfinite(signal.time)
    time, value = signal.time[good], signal.value[good]
    later = np.ones(time.size, dtype=bool)
    if time.size:
        later[1:] = time[1:] > np.maximum.accumulate(time)[:-1]
    left_out = signal.size - int(later.sum())
    if left_out:
        notes.append(f"{name}: {left_out} samples that are not numbers or not later than their predecessor skipped")
    time, value = time[later], value[later]
    if time.size < 10:
        raise BagError(f"{source}: {name} has {time.size} usable samples, 10 are needed")
    return Signal(time, value)


def _near(signal: Signal, start: float, end: float, margin: float) -> Signal:
    """Return a signal from a little before `start` to a little after `end` [s]: what lies beyond a gap is left out."""
    near = (signal.time >= start - margin) & (signal.time <= end + margin)
    return Signal(signal.time[near], signal.value[near])


def _resampled(signal: Signal, channel: Channel, start: float, time: Array) -> Array:
    """Return a channel at times after a start [s]; counted from there, so that Unix time costs no digits."""
    values: Array = CubicSpline(signal.time - start, channel.scale * signal.value + channel.offset)(time)
    return integrated_twice(values, float(time[1] - time[0]), channel.cut_off) if channel.acceleration else values


def integrated_twice(acceleration: Array, period: float, cut_off: float) -> Array:
    """Return the motion whose second derivative is `acceleration`, about its mean, samples `period` [s] apart.

    What is slower than `cut_off` [rad/s] is taken out. In the frequency domain: X = -A/omega^2, faded in over the half
    octave below and above the cut-off. The ends of the record ring; whole records of minutes are meant.
    """
    transform = np.fft.rfft(acceleration - acceleration.mean())
    omega = 2.0 * math.pi * np.fft.rfftfreq(acceleration.size, period)
    octaves = np.log2(np.maximum(omega, 1e-12) / cut_off)
    gain = np.clip(octaves + 0.5, 0.0, 1.0)
    gain = gain * gain * (3.0 - 2.0 * gain)
    with np.errstate(divide="ignore", invalid="ignore"):
        motion = np.where(gain > 0.0, -transform * gain / omega**2, 0.0)
    return np.asarray(np.fft.irfft(motion, acceleration.size))


def write_sea(sea: ImportedSea, output: Path, source: Path) -> None:
    """Write the motion `sea`, which was read from `source`, to `output` as the CSV file that `wave_vessel` takes.

    Raises BagError if it cannot be written.
    """
    lines = [f"# boom-tip motion about its mean, from {source.name}", "time_s,x_m,y_m,z_m"]
    lines += [f"{t:.4f},{x:.6f},{y:.6f},{z:.6f}" for t, (x, y, z) in zip(sea.time, sea.position, strict=True)]
    try:
        output.write_text("\n".join(lines) + "\n", encoding="utf-8")
    except OSError as error:
        raise BagError(f"{output}: cannot be written: {error.strerror}") from error
