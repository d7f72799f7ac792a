"""The part of a record that is taken: within a window, between gaps too long to be bridged."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from heave_bags.errors import BagError
from heave_bags.signals import Signal

from heave_devices.records.ship_time import EARLIEST_UNIX, time_words, unix_time

DEFAULT_BRIDGE, LONGEST_BRIDGE = 2.0, 10.0
"""Longest time without a sample that is interpolated over: unless it is said, and at most [s]."""
_GAP = 2.5
"""A time between samples is a gap from so many usual ones on."""


@dataclass(frozen=True)
class Window:
    """What of a record is wanted.

    Raises BagError for a bridge that is not above 0, or above LONGEST_BRIDGE.
    """

    start: str = ""  # seconds from the start of the record, or a time in ISO 8601; "": its own start
    end: str = ""  # seconds from the start of the record, or a time in ISO 8601; "": its own end
    bridge: float = DEFAULT_BRIDGE  # longest gap that is interpolated over [s]

    def __post_init__(self) -> None:
        """Check the longest gap."""
        if not 0.0 < self.bridge <= LONGEST_BRIDGE:
            raise BagError(f"--bridge {self.bridge:g}: must be above 0 and at most {LONGEST_BRIDGE:g} s")


def longest_stretch(signals: Mapping[str, Signal], window: Window, notes: list[str]) -> tuple[float, float]:
    """Return start and end of the longest time in a `window` in which all `signals`, by name, are there [s].

    What is said of gaps goes into the `notes`. Raises BagError for a window that the record does not reach, or a time
    that is none.
    """
    first = max(signal.time[0] for signal in signals.values())
    last = min(signal.time[-1] for signal in signals.values())
    start = max(first, _moment(window.start, "--from", first)) if window.start else first
    end = min(last, _moment(window.end, "--to", first)) if window.end else last
    if not start < end:
        raise BagError(f"the record is from {time_words(first)} to {time_words(last)}: nothing of it is in the window")
    gaps = [gap for name, signal in signals.items() for gap in _gaps(name, signal, start, end, window.bridge, notes)]
    if not gaps:
        return start, end
    stretches = _between(gaps, start, end)
    chosen = max(stretches, key=lambda stretch: stretch[1] - stretch[0])
    taken = chosen[1] - chosen[0]
    notes.append(
        f"{len(gaps)} gap{'s' if len(gaps) > 1 else ''} of more than {window.bridge:g} s, the longest "
        f"{max(stop - begin for begin, stop in gaps):.1f} s: of {len(stretches)} stretches the longest is taken, "
        f"{taken:.1f} s from {time_words(chosen[0])}; {end - start - taken:.1f} s left out"
    )
    return chosen


def _moment(text: str, option: str, first: float) -> float:
    try:
        return first + float(text)
    except ValueError:
        time = unix_time(text)
    if math.isnan(time):
        raise BagError(f"{option} {text}: must be seconds from the start, or a time as in 2025-03-01T12:00:00Z")
    if first < EARLIEST_UNIX:
        raise BagError(f"{option} {text}: the record has no date, its time begins at {first:g} s: give seconds")
    return time


def _gaps(
    name: str, signal: Signal, start: float, end: float, bridge: float, notes: list[str]
) -> list[tuple[float, float]]:
    """Return the gaps of a signal that are too long; what is bridged goes into the notes."""
    inside = signal.time[(signal.time >= start) & (signal.time <= end)]
    if inside.size < 2:
        return [(start, end)]
    edges = np.concatenate(([start], inside, [end]))
    steps = np.diff(edges)
    long = np.flatnonzero(steps > bridge)
    bridged = steps[(steps > _GAP * float(np.median(np.diff(inside)))) & (steps <= bridge)]
    if bridged.size == 1:
        notes.append(f"{name}: one gap of {bridged[0]:.2f} s bridged")
    elif bridged.size:
        notes.append(
            f"{name}: {bridged.size} gaps of up to {bridged.max():.2f} s bridged, {bridged.sum():.1f} s together"
        )
    return [(float(edges[at]), float(edges[at + 1])) for at in long]


def _between(gaps: list[tuple[float, float]], start: float, end: float) -> list[tuple[float, float]]:
    """Return the times between gaps, which may overlap."""
    stretches = []
    for gap_start, gap_end in sorted(gaps):
        if gap_start > start:
            stretches.append((start, gap_start))
        start = max(start, gap_end)
    return [*stretches, (start, end)]
