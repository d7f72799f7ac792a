"""`heave adapt MAP --wiggle MM`: a move of millimetres shows whether units and signs of a winch's map are right.

It goes out, rests, and comes back.

The speed of a move of length d in a time T is (d / T) (1 - cos(2 pi t / T)): it begins and ends at rest, and its
largest value is 2 d / T. What is compared are places of the drum at rest, so that lag and dead time do not count.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

from heave_bringup.errors import CommandError
from heave_node.parameters import ParameterError

from heave_devices.adapt.device import LiveDevice
from heave_devices.adapt.report import clock_words
from heave_devices.bench.real_winch import RealPart, is_winch, words_of
from heave_devices.bench.winch import PERIOD, RELEASE, Sample, release
from heave_devices.maps.device_map import DeviceMap

MOVE_TIME = 4.0
"""Duration of a move one way [s]."""
REST_TIME = 2.0
"""Duration of a rest before, between and after the moves, in which the drum comes to rest [s]."""
_LOOK = 0.5
"""Last part of a rest, which is evaluated [s]."""
LEAST, LARGEST = 1e-3, 0.1
"""Lengths of a move [m]."""
_SHARE = 0.2
"""A place or speed within this share of the commanded one is right: gain, play and rounding of a drive at rest."""
DURATION = 2.0 * MOVE_TIME + 3.0 * REST_TIME


class Verdict(NamedTuple):
    """One line of the result."""

    what: str  # what was looked at
    is_good: bool  # whether it is right
    words: str  # what was found
    is_tried: bool = True  # False: it could not be looked at


def move_at(time: float, distance: float) -> tuple[float, float]:
    """Return payout from the start [m] and its rate [m/s] that are commanded a `time` [s] after it.

    The move goes a `distance` [m], positive out.
    """
    since = time - REST_TIME
    if since <= 0.0:
        return 0.0, 0.0
    if since <= MOVE_TIME:
        return _moved(since, distance)
    back = since - MOVE_TIME - REST_TIME
    if back <= 0.0:
        return distance, 0.0
    moved, rate = _moved(min(back, MOVE_TIME), distance)
    return distance - moved, -rate


def _moved(time: float, distance: float) -> tuple[float, float]:
    phase = 2.0 * math.pi * time / MOVE_TIME
    rate = distance / MOVE_TIME * (1.0 - math.cos(phase))
    return distance * (time / MOVE_TIME - math.sin(phase) / (2.0 * math.pi)), rate


def is_too_far(payout: float, start: float, distance: float) -> bool:
    """Return whether a drum at `payout` is too far from its `start` for a move of a `distance` [m]: a scale error."""
    return abs(payout - start) > 3.0 * distance + 0.005


def judge(readings: Sequence[Sample], distance: float) -> list[Verdict]:
    """Return what the `readings` of a whole wiggle of a `distance` [m] show, with times since it began."""
    first = _place(readings, REST_TIME)
    middle = _place(readings, 2.0 * REST_TIME + MOVE_TIME)
    last = _place(readings, DURATION)
    if not all(map(math.isfinite, (first, middle, last))):
        return [Verdict("payout", False, "the winch did not say where it is in each rest: check the link")]
    out, back = middle - first, last - middle
    turning = [found for found in readings if REST_TIME < found.time <= 2.0 * REST_TIME + MOVE_TIME]
    rates = [found for found in turning if math.isfinite(found.rate)]
    by_rate = sum(0.5 * (a.rate + b.rate) * (b.time - a.time) for a, b in pairwise(rates))
    has_turned = abs(by_rate / distance - 1.0) <= _SHARE
    moves = (("payout, out", out, distance), ("payout, back", back, -distance))
    verdicts = [_compare(*move, has_turned=has_turned) for move in moves]
    if len(rates) > 1:
        verdicts.append(_compare("payout rate, out", by_rate, out if verdicts[0].is_good else distance))
    return verdicts


def other_verdicts(trips: Sequence[str], wrong: Mapping[str, str], *, was_tripped: bool) -> list[Verdict]:
    """Return what a wiggle shows beside the move: what is `wrong`, "": nothing; `trips`, tried if it `was_tripped`."""
    trip = "the drive had tripped, and was reset" if was_tripped else "the drive had not tripped. Trip it, and repeat"
    look = "the drum must have paid out first, then hauled in: look. If not, both signs are reversed"
    seen = [Verdict(name, not words, words or "as the map says") for name, words in wrong.items()]
    return [
        *seen,
        Verdict("direction", True, look, is_tried=False),
        *(Verdict(n, True, trip, was_tripped) for n in trips),
    ]


def _place(readings: Sequence[Sample], end: float) -> float:
    found = [reading.payout for reading in readings if end - _LOOK <= reading.time <= end]
    return statistics.fmean(found) if found else math.nan


def _compare(what: str, found: float, wanted: float, *, has_turned: bool = False) -> Verdict:
    words = f"{1e3 * wanted:+.1f} mm expected, {1e3 * found:+.1f} mm read"
    ratio = found / wanted
    if abs(ratio - 1.0) <= _SHARE:
        return Verdict(what, True, words)
    if has_turned:
        return Verdict(what, False, f"{words}, while the speed is as ordered. Check unit, scale and sign of payout")
    if abs(ratio + 1.0) <= _SHARE:
        return Verdict(what, False, f"{words}: reversed. Check positive, in the quantity and in the command")
    if abs(ratio) < _SHARE:
        return Verdict(what, False, f"{words}: it hardly moved. Check enable, unit and scale of the command")
    return Verdict(what, False, f"{words}: {ratio:.3g} times. Check unit and scale, in the quantity and in the command")


def check_wiggle(maps: Sequence[DeviceMap], distance: float) -> None:
    """Raise ParameterError where `maps` are not one winch, or the `distance` [m] is none of a wiggle."""
    if len(maps) != 1 or not is_winch(maps[0]):
        raise ParameterError("--wiggle: name the map of one winch, with payout and command")
    if not LEAST <= distance <= LARGEST:
        raise ParameterError(f"--wiggle {1e3 * distance:g}: must be from {1e3 * LEAST:g} to {1e3 * LARGEST:g} mm")


def wiggle(device: LiveDevice, spin: Callable[[float], None], distance: float) -> list[Verdict]:
    """Move a live winch, `device`, by a `distance` [m] and back; return what was found. At the end it is braked.

    `spin` serves the topics of ROS for a time [s]. Raises CommandError where it does not speak, keeps its brake on, or
    runs away.
    """
    part = RealPart(device, spin, lambda _: None)
    was_tripped = bool(device.adapter.newest.get("fault", 0.0))
    channels, command = device.device.channels, device.device.command
    is_braked = _brake(part)
    try:
        readings = _move(device, part, distance)
    finally:
        is_braked = _brake(part) and is_braked
    orders = [order.quantity for order in command.orders] if command is not None else []
    trips = [name for name, known in (("fault", channels), ("reset", orders)) if name in known]
    wrong = {"device_time": clock_words(device)} if "device_time" in channels else {}
    if "brake" in channels:
        wrong["brake"] = "" if is_braked else f"{channels['brake'].field} must read engaged before and after the move"
    return judge(readings, distance) + other_verdicts(trips, wrong, was_tripped=was_tripped)


def _brake(part: RealPart) -> bool:
    """Order the brake of a winch, `part`; return whether it reads engaged within the time that one has."""
    return any(part.step(0.0, 0.0, brake=True).brake for _ in range(round(RELEASE[1] / PERIOD)))


def _move(device: LiveDevice, part: RealPart, distance: float) -> list[Sample]:
    name = device.device.name
    try:
        sample = start = release(part, name)
    except CommandError:
        raise CommandError(f"{name}: {words_of(device, 'its brake stays on')}") from None
    taker = device.adapter.taker
    readings, sent = [], taker.sent("payout")
    while (elapsed := sample.time - start.time) < DURATION:
        readings.append(sample._replace(time=elapsed))
        moved, rate = move_at(elapsed, distance)
        sample = part.step(start.payout + moved, rate, brake=False)
        if sample.brake or sample.fault:
            raise CommandError(f"{name}: stopped by itself: {words_of(device)}")
        if is_too_far(sample.payout, start.payout, distance):
            moved = sample.payout - start.payout
            hint = taker.jump_in_other_order("payout", moved, sent) or "Check unit and scale" + (
                ", kind and word_order" * device.device.is_polled + ", in the quantity and in the command"
            )
            raise CommandError(f"{name}: braked: {1e3 * moved:+.1f} mm read, {1e3 * distance:.1f} mm wanted. {hint}")
    return readings
