"""How much of the time that a step is judged over was recorded: over a record that lacks part of it nothing is met."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from heave_bags.analyse.time_base import LONGEST_GAP
from heave_bags.signals import Signal
from heave_devices.records.stretches import DEFAULT_BRIDGE

Span = tuple[float, float]
"""Start and end [s]."""


def lacking_words(signals: Iterable[Signal], window: Span, excused: Iterable[tuple[Signal, Span]] = ()) -> str:
    """Return in words that a record lacks part of a window; "" where it has all of it.

    Within the window gaps up to DEFAULT_BRIDGE count as recorded, as `heave import` has it. At its ends a signal may
    lack LONGEST_GAP of its periods, as in tables.

    Parameters
    ----------
    signals : each of which must be there
    window : that is judged
    excused : further signals, each with the time of an event that may silence it
    """
    start, end = window
    if not end > start:
        return f"nothing to judge from {start:g} s to {end:g} s"
    gaps = [gap for signal in signals for gap in _gaps(signal, window)]
    gaps += [
        gap for signal, event in excused for gap in _gaps(signal, window) if gap[1] < event[0] or gap[0] > event[1]
    ]
    missing, known = 0.0, start
    for first, last in sorted(gaps):
        missing += max(last - max(first, known), 0.0)
        known = max(known, last)
    if not missing:
        return ""
    return f"{math.floor(10.0 * (end - start - missing)) / 10.0:g} s of {end - start:g} s recorded"


def _gaps(signal: Signal, window: Span) -> list[Span]:
    """Return the gaps of a signal within a window that nothing bridges."""
    inside = signal.window(*window).time
    edges = np.concatenate((window[:1], inside, window[1:]))
    bridged = np.full(edges.size - 1, DEFAULT_BRIDGE)
    period = float(np.median(np.diff(inside))) if inside.size > 1 else 0.0
    bridged[[0, -1]] = min(LONGEST_GAP * period, DEFAULT_BRIDGE)
    return [(float(edges[at]), float(edges[at + 1])) for at in np.flatnonzero(np.diff(edges) > bridged)]
