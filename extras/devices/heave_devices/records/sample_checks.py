"""Samples of a ship's record that say nothing of its motion: invalid ones, fill values, a sensor that stands still."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from heave_bags.signals import Signal
from heave_node.files.plausible import PLAUSIBLE, question
from heave_node.numerics.arrays import Array
from numpy.typing import NDArray

from heave_devices.formats.number_kinds import is_fill
from heave_devices.records.ship_time import time_words
from heave_devices.records.stretches import LONGEST_BRIDGE

_FAR = 3.0
"""A fill value is beyond what is plausible by this factor at least; what is nearer is another unit."""
_FAR_FROM_MOST = 10.0
"""A value that stands for none is so many times further from the median than most are."""
_FILL_VALUES = 2
"""A record uses so many fill values at most."""


@dataclass
class Findings:
    """What is said of a record, and what is asked."""

    accepts: bool = False  # implausible figures are taken as they are, and noted
    notes: list[str] = field(default_factory=list)  # what was found out, left out or bridged, one line each
    questions: list[str] = field(default_factory=list)  # implausible figures, one line each
    _invalid: dict[str, int] = field(default_factory=dict)

    def ask(self, question: str) -> None:
        """Add a question; "" is none."""
        if question:
            (self.notes if self.accepts else self.questions).append(question)

    def without_invalid(self, name: str, value: Array, good: NDArray[np.bool_], valid: str) -> Array:
        """Return samples `value` of the channel `name`, NaN where not `good`, as the column or field `valid` says."""
        bad = ~good & np.isfinite(value)
        if bad.any():
            self.notes.append(f"{name}: {int(bad.sum())} samples that {valid} calls invalid left out")
            self._invalid[name] = int(bad.sum())
        return np.where(good, value, np.nan)

    def taken_out(self, name: str) -> int:
        """Return how many samples of the channel `name` were called invalid."""
        return self._invalid.get(name, 0)


def without_fill(name: str, signal: Signal, quantity: str, findings: Findings) -> Signal:
    """Return a channel without values that stand for none; other values beyond the plausible are asked for.

    Parameters
    ----------
    name : of the channel
    signal : [m] or [rad]
    quantity : name in PLAUSIBLE; one that is not there has no range
    findings : takes what is said and asked
    """
    if quantity not in PLAUSIBLE or not signal.size:
        return signal
    limit = PLAUSIBLE[quantity].most
    about = signal.value - np.median(signal.value)
    beyond = np.abs(about) > limit
    fill = np.abs(about) > _FAR * limit
    values = np.unique(signal.value[fill])
    if beyond.any() and not (values.size <= _FILL_VALUES and (fill == beyond).all()):
        worst = int(np.argmax(np.abs(about)))
        findings.ask(question(quantity, float(abs(about[worst])), f"{name} at {time_words(signal.time[worst])}"))
        return signal
    return _without(name, signal, fill, findings) if fill.any() else signal


def without_marks(name: str, signal: Signal, findings: Findings) -> Signal:
    """Return a channel, in the unit of its record, without values that stand for none by custom, such as -9999.

    One is far from all others and comes at once. `name` is that of the channel, `signal` its samples; `findings` takes
    what is said.
    """
    if not signal.size:
        return signal
    about, value = np.abs(signal.value - np.median(signal.value)), signal.value
    far = np.unique(value[about > _FAR_FROM_MOST * np.quantile(about, 0.6)])
    steps = np.abs(np.diff(value, prepend=math.inf))
    marks = [one for one in far if _is_mark(one) and (steps > 0.5 * about)[(value == one) & (steps > 0.0)].all()]
    if not marks or findings.accepts:
        return signal
    return _without(name, signal, np.isin(signal.value, marks), findings)


def _without(name: str, signal: Signal, fill: NDArray[np.bool_], findings: Findings) -> Signal:
    """Return a channel without its samples that are a `fill`, which is said; with them where all is accepted."""
    words = " and ".join(f"{value:g}" for value in np.unique(signal.value[fill]))
    at = time_words(signal.time[int(np.argmax(fill))])
    found = f"{name}: {int(fill.sum())} samples of {words}, the first at {at}"
    findings.notes.append(f"{found}, {'are fill values?' if findings.accepts else 'taken as fill values'}")
    return signal if findings.accepts else Signal(signal.time[~fill], signal.value[~fill])


def _is_mark(value: float) -> bool:
    """Return whether a value stands for none by custom: nines alone, one of `is_fill`, or huge."""
    digits = f"{abs(value):.6g}".replace(".", "")
    return abs(value) >= 1e19 or is_fill(value) or (len(digits) > 1 and set(digits) == {"9"})


def without_standstill(name: str, signal: Signal, findings: Findings) -> Signal:
    """Return a channel without the times, longer than any gap that is bridged, in which its value does not change.

    A sensor or its line is then stuck, for no ship is. A channel that never changes is not measured, and stays. `name`
    is that of the channel, `signal` its samples; `findings` takes what is said.
    """
    if signal.size < 2 or not np.any(signal.value != signal.value[0]):
        return signal
    starts = np.concatenate(([0], np.flatnonzero(np.diff(signal.value) != 0.0) + 1))
    ends = np.append(starts[1:], signal.size) - 1
    lasted = signal.time[ends] - signal.time[starts]
    stuck = np.flatnonzero((lasted > LONGEST_BRIDGE) & (ends - starts >= 10))
    if not stuck.size:
        return signal
    longest = stuck[np.argmax(lasted[stuck])]
    times = f"{stuck.size} times, the longest " if stuck.size > 1 else ""
    text = (
        f"{name}: stands still at {signal.value[starts[longest]]:g} {times}for {lasted[longest]:.1f} s from "
        f"{time_words(signal.time[starts[longest]])}"
    )
    findings.notes.append(text if findings.accepts else f"{text}: taken as a gap")
    if findings.accepts:
        return signal
    kept = np.ones(signal.size, dtype=bool)
    for run in stuck:
        kept[starts[run] + 1 : ends[run] + 1] = False
    return Signal(signal.time[kept], signal.value[kept])
