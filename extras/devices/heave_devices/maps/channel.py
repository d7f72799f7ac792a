"""Where one quantity is found: one form for a live device, for a bag and for a log."""

from __future__ import annotations

import difflib
import math
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, fields, replace
from typing import Any

from heave_node.files.units import UNITS

from heave_devices.maps.quantities import QUANTITIES

EULER_PARTS = ("roll", "pitch", "yaw")
GOOD_WORDS = ("true", "valid", "ok", "good", "yes", "a", "y", "t")
"""Words that call a sample valid, in any case."""
DEFAULT_CUT_OFF = 2.0 * math.pi / 40.0
"""Motion slower than this is taken out when acceleration is integrated [rad/s]: no sea is slower."""


class MapError(ValueError):
    """An entry of a map that cannot be; the message says which, and what is allowed, without the file's name."""


@contextmanager
def placed(where: str) -> Iterator[None]:
    """Turn a ValueError into a MapError that opens with its place in the map, `where`; "" opens with nothing."""
    try:
        yield
    except ValueError as error:
        raise MapError(f"{where}: {error}" if where else str(error)) from None


@dataclass(frozen=True)
class Channel:
    """Where one quantity is found."""

    topic: str = ""  # of a bag or a live run, such as "/imu/data"
    # such as "linear_acceleration.z", a quaternion if `part` is given; without a topic, that of a sentence, such as
    # "PSXN23.heave", or of the pattern's own
    field: str = "data"
    type: str = ""  # of the topic's messages, for a live run
    column: str = ""  # of a CSV log
    part: str = ""  # "roll", "pitch" or "yaw" of a quaternion [rad]
    # of a vector's component, such as "twist.twist.linear.z", the quaternion of the same message that turns it into the
    # map's frame, such as "pose.pose.orientation"; "": it is in that frame; "none": the same, though the standard of
    # its type says otherwise (`with_standard_frame`)
    turned_by: str = ""
    unit: str = ""  # of the value, such as "deg" or "kN"; "": SI
    positive: str = ""  # which way is, such as "down" or "bow up"; "": as the suite has it
    # field of the same line that holds the sign as a letter, such as "side"; of a map `sign: {field: side, negative:
    # [P]}`
    sign_field: str = ""
    negative: tuple[str, ...] = ()  # words of that field that make the value negative, such as ("P",)
    scale: float = 1.0  # quantity = scale * value + offset, in SI units after `unit` and `positive`
    offset: float = 0.0  # see `scale`
    velocity: bool = False  # the value is a velocity [m/s]; it is integrated
    acceleration: bool = False  # the value is an acceleration [m/s^2]; of a record it is integrated twice
    # live, motion slower than this period is taken out [s], as of a height over the sea bed; 0: none
    high_pass: float = 0.0
    cut_off: float = DEFAULT_CUT_OFF  # what is slower is then taken out [rad/s]
    # field of the same topic or sentence, or column, that calls each sample valid by a number other than 0 or a word
    # such as `true`; what is not valid is a gap. "": of a log, a column named after this one with `_valid`, or `valid`
    valid: str = ""
    valid_values: tuple[float | str, ...] = ()  # `valid` must be one of these numbers or words instead
    invalid_bits: int = 0  # `valid` is a status instead, and a sample with one of these bits set is not valid
    # numbers, as sent, that stand for "not available", besides those of `number_kinds`
    invalid_values: tuple[float, ...] = ()
    sigma: float = math.nan  # accuracy that is stated with a live sample, one standard deviation, SI; NaN: none
    zero_at_start: bool = False  # the first usable live value counts as 0

    def signed(self, value: float, words: Mapping[str, str]) -> float:
        """Return a `value` with the sign that the `words` of its line, by field, give it; NaN without one."""
        if not self.sign_field:
            return value
        word = words.get(self.sign_field)
        return math.nan if word is None else -value if word in self.negative else value

    def factor(self, quantity: str) -> float:
        """Return what turns a number of this channel into a `quantity` in SI units and the suite's sign."""
        known = QUANTITIES[quantity]
        unit = UNITS[self.dimension(quantity)][self.unit] if self.unit else 1.0
        return self.scale * unit * (known.ways[self.positive] if self.positive else 1.0)

    def dimension(self, quantity: str) -> str:
        """Return the dimension of the value that becomes a `quantity`."""
        if self.acceleration:
            return "acceleration"
        return "speed" if self.velocity else QUANTITIES[quantity].dimension

    def is_valid(self, status: float | str) -> bool:
        """Return whether a `status`, a number or a word, calls a sample valid."""
        if self.valid_values:
            return status in self.valid_values
        if isinstance(status, str):
            return status.lower() in GOOD_WORDS
        if not math.isfinite(status):
            return False
        return not int(status) & self.invalid_bits if self.invalid_bits else status != 0.0


