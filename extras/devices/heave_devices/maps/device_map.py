"""A map file: what a device says, where, in which unit and sign; for a live device and for its records alike.

At its top level each quantity has its channel; the other entries say how the device is reached, how its lines are read,
where the boom tip is from the sensor, and what is sent to a winch.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

from heave_node.files.bounded_yaml import parse_yaml
from heave_node.files.given_files import read_given
from heave_node.tick.clock_rule import LARGEST_LATENCY

from heave_devices.formats.datagram import DATAGRAM, DatagramDecoder, Layout
from heave_devices.formats.device_time import COUNTER_WRAP
from heave_devices.formats.nmea import NmeaDecoder
from heave_devices.formats.nmea_sentences import UNSIGNED
from heave_devices.formats.number_kinds import split_bit, wrap_of
from heave_devices.formats.pattern import PatternDecoder
from heave_devices.formats.registers import BIT_TABLES, WRITABLE, register_of
from heave_devices.formats.sample import Decoder, Sample, TimeBase
from heave_devices.formats.table import FORMATS, LINE
from heave_devices.maps.channel import (
    Channel,
    MapError,
    as_kind,
    outside,
    placed,
    plain_entries,
    read_channel,
    refuse,
    refuse_unknown,
)
from heave_devices.maps.command_map import CommandMap, read_command, read_layout
from heave_devices.maps.field_path import FieldPath
from heave_devices.maps.link import Link, read_link
from heave_devices.maps.quantities import NED_WAYS, OUTPUTS, QUANTITIES

CLOCKS = ("receipt", "own")
FRAMES = ("ENU", "NED")
_FORMATS = (*FORMATS, LINE, DATAGRAM)
LONGEST_ARM = 300.0
"""Largest lever arm from a sensor to the boom tip [m]."""


@dataclass(frozen=True)
class DeviceMap:
    """A map; what only a live device needs, a record ignores, and the other way round."""

    channels: Mapping[str, Channel]  # by quantity
    name: str = "map"  # of the file, without its ending
    lever_arm: tuple[float, float, float] = (0.0, 0.0, 0.0)  # boom tip from the sensor, x forward, y to port, z up [m]
    link: Link | None = None  # how the device is reached; None: by the topics of its channels, or not live
    format: str = ""  # how its lines are read: see `formats`, `pattern`, `nmea`
    pattern: str = ""  # see `pattern`
    checksum: str = ""  # see `pattern`
    needs_checksum: bool = True  # see `nmea`
    layout: Layout | None = None  # of its datagrams; None: it sends something else
    clock: str = "receipt"  # "receipt", or "own": the device's own time is the stamp
    timeout: float = 1.0  # silence after which the device is stale [s]
    latency: float = 0.0  # by which what it measures is older than its stamp, or its arrival, says [s]
    boom_tip: bool = True  # the map's MRU also moves the simulated boom tip
    boom_tip_height: float = 0.0  # of the boom tip at rest above still water [m]
    command: CommandMap | None = None  # what is sent to a winch; None: nothing
    # of a log in columns: heading of its time, or those of date and time or of GPS week and seconds; "": found by name
    time_column: str | Sequence[str] = ""
    time_scale: float = 1.0  # of a log in columns: numbers are seconds after it, or found out: see `ship_time`
    date_order: str = ""  # of a log: dates with the year last, dmy or mdy; "": as the dates themselves show
    rate: float = 20.0  # samples per second of the sea that is made of a record [1/s]
    sample_rate: float = 0.0  # of sentences without any time [Hz], live too: see `counted_time`; 0: they have one

    @property
    def outputs(self) -> tuple[str, ...]:
        """Topics of the suite that it publishes."""
        return tuple(topic for topic, (needed, _) in OUTPUTS.items() if not self.channels.keys().isdisjoint(needed))

    @property
    def topics(self) -> dict[str, str]:
        """Topics that it subscribes to, each with its type."""
        return {channel.topic: channel.type for channel in self.channels.values() if channel.topic}

    @property
    def counter_wrap(self) -> float:
        """Time after which its counter, that of `device_time` where it has one, begins again [s]; infinity: never."""
        channel = self.channels.get("device_time")
        if channel is None:
            return COUNTER_WRAP
        kind = self.kind_of(channel.field)
        return wrap_of(kind) * channel.factor("device_time") if kind else math.inf

    def kind_of(self, field_name: str) -> str:
        """Return the kind of number that the field `field_name` holds; "": not known."""
        if self.link is not None and self.link.kind == "modbus":
            register = register_of(field_name)
            return "" if register.table in BIT_TABLES else register.kind
        return "" if self.layout is None else self.layout.fields[self.bit_of(field_name)[0]]

    @property
    def has_names(self) -> bool:
        """Whether its fields are names of the map's own, registers or nodes, not those of sentences."""
        return self.format in (LINE, DATAGRAM) or self.is_polled

    @property
    def is_polled(self) -> bool:
        """Whether it is asked for its values, as a PLC is."""
        return self.link is not None and self.link.is_polled

    def own_time(self, sample: Sample) -> Sample:
        """Return a `sample` with the time of the clock or counter that the map names, if it names one."""
        channel = self.channels.get("device_time")
        if channel is None:
            return sample
        raw = sample.values.get(channel.field, math.nan)
        time = channel.factor("device_time") * raw + channel.offset
        is_usable = abs(time) <= QUANTITIES["device_time"].largest
        return replace(sample, time=time if is_usable else None, time_base=TimeBase.COUNTER)

    def bit_of(self, field_name: str) -> tuple[str, int | None]:
        """Return what the field `field_name` is called where it is read, and the bit of it; None: the whole number."""
        has_bits = self.format == DATAGRAM or (self.link is not None and self.link.kind == "modbus")
        return split_bit(field_name) if has_bits else (field_name, None)

    def decoder(self) -> Decoder:
        """Return a new decoder of its format."""
        if self.format == LINE:
            return PatternDecoder(self.pattern, self.checksum)
        if self.layout is not None:
            return DatagramDecoder(self.layout)
        if self.format == "nmea":
            return NmeaDecoder(needs_checksum=self.needs_checksum)
        return FORMATS[self.format].make()


