"""The formats that devices are read in: one name each, what reads it, and the fields that its sentences have."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from heave_devices.formats.kongsberg import KMB_FIELDS, EmAttitudeDecoder, KmBinaryDecoder
from heave_devices.formats.nmea import NmeaDecoder
from heave_devices.formats.nmea_sentences import FIELDS
from heave_devices.formats.sample import Decoder
from heave_devices.formats.tss1 import Tss1Decoder


@dataclass(frozen=True)
class Format:
    """A format."""

    make: Callable[[], Decoder]  # returns a new decoder
    fields: Mapping[str, tuple[str, ...]]  # of each sentence or frame, by its name
    is_text: bool = True  # lines, of which a log may have a stamp before each


FORMATS: Mapping[str, Format] = {
    "nmea": Format(NmeaDecoder, FIELDS),
    "tss1": Format(Tss1Decoder, {"TSS1": ("horizontal_acceleration", "heave_acceleration", "heave", "roll", "pitch")}),
    "km_binary": Format(KmBinaryDecoder, {"KMB": KMB_FIELDS}, is_text=False),
    "em3000": Format(EmAttitudeDecoder, {"EM3000": ("roll", "pitch", "heading", "heave")}, is_text=False),
}
"""Decoders by the name of their format; lines by a pattern of the map's own are `line`."""
LINE = "line"