def read_channel(quantity: str, entry: Any, positive: str = "") -> Channel:
    """Return the channel of a `quantity` that an `entry` of a map describes, `positive` unless the entry says it.

    Raises MapError for what cannot be.
    """
    if isinstance(entry, str):
        entry = {"field": entry}
    if not isinstance(entry, dict):
        raise MapError(f"{quantity} must give topic and field, the field of a sentence, or column")
    known_names = [known.name for known in fields(Channel) if known.name not in ("sign_field", "negative")]
    refuse_unknown(quantity, entry, [*known_names, "sign"])
    values = {"positive": positive, **entry}
    if "sign" in values:
        values |= _sign_of(quantity, values.pop("sign"))
    if "valid_values" in values:
        listed = _listed(values["valid_values"])
        values["valid_values"] = tuple(float(v) if isinstance(v, int | float) else str(v) for v in listed)
    if "invalid_values" in values:
        listed = _listed(values["invalid_values"])
        values["invalid_values"] = tuple(as_kind(float, f"{quantity}: invalid_values", value) for value in listed)
    channel = Channel(**{**values, **plain_entries(Channel, f"{quantity}: ", values)})
    _check(quantity, channel)
    return with_standard_frame(channel, channel.type)


def with_standard_frame(channel: Channel, kind: str) -> Channel:
    """Return a `channel` of messages of a `kind`, in the frame that the standard of that type has for its field.

    The twist of nav_msgs/Odometry is in `child_frame_id`, the body, and its pose turns that into `frame_id`. What
    sbg_driver/SbgShipMotion has along z is positive down, with ENU set or not.
    """
    if kind == "sbg_driver/msg/SbgShipMotion" and channel.field.endswith(".z") and not channel.positive:
        return replace(channel, positive="down")
    if channel.turned_by or kind != "nav_msgs/msg/Odometry" or not channel.field.startswith("twist.twist.linear."):
        return channel
    return replace(channel, turned_by="pose.pose.orientation")


def _sign_of(quantity: str, entry: Any) -> dict[str, Any]:
    """Return the entries of a Channel that `sign` of a map makes."""
    where = f"{quantity}: sign"
    if not isinstance(entry, dict):
        raise MapError(f"{where} must give a field and its negative words: {{field: side, negative: [P]}}")
    refuse_unknown(where, entry, ("field", "negative"))
    listed = _listed(entry.get("negative", []))
    if not listed:
        raise MapError(f"{where}: negative must list the words that make the value negative, such as [P]")
    words = tuple(as_kind(str, f"{where}: negative", word) for word in listed)
    return {"sign_field": as_kind(str, f"{where}: field", entry.get("field", "")), "negative": words}


def _listed(given: Any) -> list[Any]:
    return given if isinstance(given, list) else [given]