class SampleField:
    """Where the quantity of a `channel` of a map, `device`, is found in samples."""

    def __init__(self, device: DeviceMap, channel: Channel) -> None:
        self._channel = channel
        self._device = device
        sentence, _, name = channel.field.partition(".")
        self._sentence, self._name = ("", channel.field) if device.has_names else (sentence, name)
        self._valid = channel.valid if device.has_names else channel.valid.removeprefix(f"{sentence}.")

    def is_in(self, sample: Sample) -> bool:
        """Return whether a `sample` is of the sentence that it is in."""
        return self._sentence in ("", sample.kind)

    def is_invalid(self, sample: Sample) -> bool:
        """Return whether a `sample` calls it invalid, or does not say so."""
        place, _ = self._device.bit_of(self._name)
        if place in sample.invalid:
            return True
        if not self._valid:
            return False
        status = self._number(sample, self._valid)
        word = sample.words.get(self._valid)
        return not self._channel.is_valid(status if word is None else word)

    def number(self, sample: Sample) -> float | None:
        """Return what a `sample` holds of it, as sent, with the sign of its letter; None: nothing."""
        is_there = self._device.bit_of(self._name)[0] in sample.values
        return self._channel.signed(self._number(sample, self._name), sample.words) if is_there else None

    def _number(self, sample: Sample, name: str) -> float:
        place, bit = self._device.bit_of(name)
        value = sample.values.get(place, math.nan)
        return float(int(value) >> bit & 1) if bit is not None and math.isfinite(value) else value


def read_device_map(path: Path) -> DeviceMap:
    """Read the map file at `path` (YAML). Raises MapError, in one line, with the file and the entry that is wrong."""
    try:
        return device_map_of(path.stem, parse_yaml(read_given(path), only_true_and_false=True))
    except MapError as error:
        raise MapError(f"{path}: {error}") from None
    except (OSError, ValueError) as error:
        raise MapError(f"{path}: cannot be read as a mapping: {' '.join(str(error).split())}") from error


def device_map_of(name: str, content: Any) -> DeviceMap:
    """Return the map called `name` with the `content` of a file. Raises MapError for what cannot be."""
    if not isinstance(content, dict):
        raise MapError("is no map: its lines are QUANTITY: where it is found, as in heave: {column: heave}")
    own = [known.name for known in fields(DeviceMap) if known.name not in ("name", "channels", "link")]
    refuse_unknown("", content, [*QUANTITIES, "source", "frame", "byte_order", *own])
    frame = content.get("frame", "ENU")
    if frame not in FRAMES:
        raise MapError(f"frame = {frame!r} must be one of {', '.join(FRAMES)}")
    channels = {
        quantity: read_channel(quantity, entry, NED_WAYS.get(quantity, "") if frame == "NED" else "")
        for quantity, entry in content.items()
        if quantity in QUANTITIES
    }
    values = {entry: content[entry] for entry in own if entry in content}
    if "device_time" in channels:
        values.setdefault("clock", "own")
    values["layout"] = read_layout("", content)
    values["command"] = read_command(values.get("command"))
    values["lever_arm"] = _arm(values.get("lever_arm", (0.0, 0.0, 0.0)))
    values |= plain_entries(DeviceMap, "", values)
    device = DeviceMap(channels, name, link=read_link("source", content.get("source")), **values)
    _check(device)
    return device


def _arm(entry: Any) -> tuple[float, float, float]:
    if not isinstance(entry, list | tuple) or len(entry) != 3:
        raise MapError(f"lever_arm = {entry!r} must have three numbers: forward, to port, up [m]")
    x, y, z = (as_kind(float, "lever_arm", value) for value in entry)
    if max(abs(x), abs(y), abs(z)) > LONGEST_ARM:
        raise MapError(f"lever_arm = {entry} must be in metres: no boom tip is {LONGEST_ARM:g} m from its sensor")
    return x, y, z


