"""The formats that devices are read in: one name each, what reads it, and the fields that its sentences have."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from heave_devices.formats.kongsberg import EmAttitudeDecoder, KmBinaryDecoder
from heave_devices.formats.nmea import NmeaDecoder
from heave_devices.formats.sample import Decoder
from heave_devices.formats.tss1 import Tss1Decoder

_ATTITUDE = ("roll", "pitch", "heading")


@dataclass(frozen=True)
class Format:
    """A format."""

    make: Callable[[], Decoder]  # returns a new decoder
    fields: Mapping[str, tuple[str, ...]]  # of each sentence or frame, by its name
    meaning: str  # one line for the list of formats
    is_text: bool = True  # lines, of which a log may have a stamp before each


FORMATS: Mapping[str, Format] = {
    "nmea": Format(
        NmeaDecoder,
        {
            "PSXN20": ("height_quality", "attitude_quality"),
            "PSXN22": ("gyro_calibration", "gyro_offset"),
            "PSXN23": (*_ATTITUDE, "heave"),
            "PSXN24": ("roll_rate", "pitch_rate", "yaw_rate", "heave_rate"),
            "PASHR": (
                *(*_ATTITUDE, "heave", "roll_sigma", "pitch_sigma", "heading_sigma"),
                *("aiding_status", "imu_status"),
            ),
            "PHOCT": (
                *(*_ATTITUDE, "heave_primary", "heave", "surge", "sway"),
                *("heave_rate", "surge_rate", "sway_rate", "yaw_rate"),
            ),
            "PNORSUB": (*_ATTITUDE, "heave"),
            "PNORSUB2": (*_ATTITUDE, "heave", "heave_rate"),
            "PENCR": tuple(f"{name}_{index}" for index in range(1, 6) for name in ("angle", "extension")),
            "ZDA": (),
        },
        "sentences of NMEA 0183: PSXN 20, 22, 23, 24, PASHR, PHOCT, PNORSUB, PNORSUB2, PENCR, ZDA",
    ),
    "tss1": Format(
        Tss1Decoder,
        {"TSS1": ("horizontal_acceleration", "heave_acceleration", "heave", "roll", "pitch")},
        "TSS1 lines",
    ),
    "km_binary": Format(
        KmBinaryDecoder,
        {
            "KMB": (
                *(*_ATTITUDE, "heave", "roll_rate", "pitch_rate", "yaw_rate", "heave_rate", "heave_acceleration"),
                *("roll_sigma", "pitch_sigma", "heading_sigma", "heave_sigma", "delayed_heave", "ellipsoid_height"),
                *("north_velocity", "east_velocity", "north_sigma", "east_sigma", "height_sigma"),
                *("north_acceleration", "east_acceleration"),
            )
        },
        "Kongsberg KM Binary (#KMB)",
        is_text=False,
    ),
    "em3000": Format(
        EmAttitudeDecoder, {"EM3000": (*_ATTITUDE, "heave")}, "Kongsberg EM Attitude 3000, and 1000", is_text=False
    ),
}
"""Decoders by the name of their format; lines by a pattern of the map's own are `line`."""
LINE = "line"