def plain_entries(of: type[Any], where: str, entry: Mapping[str, Any]) -> dict[str, Any]:
    """Return those of an `entry` that are a word, a number or a flag of the dataclass `of`, each as its kind.

    Raises MapError, with the place in the map, `where`, for one that is none.
    """
    kinds = {"str": str, "float": float, "bool": bool, "int": int}
    known = {one.name: kinds[str(one.type)] for one in fields(of) if str(one.type) in kinds}
    return {name: as_kind(kind, f"{where}{name}", entry[name]) for name, kind in known.items() if name in entry}


def as_kind(kind: type, name: str, value: Any) -> Any:
    """Return a `value` of a `kind` (str, float, bool, int); raise MapError, with its `name`, where it is none."""
    if kind is float and isinstance(value, int) and not isinstance(value, bool):
        value = float(value)
    if (kind is int and isinstance(value, bool)) or not isinstance(value, kind):
        words = {str: "a word", float: "a number", bool: "true or false", int: "a whole number such as 6 or 0x8000"}
        raise MapError(f"{name} = {value!r} must be {words[kind]}")
    if isinstance(value, float) and not math.isfinite(value):
        raise MapError(f"{name} = {value} must be a finite number")
    return value


def _check(quantity: str, channel: Channel) -> None:
    """Raise MapError where the entries of a channel contradict each other."""
    known, dimension = QUANTITIES[quantity], channel.dimension(quantity)
    units, ways = (", ".join(filter(None, names)) or "none" for names in (UNITS[dimension], known.ways))
    name = "invalid_bits" if channel.invalid_bits else "valid_values"
    refuse(
        f"{quantity}: ",
        (channel.topic and channel.column, "needs either a topic or a column"),
        (
            channel.unit and channel.unit not in UNITS[dimension],
            f"{channel.unit} is no unit of {dimension}; known: {units}",
        ),
        (
            channel.positive and channel.positive not in known.ways,
            f"positive: {channel.positive!r} is unknown; known: {ways}",
        ),
        (
            channel.scale == 0.0 or abs(channel.scale) > 1e9 or abs(channel.offset) > known.largest,
            f"scale {channel.scale:g}, offset {channel.offset:g} cannot be: the largest {quantity} is "
            f"{known.largest:g} in SI units",
        ),
        outside("high_pass", channel.high_pass or 20.0, 20.0, 3600.0, " s"),
        (channel.velocity and channel.acceleration, "is either a velocity or an acceleration"),
        (channel.invalid_bits < 0, "invalid_bits must be a whole number such as 6 or 0x8000"),
        (
            (channel.invalid_bits or channel.valid_values) and not channel.valid,
            f"{name} needs valid: the column or field of the status",
        ),
        (channel.part and channel.part not in EULER_PARTS, f"part must be one of {', '.join(EULER_PARTS)}"),
        (
            channel.turned_by and (channel.column or channel.field[-2:] not in (".x", ".y", ".z")),
            "turned_by needs the field of a message that ends with .x, .y or .z",
        ),
    )


def refuse(where: str, *cases: tuple[object, str]) -> None:
    """Raise MapError for the first of `cases` that is so, each with its words, after its place in the map, `where`."""
    words = next((words for is_so, words in cases if is_so), "")
    if words:
        raise MapError(where + words)


def outside(name: str, value: float, least: float, most: float, unit: str = "") -> tuple[bool, str]:
    """Return whether the `value` called `name` is not from `least` to `most`, and the words for it, with its `unit`."""
    return not least <= value <= most, f"{name} = {value:g} must be from {least:g} to {most:g}{unit}"


def refuse_unknown(where: str, entry: Mapping[str, object], known: Collection[str]) -> None:
    """Raise MapError for a name in an `entry` that is not `known`, with its place, `where`, and the nearest that is."""
    for name in entry:
        if name not in known:
            near = difflib.get_close_matches(name, known, n=1)
            hint = f"did you mean {near[0]}?" if near else f"known: {', '.join(known)}"
            place = f"{where}: " if where else ""
            raise MapError(f"{place}unknown entry {name}; {hint}")
