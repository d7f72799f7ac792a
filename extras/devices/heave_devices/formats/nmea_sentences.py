"""The sentences of motion sensors that look like NMEA 0183: what each field is, in which unit and with which sign.

Sources of fields, units and signs:

- PSXN: Kongsberg Seatex, Seapath 200 Installation Manual rev. 13, and Seapath 320 M300-62 rev. 2: roll positive port
  side up, pitch positive bow up, heave and vertical velocity positive down; quality 0 normal, 1 reduced, 2 invalid.
- PASHR: Applanix POS MV V5 PUBS-MAN-004291 table 20, NovAtel OEM7 log 1177, SBG Systems sbgECom NMEA: roll positive
  port side up, pitch positive bow up. The sign of heave is not the same everywhere: SBG says positive down, its variant
  for WASSP positive up, the others say nothing. So heave is given as it is sent, and a map must say which way is
  positive.
- PHOCT: iXblue OCTANS "TAH", as SBG Systems documents it in sbgECom NMEA (08): roll positive port side up, pitch
  positive bow down, heave and heave speed positive up; status T valid, E invalid, I initialising.
- PNORSUB, PNORSUB2: Norwegian Subsea MRU, API documentation "NORSUB" and "NORSUB2": z down, so heave and heave velocity
  positive down, roll positive port side up, pitch positive bow up; bit 0 of the status: OK; T1 in milliseconds.
- PENCR: SMC IMU-108 User Guide rev. 3.1, section 4.10.7: up to five encoders of a crane as hexadecimal numbers, a turn
  is 65536, an extension is in centimetres; sent without a checksum. The first is the rotation of the base, the others
  knuckles or telescopes in their order. It says neither which way is positive nor what is zero: a map must say it.
- ZDA: NMEA 0183, UTC and date.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from datetime import datetime, timezone
from functools import partial

from heave_node.interface.codes import MruStatus

from heave_devices.formats.sample import Sample, TimeBase, number, sample_without, time_of_day

Fields = Sequence[str]
_DEGREE = math.radians(1.0)
_MOTION = ("heave", "surge", "sway", "heave_rate", "surge_rate", "sway_rate")


class Quality:
    """What PSXN,20 has said last of the sentences that follow: quantities that are invalid."""

    def __init__(self) -> None:
        self.invalid: frozenset[str] = frozenset()


def _given(fields: Fields, table: Mapping[int, tuple[str, float]]) -> dict[str, float]:
    """Return the quantities of those fields that are not empty, each in its unit and sign by a factor."""
    return {
        name: factor * number(fields[index])
        for index, (name, factor) in table.items()
        if index < len(fields) and fields[index] != ""
    }


_PSXN = {
    "PSXN22": {1: ("gyro_calibration", _DEGREE), 2: ("gyro_offset", _DEGREE)},
    "PSXN23": {1: ("roll", _DEGREE), 2: ("pitch", -_DEGREE), 3: ("heading", _DEGREE), 4: ("heave", -1.0)},
    "PSXN24": {
        1: ("roll_rate", _DEGREE),
        2: ("pitch_rate", -_DEGREE),
        3: ("yaw_rate", -_DEGREE),
        4: ("heave_rate", -1.0),
    },
}


def _psxn(fields: Fields, quality: Quality) -> Sample | None:
    kind = f"PSXN{int(fields[0])}"
    if kind == "PSXN20":
        heights, turns = int(fields[2]), int(fields[4])
        names: tuple[str, ...] = ("heave", "heave_rate") if heights >= 2 else ()
        names += ("roll", "pitch", "roll_rate", "pitch_rate") if turns >= 2 else ()
        quality.invalid = frozenset(names)
        return Sample(kind, {"height_quality": float(heights), "attitude_quality": float(turns)})
    if kind not in _PSXN:
        return None
    return sample_without(kind, _given(fields, _PSXN[kind]), quality.invalid)


_PASHR = {
    1: ("heading", _DEGREE),
    3: ("roll", _DEGREE),
    4: ("pitch", -_DEGREE),
    5: ("heave", 1.0),
    **{index: (f"{name}_sigma", _DEGREE) for index, name in enumerate(("roll", "pitch", "heading"), 6)},
    9: ("aiding_status", 1.0),
    10: ("imu_status", 1.0),
}


def _pashr(fields: Fields, _: Quality) -> Sample | None:
    if len(fields) < 9 or fields[2] != "T":
        return None  # PASHR,ATT and others of the same name
    time = time_of_day(fields[0]) if fields[0] else None
    return Sample("PASHR", _given(fields, _PASHR), time=time, time_base=TimeBase.DAY if fields[0] else TimeBase.NONE)


_PHOCT = {
    4: ("heading", _DEGREE),
    6: ("roll", _DEGREE),
    8: ("pitch", _DEGREE),
    10: ("heave_primary", 1.0),
    **{index: (name, 1.0) for index, name in enumerate(_MOTION, 12)},
    18: ("yaw_rate", -_DEGREE / 60.0),
}


def _phoct(fields: Fields, _: Quality) -> Sample:
    states = {5: ("heading", "yaw_rate"), 7: ("roll",), 9: ("pitch",), 11: ("heave_primary", *_MOTION)}
    bad = frozenset(name for index, names in states.items() if fields[index] != "T" for name in names)
    is_settling = fields[11] == "I"
    has_time = fields[2] == "T"
    return sample_without(
        "PHOCT",
        _given(fields, _PHOCT),
        bad,
        status=MruStatus.SETTLING if is_settling else MruStatus.OK,
        time=time_of_day(fields[1]) if has_time else None,
        time_base=TimeBase.DAY if has_time else TimeBase.NONE,
    )


_PNORSUB = {2: ("roll", _DEGREE), 3: ("pitch", -_DEGREE), 4: ("heading", _DEGREE), 5: ("heave", -1.0)}


_PNORSUB2 = {**_PNORSUB, 6: ("heave_rate", -1.0)}


def _pnorsub(fields: Fields, _: Quality, *, kind: str, table: Mapping[int, tuple[str, float]], status: int) -> Sample:
    values = _given(fields, table)
    bad = frozenset() if int(fields[status]) & 1 else frozenset(values)
    return sample_without(kind, values, bad, time=int(fields[0]) * 1e-3, time_base=TimeBase.COUNTER)


def _pencr(fields: Fields, _: Quality) -> Sample:
    values: dict[str, float] = {}
    for index, text in enumerate(fields[:5], 1):
        count = int(text, 16)
        if not 0 <= count < 65536 or not text.isalnum():
            raise ValueError(f"{text[:20]!r} is no encoder's count")
        values[f"angle_{index}"] = math.remainder(count * 2.0 * math.pi / 65536.0, 2.0 * math.pi)
        values[f"extension_{index}"] = 0.01 * count
    return Sample("PENCR", values)


def _zda(fields: Fields, _: Quality) -> Sample:
    midnight = datetime(int(fields[3]), int(fields[2]), int(fields[1]), tzinfo=timezone.utc).timestamp()
    return Sample("ZDA", {}, time=midnight + time_of_day(fields[0]), time_base=TimeBase.UNIX)


SENTENCES: Mapping[str, Callable[[Fields, Quality], Sample | None]] = {
    "PSXN": _psxn,
    "PASHR": _pashr,
    "PHOCT": _phoct,
    "PNORSUB": partial(_pnorsub, kind="PNORSUB", table=_PNORSUB, status=6),
    "PNORSUB2": partial(_pnorsub, kind="PNORSUB2", table=_PNORSUB2, status=7),
    "PENCR": _pencr,
    "ZDA": _zda,
}
"""Decoder of each sentence, by name without `$`. None, or an exception: the sentence is unknown, or malformed."""
_TABLES = {**_PSXN, "PASHR": _PASHR, "PHOCT": _PHOCT, "PNORSUB": _PNORSUB, "PNORSUB2": _PNORSUB2}
FIELDS: Mapping[str, tuple[str, ...]] = {
    "PSXN20": ("height_quality", "attitude_quality"),
    **{kind: tuple(name for name, _ in table.values()) for kind, table in _TABLES.items()},
    "PENCR": tuple(f"{name}_{index}" for index in range(1, 6) for name in ("angle", "extension")),
    "ZDA": (),
}
"""Fields of each sentence, by its name."""
WITHOUT_CHECKSUM = frozenset(["PENCR"])
"""Sentences that their makers send without a checksum."""
UNSIGNED = {
    "PASHR.heave": "makers of PASHR do not agree on the sign of heave (SBG: positive down; WASSP: positive up)",
    **{
        f"PENCR.angle_{number}": "the document of PENCR leaves the sign and the zero of an encoder to the crane"
        for number in range(1, 6)
    },
}
"""Fields whose sign a map must say, and why."""