def _check(device: DeviceMap) -> None:
    """Raise MapError where the entries of a map contradict each other."""
    columns = [device.time_column] if isinstance(device.time_column, str) else device.time_column
    is_headings = isinstance(columns, list) and all(isinstance(column, str) for column in columns)
    quantities = device.channels.items()
    wrong = next((name for name, channel in quantities if channel.acceleration and channel.type), None)
    command = device.command
    has_way = command is not None and (command.line or command.topic or command.layout)
    refuse(
        "",
        (device.clock not in CLOCKS, f"clock = {device.clock!r} must be one of {', '.join(CLOCKS)}"),
        (not is_headings, f"time_column = {columns!r} must be a heading, or a list of headings"),
        (not device.rate > 0.0 or not device.sample_rate >= 0.0, "rate must be above 0, sample_rate not below"),
        (
            not device.outputs,
            "heave is missing: give its topic and field, or its column; or another of pressure, tension, payout",
        ),
        (
            device.format and device.format not in _FORMATS,
            f"format = {device.format!r} must be one of {', '.join(_FORMATS)}",
        ),
        *(
            (bool(entry) != (device.format == kind), f"{name} belongs to format: {kind}, and {kind} needs it")
            for name, entry, kind in (("pattern", device.pattern, LINE), ("layout", device.layout, DATAGRAM))
        ),
        outside("timeout", device.timeout, 0.05, 60.0, " s"),
        outside("latency", device.latency, 0.0, LARGEST_LATENCY, " s"),
        (wrong, f"{wrong}: of an acceleration alone no live {wrong} can be made: give it, or its velocity"),
        (
            command is not None and not has_way and not device.is_polled,
            "command: set alone is for a source by modbus or opcua: add a line, a layout, or a topic",
        ),
    )
    if device.is_polled:
        _check_polled(device)
    elif device.format:
        _check_fields(device)
    else:
        for quantity, channel in quantities:
            is_found = channel.topic or channel.column
            formats = ", ".join(_FORMATS)
            refuse(f"{quantity} ", (not is_found, f"needs either a topic or a column, or the map a format: {formats}"))
            with placed(quantity):
                paths = (channel.field, channel.valid, channel.turned_by)
                _ = [FieldPath(path) for path in paths if path and channel.topic]


def _check_polled(device: DeviceMap) -> None:
    """Raise MapError for what a PLC that is asked for its values cannot give or take."""
    assert device.link is not None
    if device.format:
        raise MapError(f"format belongs to what is sent unasked: a source by {device.link.kind} needs none")
    command = device.command
    if command is not None and (command.line or command.topic or command.layout or command.link):
        raise MapError(f"command: {device.link.kind} needs set alone, and no to: orders go back to the source")
    for quantity, channel in device.channels.items():
        if channel.topic or channel.column:
            raise MapError(f"{quantity}: has a topic or a column, but the map's source is a PLC")
        if device.link.kind == "modbus":
            for where, name in ((quantity, channel.field), (f"{quantity}: valid", channel.valid)):
                with placed(where):
                    _ = register_of(name) if name else None
    if command is not None and device.link.kind == "modbus":
        for order in command.orders:
            with placed("command: set"):
                if register_of(order.path).table not in WRITABLE:
                    raise ValueError(f"{order.path}: only {' and '.join(WRITABLE)} can be written")


def _check_fields(device: DeviceMap) -> None:
    """Raise MapError for a field that the format does not have, or whose sign must be said."""
    if device.format == LINE:
        with placed(""):
            known = sorted(PatternDecoder(device.pattern, device.checksum).fields)
    elif device.layout is not None:
        if device.link is not None and device.link.kind != "udp":
            raise MapError(f"format: {DATAGRAM} needs a source by udp")
        known = sorted(device.layout.fields)
    else:
        table = FORMATS[device.format].fields
        known = [f"{sentence}.{name}" for sentence, names in table.items() for name in names]
    for quantity, channel in device.channels.items():
        if channel.topic or channel.column:
            raise MapError(
                f"{quantity}: has a {'topic' if channel.topic else 'column'}, but the map has a format of lines"
            )
        if channel.sign_field and device.format != LINE:
            raise MapError(f"{quantity}: sign belongs to format: {LINE}")
        for name in filter(None, (channel.field, channel.valid, channel.sign_field)):
            refuse_unknown(quantity, {device.bit_of(name)[0]: None}, known)
        why = UNSIGNED.get(channel.field)
        if why and not channel.positive:
            ways = " or ".join(f"positive: {way}" for way in QUANTITIES[quantity].ways)
            raise MapError(f"{quantity}: say {ways}, after your device's manual: {why}")
        if (channel.positive or channel.unit) and not device.has_names and not why:
            raise MapError(
                f"{quantity}: {channel.field} is in SI units and of known sign already: leave unit and positive out"
            )
