"""From what a device says to quantities of the suite: by a map, checked, and counted where they are not used."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from heave_node.interface.codes import MruStatus
from heave_node.numerics.arrays import Array
from heave_node.numerics.high_pass import HighPass
from heave_node.numerics.kinematics import euler_part, turned

from heave_devices.formats.number_kinds import is_fill, size_of, with_words_swapped
from heave_devices.formats.sample import Sample
from heave_devices.maps.channel import Channel
from heave_devices.maps.device_map import DeviceMap, SampleField
from heave_devices.maps.field_path import FieldPath
from heave_devices.maps.quantities import QUANTITIES

_LEAST_FLOAT = 1e-25
"""A float below is no measurement, but the words of one in the wrong order."""
DEFAULT_PERIOD = 300.0
"""Period of the high-pass of a height or velocity, where a map says none [s]: a swell of 12 s leads by 3 degrees."""


@dataclass
class Taken:
    """Quantities of one sample or message."""

    time: float  # of the measurement, by one clock [s]
    values: dict[str, float] = field(default_factory=dict)  # by quantity, SI units, the suite's signs
    invalid: set[str] = field(default_factory=set)  # quantities of the map that the device calls invalid
    status: MruStatus = MruStatus.OK  # whether the motion has settled

    def has_any(self, names: Iterable[str]) -> bool:
        """Return whether it holds one of the quantities called `names`, or calls it invalid."""
        return any(name in self.values or name in self.invalid for name in names)


class Recent:
    """The newest value of each quantity of some `names` that samples give by and by; old after a `timeout` [s]."""

    def __init__(self, names: Sequence[str], timeout: float = math.inf) -> None:
        self._names, self._timeout = names, timeout
        self._newest: dict[str, tuple[float, float]] = {}

    def take(self, taken: Taken) -> dict[str, float]:
        """Return all of them after a sample, `taken`; NaN for one that has not come, is old, or was invalid since."""
        for name in self._names:
            if name in taken.values:
                self._newest[name] = (taken.time, taken.values[name])
            elif name in taken.invalid:
                self._newest.pop(name, None)
        newest = {name: self._newest.get(name, (-math.inf, math.nan)) for name in self._names}
        return {name: value if taken.time - at <= self._timeout else math.nan for name, (at, value) in newest.items()}


@dataclass
class TakeCounters:
    """What was not used, counted."""

    invalid: int = 0  # samples of which something is called invalid, by the device or for its size
    # values that stand for "not available" now, as sent, by quantity
    unavailable: dict[str, float] = field(default_factory=dict)
    implausible: dict[str, int] = field(default_factory=dict)  # values larger than the quantity can be, by quantity
    missing: dict[str, int] = field(default_factory=dict)  # fields that a message does not have, in words
    worst: str = ""  # in words, the last implausible value


class Taker:
    """Takes the quantities of a map, `device`, out of samples and messages.

    Attributes
    ----------
    counters : of what was not used
    zeros : values from which quantities count, SI units: the first one, and what a count has jumped by since
    """

    def __init__(self, device: DeviceMap) -> None:
        self.counters = TakeCounters()
        self._channels = dict(device.channels)
        self._fields = {name: SampleField(device, channel) for name, channel in device.channels.items()}
        self._kinds = {name: device.kind_of(channel.field) for name, channel in device.channels.items()}
        self._word_order = device.link.word_order if device.link is not None and device.link.kind == "modbus" else ""
        self._factors = {name: channel.factor(name) for name, channel in self._channels.items()}
        self._filters = {
            name: HighPass(channel.high_pass or DEFAULT_PERIOD)
            for name, channel in self._channels.items()
            if channel.high_pass or channel.velocity
        }
        self.zeros: dict[str, float] = {}
        self._starts: dict[str, float] = {}
        self._sent: dict[str, tuple[float, float]] = {}
        self._count = math.nan
        self._paths = {
            text: FieldPath(text)
            for channel in self._channels.values()
            if channel.topic
            for text in (channel.field, channel.valid, channel.turned_by, channel.field[:-2])
            if text and (text != channel.field[:-2] or channel.turned_by)
        }

    def of_sample(self, sample: Sample, time: float) -> Taken:
        """Return what the map wants of a `sample` of a line or frame, measured at a `time` [s]."""
        taken = Taken(time, status=sample.status)
        for name, where in self._fields.items():
            if not where.is_in(sample):
                continue
            if where.is_invalid(sample):
                taken.invalid.add(name)
            elif (raw := where.number(sample)) is not None:
                self._put(taken, name, raw)
        self.counters.invalid += bool(taken.invalid)
        return taken

    def of_message(self, topic: str, message: Any, time: float) -> Taken:
        """Return what the map wants of a `message` that came on a `topic`, measured at a `time` [s]."""
        taken = Taken(time)
        for name, channel in self._channels.items():
            if channel.topic != topic:
                continue
            try:
                if channel.valid and not channel.is_valid(self._paths[channel.valid].of(message)):
                    taken.invalid.add(name)
                    continue
                self._put(taken, name, self._number(channel, message))
            except LookupError as error:
                words = str(error.args[0])
                self.counters.missing[words] = self.counters.missing.get(words, 0) + 1
        self.counters.invalid += bool(taken.invalid)
        return taken

    def _number(self, channel: Channel, message: Any) -> float:
        path = self._paths[channel.field]
        if channel.part:
            return float(euler_part(channel.part, *self._quaternion(channel.field, message)))
        if channel.turned_by in ("", "none"):
            return path.number_of(message)
        holder = self._paths[channel.field[:-2]].of(message)
        vector = [np.array(getattr(holder, axis, math.nan), dtype=float) for axis in "xyz"]
        number = float(turned(vector, *self._quaternion(channel.turned_by, message))["xyz".index(channel.field[-1])])
        if not math.isfinite(number):
            raise LookupError(f"{channel.field} is {number:g}")
        return number

    def _quaternion(self, text: str, message: Any) -> Array:
        """Return the quaternion x, y, z, w of length 1 that a `message` holds at the path `text`."""
        turn = self._paths[text].of(message)
        try:
            numbers = np.array([float(getattr(turn, axis)) for axis in "xyzw"])
        except (AttributeError, TypeError, ValueError):
            raise LookupError(f"{text} is no quaternion") from None
        size = float(np.linalg.norm(numbers))
        if not 0.5 < size < 2.0:
            raise LookupError(f"{text} is a quaternion of length {size:g}")
        unit: Array = numbers / size
        return unit

    def _put(self, taken: Taken, name: str, raw: float) -> None:
        channel = self._channels[name]
        self._sent[name] = (self._sent.get(name, (raw, raw))[1], raw)
        if QUANTITIES[name].is_measured and (is_fill(raw, self._kinds[name]) or raw in channel.invalid_values):
            self.counters.unavailable[name] = raw
            taken.invalid.add(name)
            return
        value = self._factors[name] * self._counted_on(name, raw) + channel.offset
        filtered = self._filters.get(name)
        if filtered is None and self._is_implausible(name, raw, value):
            taken.invalid.add(name)
            return
        if channel.zero_at_start:
            value -= self.zeros.setdefault(name, value)
        if filtered is not None:
            value = (filtered.add_rate if channel.velocity else filtered.add)(taken.time, value)
            if not filtered.is_settled:
                taken.status = MruStatus.SETTLING
            if self._is_implausible(name, raw, value):
                taken.invalid.add(name)
                return
        self.counters.unavailable.pop(name, None)
        taken.values[name] = value

    def _counted_on(self, name: str, raw: float) -> float:
        """Return a count `raw` of a drum in a whole number that may have passed its end: the turn nearest to before."""
        kind = self._kinds[name]
        if name != "payout" or not kind or kind.startswith("float"):
            return raw
        turn = 2.0 ** (8 * size_of(kind))
        self._count = raw + turn * round((self._count - raw) / turn) if math.isfinite(self._count) else raw
        return self._count

    def _is_implausible(self, name: str, raw: float, value: float) -> bool:
        """Return whether a `value`, sent as `raw`, cannot be one of a quantity; it is then counted and put in words."""
        largest = QUANTITIES[name].largest
        is_tiny = 0.0 < abs(raw) < _LEAST_FLOAT and QUANTITIES[name].is_measured
        start = self.zeros.get(name, self._starts.get(name, math.inf))
        if min(abs(value), abs(value - start)) <= largest and not is_tiny:
            return False
        in_other_order = self._other_order(name, raw)
        if self._channels[name].zero_at_start and name not in self.zeros and not in_other_order:
            was_one, self._starts[name] = name in self._starts, value
            if not was_one:  # a counter may begin anywhere: the next one says whether this is one
                return True
        self.counters.implausible[name] = self.counters.implausible.get(name, 0) + 1
        what = "no instrument reads it" if is_tiny else f"at most {largest:g} can be"
        hint = in_other_order or "check unit, scale and column of the map"
        self.counters.worst = f"{name} = {value:.4g}, {what}: {hint}"
        return True

    def _other_order(self, name: str, raw: float) -> str:
        """Return in words what a register of several words, sent as `raw`, reads in the other order; "": nothing."""
        order, other = self._swapped(name, raw)
        value = self._factors[name] * other + self._channels[name].offset
        if not abs(value) <= QUANTITIES[name].largest or 0.0 < abs(other) < _LEAST_FLOAT:
            return ""
        return f"with word_order: {order} it reads {value:.2f}"

    def sent(self, name: str) -> float:
        """Return what a quantity, `name`, was last sent as; NaN: it has not come."""
        return self._sent.get(name, (math.nan, math.nan))[1]

    def jump_in_other_order(self, name: str, jump: float, since: float | None = None) -> str:
        """Return in words that a `jump` of a quantity, `name`, is a small step in the other order, or "".

        It is that of the last reading, or of all since one that was sent as `since`.
        """
        order, before = self._swapped(name, self._sent[name][0] if since is None else since)
        moved = self._factors[name] * (self._swapped(name, self.sent(name))[1] - before)
        return f"with word_order: {order} it moved by {moved:+.4f} m" if abs(moved) < 0.1 * abs(jump) else ""

    def _swapped(self, name: str, raw: float) -> tuple[str, float]:
        """Return the other order of words, and what a number of several of them that was sent as `raw` reads in it.

        NaN: it has one word, none that is known, or stands for none.
        """
        kind = self._kinds[name]
        if not self._word_order or not kind or size_of(kind) < 4 or not math.isfinite(raw):
            return "", math.nan
        own = self._channels[name].field.rpartition(":")[2]
        order = own if own in ("big", "little") else self._word_order
        try:
            other = with_words_swapped(kind, raw)
        except ValueError:  # a number that its kind does not hold
            return "", math.nan
        return ("big" if order == "little" else "little"), (math.nan if is_fill(other, kind) else other)
