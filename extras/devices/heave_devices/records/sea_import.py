"""A ship's own records become a sea for the loop: bags with any topics, or CSV logs, to boom-tip motion.

A mapping says where heave, and if known surge, sway, roll and pitch, are found, and where the boom tip lies from
the sensor. The result is a CSV file with columns time_s, x_m, y_m, z_m, which `wave_vessel` plays with
`boom_tip_source: file`.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from heave_bags.analyse.time_base import LONGEST_GAP
from heave_bags.errors import BagError
from heave_bags.mcap.loss import remarks
from heave_bags.mcap.reader import TIME, Bag
from heave_bags.signals import Signal, integrated
from heave_node.files.given_files import whole_file
from heave_node.files.plausible import PLAUSIBLE, question, refusal, sea_question
from heave_node.numerics.arrays import Array
from heave_node.numerics.kinematics import euler_part, turned
from heave_node.numerics.spectral_estimate import RecordTooShortError, height_and_period
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from heave_devices.maps.channel import Channel, with_standard_frame
from heave_devices.maps.device_map import DeviceMap
from heave_devices.records.device_log import device_signals
from heave_devices.records.sample_checks import Findings, without_fill, without_marks, without_standstill
from heave_devices.records.sea_mapping import MOTIONS, mapping_for_topic
from heave_devices.records.ship_log import ShipLog, is_text
from heave_devices.records.ship_time import time_words
from heave_devices.records.stretches import Window, longest_stretch

WHOLE = Window()
ACCEPT = "--accept-implausible"
"""Option of `heave import` that takes implausible figures."""


@dataclass
class ImportedSea:
    """Boom-tip motion about its mean."""

    time: Array  # from 0 [s]
    position: Array  # shape (n, 3) [m]
    notes: list[str] = field(default_factory=list)  # what is left out or bridged
    start: float = 0.0  # time of the record at which it begins [s]: Unix time, where the record has that


def import_sea(
    source: Path, mapping: DeviceMap | str, window: Window = WHOLE, *, accept_implausible: bool = False
) -> ImportedSea:
    """Read a bag or a log as boom-tip motion: the longest stretch without a gap that is too long.

    Samples that are invalid, hold a fill value or stand still are gaps, and said.

    Parameters
    ----------
    source : bag, or text file with columns
    mapping : where to find what; a text is the name of one topic of a bag
    window : what of the record is wanted
    accept_implausible : take all samples as they are; what is implausible is in the notes

    Raises BagError if something named is missing, if nothing is in the window, if there are fewer than 10 samples, or
    for a constant heave or implausible figures (`heave_node.files.plausible`).
    """
    findings = Findings(accept_implausible)
    if isinstance(mapping, str):
        if is_text(source):
            ShipLog(source)
            raise BagError(f"{source}: is a log in columns, not a bag: give --column or --mapping")
        mapping = mapping_for_topic(Bag(source), mapping)
    if "heave" not in mapping.channels:
        raise BagError(f"{mapping.name}: heave is missing: give its topic and field, or its column")
    checked = record_channels(source, mapping, MOTIONS, findings)
    if not np.ptp(checked["heave"].value):
        raise BagError(f"{source}: heave is constant: no sea, or a sensor that did not measure")
    interval = float(np.median(np.diff(checked["heave"].time)))
    if interval > window.bridge or interval < PLAUSIBLE["sample interval"].least:
        findings.ask(question("sample interval", interval, "time") + " give the size of its unit by --time-scale")
    _refuse(source, findings)
    try:
        start, end = longest_stretch(checked, window, findings.notes)
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
    sea = ImportedSea(time, position - position.mean(axis=0), findings.notes, start)
    findings.ask(_sea_question(sea.position[:, 2], 1.0 / mapping.rate))
    _refuse(source, findings)
    return sea


def record_channels(
    source: Path, mapping: DeviceMap, quantities: Sequence[str], findings: Findings
) -> dict[str, Signal]:
    """Return the channels of a record by name, in SI units and the suite's signs, usable samples alone.

    Parameters
    ----------
    source : bag, log in columns, or what a device sent
    mapping : where each is found
    quantities : that are wanted, as far as the mapping has them
    findings : takes what is said and asked

    Raises BagError where something named is missing, or has fewer than 10 usable samples.
    """
    channels = {name: mapping.channels[name] for name in quantities if name in mapping.channels}
    if mapping.format:
        signals = device_signals(source, mapping, list(channels), findings)
    elif is_text(source):
        signals = _log_signals(source, mapping, channels, findings)
    else:
        bag = Bag(source)
        channels = _with_standard_frames(bag, channels)
        signals = _bag_signals(bag, channels, findings)
    return {name: _checked(source, name, signal, channels[name], findings) for name, signal in signals.items()}


def _refuse(source: Path, findings: Findings) -> None:
    """Raise BagError for what is implausible, unless that is accepted."""
    if findings.questions:
        raise BagError(f"{source}: {refusal(findings.questions, ACCEPT)}")


def _sea_question(heave: Array, period: float) -> str:
    """Return what is implausible about heave [m] at samples `period` [s] apart as that of a ship in a sea."""
    objection = question("four standard deviations of heave", 4.0 * float(heave.std()))
    try:
        found = height_and_period(heave, period)
    except RecordTooShortError:
        swing = heave[np.abs(heave) > 0.5 * heave.std()]
        turns = int(np.count_nonzero(np.diff(np.sign(swing))))
        crossing = 2.0 * heave.size * period / max(turns, 1)
        return objection or (sea_question(4.0 * float(heave.std()), crossing, crossing) if turns > 3 else "")
    return objection or sea_question(found.significant_height, found.peak_period, found.peak_period)


def boom_tip_motion(motions: Mapping[str, Array], lever_arm: Sequence[float], count: int) -> Array:
    """Return the position of a point that is fixed to the vessel at `lever_arm` from the sensor, shape (count, 3) [m].

    Rotation by roll (starboard down positive, about x forward), then pitch (bow down positive, about y to port):
    REP-103. `motions` has each degree of freedom by name, `count` samples [m], [rad].
    """
    surge, sway, heave, roll, pitch = (motions.get(name, np.zeros(count)) for name in MOTIONS)
    turn = Rotation.from_euler("xy", np.column_stack((roll, pitch)))
    position: Array = np.column_stack((surge, sway, heave)) + turn.apply(lever_arm)
    return position


def _with_standard_frames(bag: Bag, channels: Mapping[str, Channel]) -> dict[str, Channel]:
    """Return `channels` of a `bag` in the frames that its types have; raise BagError where a topic is not named."""
    column = next((name for name, channel in channels.items() if not channel.topic), None)
    if column is not None:
        raise BagError(f"{bag.path}: {column} names a column, but this is a bag: name a topic")
    topics = {name: bag.topics[bag.resolve(channel.topic)] for name, channel in channels.items()}
    return {name: with_standard_frame(channel, topics[name].type) for name, channel in channels.items()}


def _bag_signals(bag: Bag, channels: Mapping[str, Channel], findings: Findings) -> dict[str, Signal]:
    wanted: dict[str, set[str]] = {}
    for channel in channels.values():
        wanted.setdefault(channel.topic, set()).update({*_fields(channel), *_validity_names(channel)})
    columns = bag.columns(wanted)
    findings.notes += remarks(bag.notes, bag.losses)
    signals = {}
    for name, channel in channels.items():
        topic = columns[channel.topic]
        names = _columns(channel)
        valid = next((column for column in _validity_names(channel) if _is_status(topic.get(column))), "")
        missing = [column for column in names if column not in topic]
        if missing:
            raise BagError(f"{bag.path}: {name}: {channel.topic} has no field {missing[0]}")
        if channel.valid and not valid:
            raise BagError(
                f"{bag.path}: {name}: {channel.topic} has no field {channel.valid} that is a number or a flag"
            )
        values = [np.asarray(topic[column], dtype=float) for column in names]
        if len(values) == 7:
            value = turned(values[:3], *values[3:])["xyz".index(channel.field[-1])]
        else:
            value = euler_part(channel.part, *values) if channel.part else values[0]
        if valid:
            is_good = np.array([channel.is_valid(float(status)) for status in np.asarray(topic[valid])], dtype=bool)
            value = findings.without_invalid(name, value, is_good, valid)
        signals[name] = Signal(topic[TIME], value)
    return signals


def _fields(channel: Channel) -> tuple[str, ...]:
    """Return the fields of a message that make up a channel: a number, a quaternion, or a vector and a quaternion."""
    is_turned = channel.turned_by not in ("", "none")
    return (channel.field[:-2], channel.turned_by) if is_turned else (channel.field,)


def _columns(channel: Channel) -> list[str]:
    """Return the columns of a bag that make up a channel, components in their order."""
    if channel.part:
        return [f"{channel.field}.{axis}" for axis in "xyzw"]
    if channel.turned_by in ("", "none"):
        return [channel.field]
    vector = [f"{channel.field[:-1]}{axis}" for axis in "xyz"]
    return vector + [f"{channel.turned_by}.{axis}" for axis in "xyzw"]


def _is_status(values: object) -> bool:
    """Return whether a column of a bag holds whole numbers or flags, one for each message."""
    return isinstance(values, np.ndarray) and values.ndim == 1 and values.dtype.kind in "biu"


def _validity_names(channel: Channel) -> tuple[str, ...]:
    """Return the fields or columns that may call the samples of a channel valid: the one named, else by custom."""
    own = channel.column or channel.field
    return (channel.valid,) if channel.valid else (f"{own}_valid", "valid")


def _log_signals(
    source: Path, mapping: DeviceMap, channels: Mapping[str, Channel], findings: Findings
) -> dict[str, Signal]:
    log = ShipLog(source)
    time, words = log.time(mapping.time_column, mapping.time_scale, mapping.date_order)
    findings.notes += log.notes + words
    signals = {}
    for name, channel in channels.items():
        if not channel.column:
            raise BagError(f"{source}: {name} names a topic, but this is a log: name a column")
        value = log.numbers(channel.column, name)
        valid = channel.valid or log.find(*_validity_names(channel))
        if valid:
            value = findings.without_invalid(name, value, log.validity(valid, channel), valid)
        unit, size = log.stated_scale(channel.column, name)
        if unit and channel.scale == 1.0 and not (channel.unit or channel.positive):
            findings.ask(
                f"column {channel.column} is in {unit} by its heading: give --scale {size:.6g}, or scale in a mapping;"
            )
        signals[name] = Signal(time, value)
    return signals


def _checked(source: Path, name: str, signal: Signal, channel: Channel, findings: Findings) -> Signal:
    """Return the usable samples of a channel, in metres or radians, in order of time."""
    good = np.isfinite(signal.value) & np.isfinite(signal.time) & ~np.isin(signal.value, channel.invalid_values)
    numbers = without_marks(name, Signal(signal.time[good], signal.value[good]), findings)
    time, value = numbers.time, channel.factor(name) * numbers.value + channel.offset
    later = _in_order(time)
    blank = 0 if _is_slower(time, signal.time) else int((~good).sum()) - findings.taken_out(name)
    left_out = blank + int((~later).sum())
    cause = _backward_words(time)
    if left_out:
        what = "1 sample" if left_out == 1 else f"{left_out} samples"
        findings.notes.append(f"{name}: {what} without a number, or not later than the one before, skipped{cause}")
    checked = Signal(time[later], value[later])
    checked = without_fill(name, checked, "" if channel.acceleration or channel.velocity else name, findings)
    if name.removesuffix("_rate").removesuffix("_acceleration") in MOTIONS:  # a drum may stand still
        checked = without_standstill(name, checked, findings)
    if channel.acceleration:
        findings.ask(_gravity_question(name, checked.value))
    if checked.size < 10:
        raise BagError(f"{source}: {name} has {checked.size} usable samples, 10 are needed{cause}")
    return checked


def _in_order(time: Array) -> NDArray[np.bool_]:
    """Return which of some times [s] make up the longest series in which each is later than the one before.

    So one time that is wrong costs one sample. By patience sorting: Fredman, Discrete Mathematics 11 (1975).
    """
    if not time.size or (np.diff(time) > 0.0).all():
        return np.ones(time.size, dtype=bool)
    ends: list[float] = []  # earliest end of a series of each length, and its place
    places: list[int] = []
    before = np.full(time.size, -1)
    for index, now in enumerate(time.tolist()):
        length = bisect_left(ends, now)
        before[index] = places[length - 1] if length else -1
        if length == len(ends):
            ends.append(now)
            places.append(index)
        elif now < ends[length]:
            ends[length], places[length] = now, index
    kept = np.zeros(time.size, dtype=bool)
    place = places[-1]
    while place >= 0:
        kept[place] = True
        place = int(before[place])
    return kept


def _is_slower(time: Array, rows: Array) -> bool:
    """Return whether a channel with numbers at each `time` [s] is but slower than the `rows` of its log [s]."""
    between = np.diff(time)
    if between.size < 2 or rows.size < 2:
        return False
    period = float(np.median(between))
    return period > 1.5 * float(np.median(np.diff(rows))) and float(between.max()) <= LONGEST_GAP * period


def _backward_words(time: Array) -> str:
    """Return in words where times [s] go back most, or do not go on; "" where each is later than the one before."""
    steps = np.diff(time)
    if not steps.size or steps.min() > 0.0:
        return ""
    worst = int(np.argmin(steps))
    if steps[worst] == 0.0:
        return f": {int(np.count_nonzero(steps <= 0.0))} times are those of the sample before; too few digits?"
    return f": the time goes back by {-steps[worst]:.6g} s after {time_words(time[worst])}"


def _gravity_question(name: str, acceleration: Array) -> str:
    """Return what is implausible about the mean of a vertical acceleration: gravity, or none, in m/s^2."""
    mean = float(np.mean(acceleration)) if acceleration.size else 0.0
    if 0.97 < abs(mean) < 1.03:
        return f"{name}: the mean acceleration is {mean:.3f}: in g? then give scale 9.80665;"
    return question("mean vertical acceleration", mean, name)


def _near(signal: Signal, start: float, end: float, margin: float) -> Signal:
    """Return a signal from a little before `start` to a little after `end` [s]: what lies beyond a gap is left out."""
    near = (signal.time >= start - margin) & (signal.time <= end + margin)
    return Signal(signal.time[near], signal.value[near])


def _resampled(signal: Signal, channel: Channel, start: float, time: Array) -> Array:
    """Return a channel at times after a start [s]; counted from there, so that Unix time costs no digits."""
    values: Array = CubicSpline(signal.time - start, signal.value)(time)
    if not (channel.acceleration or channel.velocity):
        return values
    return integrated(values, float(time[1] - time[0]), channel.cut_off, times=2 if channel.acceleration else 1)


def write_sea(sea: ImportedSea, output: Path, source: Path) -> None:
    """Write the motion `sea`, which was read from `source`, to `output` as the CSV file that `wave_vessel` takes.

    Raises OSError if it cannot be written.
    """
    lines = [f"# boom-tip motion about its mean, from {source.name}", "time_s,x_m,y_m,z_m"]
    lines += [f"{t:.4f},{x:.6f},{y:.6f},{z:.6f}" for t, (x, y, z) in zip(sea.time, sea.position, strict=True)]
    with whole_file(output) as unfinished:
        unfinished.write_text("\n".join(lines) + "\n", encoding="utf-8")
