"""A map file: what a device says, where, in which unit and sign; for a live device and for its records alike.

At its top level each quantity has its channel; the other entries say how the device is reached, how its lines are read,
where the boom tip is from the sensor, and what is sent to a winch. What only a live device needs, a record ignores, and
the other way round.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

from heave_node.files.bounded_yaml import parse_yaml
from heave_node.files.given_files import read_given
from heave_node.tick.clock_rule import LARGEST_LATENCY

from heave_devices.formats.datagram import DATAGRAM, DatagramDecoder, Layout
from heave_devices.formats.nmea import NmeaDecoder
from heave_devices.formats.nmea_sentences import UNSIGNED
from heave_devices.formats.number_kinds import split_bit, wrap_of
from heave_devices.formats.pattern import PatternDecoder
from heave_devices.formats.registers import BIT_TABLES, WRITABLE, register_of
from heave_devices.formats.sample import Decoder, Sample, TimeBase
from heave_devices.formats.table import FORMATS, LINE
from heave_devices.maps.channel import Channel, MapError, as_kind, placed, plain_entries, read_channel, refuse_unknown
from heave_devices.maps.command_map import CommandMap, read_command, read_layout
from heave_devices.maps.field_path import FieldPath
from heave_devices.maps.link import Link, read_link
from heave_devices.maps.quantities import NED_WAYS, QUANTITIES, outputs_of

CLOCKS = ("receipt", "own")
FRAMES = ("ENU", "NED")
_FORMATS = (*FORMATS, LINE, DATAGRAM)
LONGEST_ARM = 300.0
"""Largest lever arm from a sensor to the boom tip [m]."""


@dataclass(frozen=True)
class RecordForm:
    """What a record needs besides: see `heave_devices.records.sea_mapping.SeaMapping`."""

    time_column: str | Sequence[str] = ""  # of a log in columns
    time_scale: float = 1.0  # of a log in columns [s]
    date_order: str = ""  # of a log in columns
    rate: float = 20.0  # samples per second of the result [1/s]
    sample_rate: float = 0.0  # of sentences without any time [Hz], live too: see `counted_time`; 0: they have one


@dataclass(frozen=True)
class DeviceMap:
    """A map."""

    name: str  # of the file, without its ending
    channels: Mapping[str, Channel]  # by quantity
    lever_arm: tuple[float, float, float] = (0.0, 0.0, 0.0)  # boom tip from the sensor, x forward, y to port, z up [m]
    link: Link | None = None  # how the device is reached; None: by the topics of its channels, or not live
    format: str = ""  # how its lines are read: see `formats`, `pattern`, `nmea`
    pattern: str = ""  # how its lines are read: see `formats`, `pattern`, `nmea`
    checksum: str = ""  # how its lines are read: see `formats`, `pattern`, `nmea`
    needs_checksum: bool = True  # how its lines are read: see `formats`, `pattern`, `nmea`
    layout: Layout | None = None  # of its datagrams; None: it sends something else
    clock: str = "receipt"  # "receipt", or "own": the device's own time is the stamp
    timeout: float = 1.0  # silence after which the device is stale [s]
    latency: float = 0.0  # by which what it measures is older than its stamp, or its arrival, says [s]
    boom_tip: bool = True  # the map's MRU also moves the simulated boom tip
    boom_tip_height: float = 0.0  # of the boom tip at rest above still water [m]
    command: CommandMap | None = None  # what is sent to a winch; None: nothing
    record: RecordForm = field(default_factory=RecordForm)  # what a record needs besides

    @property
    def outputs(self) -> tuple[str, ...]:
        """Topics of the suite that it publishes."""
        return outputs_of(self.channels)

    @property
    def topics(self) -> dict[str, str]:
        """Topics that it subscribes to, each with its type."""
        return {channel.topic: channel.type for channel in self.channels.values() if channel.topic}

    @property
    def counter_wrap(self) -> float:
        """Time after which the counter of `device_time` begins again [s]; infinity: never."""
        channel = self.channels["device_time"]
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
    own = [known.name for known in fields(DeviceMap) if known.name not in ("name", "channels", "link", "record")]
    of_record = [known.name for known in fields(RecordForm)]
    refuse_unknown("", content, [*QUANTITIES, "source", "frame", "byte_order", *own, *of_record])
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
    record = _record({entry: content[entry] for entry in of_record if entry in content})
    device = DeviceMap(name, channels, link=read_link("source", content.get("source")), record=record, **values)
    _check(device)
    return device


def _arm(entry: Any) -> tuple[float, float, float]:
    if not isinstance(entry, list | tuple) or len(entry) != 3:
        raise MapError(f"lever_arm = {entry!r} must have three numbers: forward, to port, up [m]")
    x, y, z = (as_kind(float, "lever_arm", value) for value in entry)
    if max(abs(x), abs(y), abs(z)) > LONGEST_ARM:
        raise MapError(f"lever_arm = {entry} must be in metres: no boom tip is {LONGEST_ARM:g} m from its sensor")
    return x, y, z


def _record(entries: dict[str, Any]) -> RecordForm:
    columns = entries.get("time_column", "")
    if not isinstance(columns, str) and not (isinstance(columns, list) and all(isinstance(c, str) for c in columns)):
        raise MapError(f"time_column = {columns!r} must be a heading, or a list of headings")
    record = RecordForm(**{**entries, **plain_entries(RecordForm, "", entries)})
    if not record.rate > 0.0 or not record.sample_rate >= 0.0:
        raise MapError("rate must be above 0, sample_rate not below")
    return record


def _check(device: DeviceMap) -> None:
    """Raise MapError where the entries of a map contradict each other."""
    if device.clock not in CLOCKS:
        raise MapError(f"clock = {device.clock!r} must be one of {', '.join(CLOCKS)}")
    if not device.outputs:
        raise MapError(
            "heave is missing: give its topic and field, or its column; or another of pressure, tension, payout"
        )
    if device.format and device.format not in _FORMATS:
        raise MapError(f"format = {device.format!r} must be one of {', '.join(_FORMATS)}")
    if bool(device.pattern) != (device.format == LINE):
        raise MapError(f"pattern belongs to format: {LINE}, and {LINE} needs it")
    if (device.layout is not None) != (device.format == DATAGRAM):
        raise MapError(f"layout belongs to format: {DATAGRAM}, and {DATAGRAM} needs it")
    _check_live(device)
    if device.is_polled:
        _check_polled(device)
        return
    command = device.command
    if command is not None and not (command.line or command.topic or command.layout):
        raise MapError("command: set alone is for a source by modbus or opcua: add a line, a layout, or a topic")
    if device.format:
        _check_fields(device)
    else:
        for quantity, channel in device.channels.items():
            if not channel.topic and not channel.column:
                raise MapError(
                    f"{quantity} needs either a topic or a column, or the map a format: {', '.join(_FORMATS)}"
                )
            with placed(quantity):
                paths = (channel.field, channel.valid, channel.turned_by)
                _ = [FieldPath(path) for path in paths if path and channel.topic]


def _check_live(device: DeviceMap) -> None:
    for name, least, most in (("timeout", 0.05, 60.0), ("latency", 0.0, LARGEST_LATENCY)):
        if not least <= getattr(device, name) <= most:
            raise MapError(f"{name} = {getattr(device, name):g} must be from {least:g} to {most:g} s")
    wrong = next((name for name, channel in device.channels.items() if channel.acceleration and channel.type), None)
    if wrong is not None:
        raise MapError(f"{wrong}: of an acceleration alone no live {wrong} can be made: give it, or its velocity")


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
