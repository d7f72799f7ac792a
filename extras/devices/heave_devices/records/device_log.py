"""A log of what a device sent, line by line or frame by frame, as signals: by the maps and decoders of a live one."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from heave_bags.errors import BagError
from heave_bags.signals import Signal
from heave_node.files.given_files import read_given
from heave_node.numerics.arrays import Array

from heave_devices.formats.device_time import DeviceTime
from heave_devices.formats.sample import Counters, Decoder, Sample
from heave_devices.formats.table import FORMATS, LINE
from heave_devices.maps.device_map import DeviceMap, SampleField
from heave_devices.maps.quantities import QUANTITIES
from heave_devices.records.sample_checks import Findings
from heave_devices.records.ship_time import TimeError, from_1970, spread, time_of_texts

_START = re.compile(r"[$:#]")
_PIECE = 1 << 16


@dataclass
class _Record:
    """Samples of a log, each with the number of its line, the text before it, and its own time [s]; NaN: none."""

    samples: list[Sample] = field(default_factory=list)
    lines: list[int] = field(default_factory=list)
    stamps: list[str] = field(default_factory=list)
    times: list[float] = field(default_factory=list)


def device_signals(source: Path, device: DeviceMap, wanted: Sequence[str], findings: Findings) -> dict[str, Signal]:
    """Return the quantities that are `wanted` of a log, as the device sent them: units and signs are still the map's.

    Parameters
    ----------
    source : the log
    device : its map
    wanted : quantities of the map
    findings : takes what is said

    Raises BagError for a log that cannot be read, holds nothing that the map wants, or has no time.
    """
    try:
        data = read_given(source)
    except (OSError, ValueError) as error:
        raise BagError(f"{source}: {error}") from error
    decoder = device.decoder()
    record = _read(data, device, decoder)
    _note_counters(decoder.counters, findings)
    signals = {}
    for name in wanted:
        channel = device.channels[name]
        where = SampleField(device, channel)
        places = [index for index, sample in enumerate(record.samples) if where.is_in(sample)]
        if not places:
            raise BagError(f"{source}: {name}: nothing in it has {channel.field}{_what_there_is(record, decoder)}")
        time = _times(source, device, record, places, findings)
        signals[name] = _signal(name, where, time, [record.samples[place] for place in places], findings)
    return signals


def _read(data: bytes, device: DeviceMap, decoder: Decoder) -> _Record:
    """Read a whole log."""
    record = _Record()
    clock = DeviceTime(device.counter_wrap)
    is_text = device.format == LINE or (device.layout is None and FORMATS[device.format].is_text)
    size = _PIECE if device.layout is None else device.layout.size
    pieces = data.splitlines() if is_text else [data[at : at + size] for at in range(0, len(data), size)]
    for number, piece in enumerate(pieces):
        samples = decoder.feed(piece + b"\n" if is_text else piece)
        samples += decoder.end() if device.layout is not None else []
        stamp = ""
        if samples and is_text and device.format != LINE:
            text = piece.decode("latin-1")
            found = list(_START.finditer(text.replace(":", " ") if device.format == "nmea" else text))
            stamp = text[: found[-1].start()].strip(" ,;\t") if found else ""
        for sample in samples:
            own = clock.nanoseconds(device.own_time(sample))
            record.samples.append(sample)
            record.lines.append(number)
            record.stamps.append(stamp)
            record.times.append(np.nan if own is None else own * 1e-9)
    return record


def _signal(name: str, where: SampleField, time: Array, samples: Sequence[Sample], findings: Findings) -> Signal:
    value = np.array([None if where.is_invalid(sample) else where.number(sample) for sample in samples], dtype=float)
    invalid = sum(map(where.is_invalid, samples))
    if invalid:
        findings.notes.append(f"{name}: {invalid} samples that the device calls invalid left out")
    good = np.isfinite(value)
    return Signal(time[good], value[good])


def _times(source: Path, device: DeviceMap, record: _Record, places: Sequence[int], findings: Findings) -> Array:
    """Return the times of samples [s]: their own, the stamps before them, those of ZDA around them, or a fixed rate."""
    own = np.array([record.times[place] for place in places])
    stamps = [record.stamps[place] for place in places]
    has_own, has_stamps = bool(np.isfinite(own).mean() > 0.5), sum(map(bool, stamps)) > 0.5 * len(stamps)
    zda = [index for index, sample in enumerate(record.samples) if sample.kind == "ZDA"]
    words: list[str] = []
    if has_own and (device.clock == "own" or not has_stamps):
        time, words = from_1970(own)
    elif has_stamps:
        try:
            time, words = time_of_texts(stamps, device.date_order)
        except TimeError as error:
            raise BagError(f"{source}: the stamp before a sentence: {error}") from error
    elif len(zda) > 1:
        at = [record.lines[index] for index in zda]
        words = [f"time: by {len(zda)} sentences ZDA, evenly between them"]
        time = np.interp([record.lines[place] for place in places], at, [record.times[index] for index in zda])
    elif device.sample_rate > 0.0:
        time = np.arange(len(places)) / device.sample_rate
    else:
        raise BagError(f"{source}: has no time: {_why_no_time(device, record)}")
    time, how = spread(time)
    findings.notes += [note for note in words + how if note not in findings.notes]
    return time


def _why_no_time(device: DeviceMap, record: _Record) -> str:
    """Return in words why the samples of a log have no time, and what to do."""
    channel = device.channels.get("device_time")
    given = [] if channel is None else [s.values[channel.field] for s in record.samples if channel.field in s.values]
    if channel is None or not given:
        return (
            "its sentences have none, no stamp stands before them, and there is no ZDA: give sample_rate in the map, "
            "in samples per second"
        )
    seconds, largest = channel.factor("device_time") * given[0], QUANTITIES["device_time"].largest
    return f"device_time = {seconds:.4g} s, at most {largest:.4g} can be: check its unit and scale in the map"


def _note_counters(counters: Counters, findings: Findings) -> None:
    """Say what of a log is not used."""
    counts = {
        "checksums do not fit": counters.checksum_errors,
        "incomplete lines": counters.incomplete_lines,
        "malformed": counters.malformed,
    }
    wrong = ", ".join(f"{count} {words}" for words, count in counts.items() if count)
    if wrong:
        findings.notes.append(f"lines left out: {wrong}")
    if counters.unknown:
        findings.notes.append(f"lines of other kinds: {', '.join(list(counters.unknown)[:8])}")


def _what_there_is(record: _Record, decoder: Decoder) -> str:
    kinds = [*dict.fromkeys(sample.kind for sample in record.samples), *decoder.counters.unknown]
    broken = decoder.counters.checksum_errors
    nothing = f": {broken} wrong checksums: check the map's" if broken else ": nothing in it is as the format has it"
    return f"; it has {', '.join(kinds[:8])}" if kinds else nothing
