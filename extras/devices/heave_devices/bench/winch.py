"""A winch by itself, virtual or real, ordered to follow a set signal; and what it did, sample by sample."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np
from cable_sim_node.winch.command_line import WinchCommand
from cable_sim_node.winch.component import VirtualWinch
from cable_sim_node.winch.parameters import WinchParameters
from heave_bringup.errors import CommandError
from heave_node.numerics.arrays import Array

from heave_devices.bench.set_signal import BRAKE, COMMAND_LOSS, Event, WinchTest

PERIOD = 0.05
"""Time from one order to the next [s]."""
AFTER = 2.0
"""Time for which a winch is watched after its set signal has ended [s]."""
RELEASE = (1.0, 4.0)
"""Time for which the brake is requested before it may open, and within which it must be open then [s]."""
WATCHED = 5.0
"""Time for which a winch is watched after an event [s]."""
LONGEST_WAIT = 60.0
"""Time that a person has for what he is asked to do [s]."""


class Sample(NamedTuple):
    """What a winch reports: its time [s], payout [m] and rate [m/s] of the encoder, brake and fault (0: none).

    A winch that has fallen silent reports nothing any more: `silence` is for how long [s], 0 while it does.
    """

    time: float
    payout: float
    rate: float
    brake: float
    fault: float
    silence: float = 0.0


class WinchPart(Protocol):
    """A winch under test."""

    is_real: bool

    def step(self, payout: float, rate: float, *, brake: bool) -> Sample:
        """Order payout [m] and rate [m/s], or the brake; return what it reports a period later."""
        ...

    def idle(self) -> Sample:
        """Send nothing; return what it reports a period later."""
        ...

    def strike(self, event: Event) -> None:
        """Do to it what an event of a procedure says, from now on."""
        ...


class VirtualPart:
    """The suite's virtual winch by its `parameters` in simulated time, with a `load`, the tension at the drum [N]."""

    is_real = False

    def __init__(self, parameters: WinchParameters, load: float) -> None:
        self._winch = VirtualWinch(parameters, tick_period=PERIOD)
        self._load = load

    def step(self, payout: float, rate: float, *, brake: bool) -> Sample:
        """See `WinchPart.step`."""
        tick = self._winch.tick
        return self._advance(WinchCommand(tick + 1, payout, rate, brake))

    def idle(self) -> Sample:
        """See `WinchPart.idle`."""
        return self._advance(None)

    def strike(self, event: Event) -> None:
        """See `WinchPart.strike`."""
        now = self._winch.tick * PERIOD
        self._winch.faults.inject(event.fault, start=now, duration=event.duration, magnitude=event.magnitude)

    def _advance(self, command: WinchCommand | None) -> Sample:
        state = self._winch.step(self._winch.tick, command, self._load)
        return Sample(state.time, state.encoder_payout, state.encoder_payout_rate, float(state.brake), int(state.fault))


@dataclass
class Trace:
    """What a test of a winch left, with times from the first order on."""

    rows: Array  # time, ordered rate, payout, rate, brake, fault; shape (n, 6), SI units
    event: float = math.nan  # time of the event [s]; NaN: there was none
    silent: float = math.nan  # time of the last report of a winch that fell silent [s]; NaN: it did not

    HEADER = ("time_s", "ordered_rate_mps", "payout_m", "payout_rate_mps", "brake", "fault")

    def save(self, path: Path) -> None:
        """Write it to the CSV file `path`."""
        np.savetxt(path, self.rows, fmt="%.6g", delimiter=",", header=",".join(self.HEADER), comments="")


def release(part: WinchPart, name: str) -> Sample:
    """Take a winch, `part`, from whatever it is in to where it follows; return what it reports.

    Raises CommandError, with the `name` of the step, where its brake stays on.
    """
    sample = part.step(0.0, 0.0, brake=True)
    for _ in range(round(RELEASE[0] / PERIOD)):
        sample = part.step(sample.payout, 0.0, brake=True)
    for _ in range(round(RELEASE[1] / PERIOD)):
        sample = part.step(sample.payout, 0.0, brake=False)
        if not sample.brake and not sample.fault:
            return sample
    if sample.silence:
        raise CommandError(f"{name}: the winch has fallen silent, {sample.silence:.1f} s ago")
    raise CommandError(f"{name}: the winch's brake stays on, or a fault is latched (fault {sample.fault:g})")


def run_winch(
    part: WinchPart, test: WinchTest, event: Event | None, name: str, show: Callable[[str, float], None]
) -> Trace:
    """Run a `test` of a winch, `part`, with an `event`; its brake is requested at the end, whatever comes.

    `name` is that of the step; `show` is called with words and the share that is done.
    Raises CommandError where it cannot be released.
    """
    origin = part.step(0.0, 0.0, brake=True) if test.signal.is_braked else release(part, name)
    try:
        return _follow(part, test, event, origin, lambda share: show(f"{name}: {test.signal.words}", share))
    finally:
        for _ in range(round(AFTER / PERIOD)):
            part.step(origin.payout, 0.0, brake=True)


class _Event:
    """An event on its way: announced when it is due, begun at once, or where a person does it when the winch stops."""

    def __init__(self, event: Event | None, part: WinchPart) -> None:
        self._event, self._part = event, part
        self._is_own = event is not None and event.fault in (COMMAND_LOSS, BRAKE)
        self._is_due = False
        self.begun = math.nan

    def look(self, now: float, sample: Sample) -> None:
        """Do what is due at `now` [s], when the winch reports a `sample`."""
        event = self._event
        if event is None or math.isfinite(self.begun) or now < event.at - 1e-9:
            return
        if not self._is_due and not self._is_own:
            self._part.strike(event)
        is_asked = self._part.is_real and not self._is_own
        if not is_asked or (self._is_due and sample.fault):
            self.begun = now
        self._is_due = True

    def is_over(self, now: float, duration: float) -> bool:
        """Return whether a test with a set signal of so long a `duration` [s] is over at `now` [s]."""
        if self._event is None:
            return now >= duration - 1e-9
        return now >= (
            self.begun + WATCHED if math.isfinite(self.begun) else max(duration, self._event.at + LONGEST_WAIT)
        )

    def does(self, fault: str) -> bool:
        """Return whether the test itself does an event of this `fault` now."""
        return self._event is not None and self._event.fault == fault and math.isfinite(self.begun)


def _follow(
    part: WinchPart, test: WinchTest, event: Event | None, origin: Sample, show: Callable[[float], None]
) -> Trace:
    signal, rows, moved, last, sample = test.signal, [], 0.0, 0.0, origin
    due = _Event(event, part)
    while not due.is_over(now := sample.time - origin.time, signal.duration + (0.0 if event else AFTER)):
        due.look(now, sample)
        rate = float(signal.rate(np.array([now]))[0]) if now < signal.duration - 1e-9 else 0.0
        moved += rate * (now - last)
        last = now
        rows.append((now, rate, sample.payout - origin.payout, sample.rate, sample.brake, sample.fault))
        show(min(now / signal.duration, 1.0))
        if due.does(COMMAND_LOSS):
            sample = part.idle()
        else:
            sample = part.step(origin.payout + moved, rate, brake=signal.is_braked or due.does(BRAKE))
        if sample.silence:
            silent = sample.time - origin.time - sample.silence
            return Trace(np.array([rows[0], *(row for row in rows[1:] if row[0] <= silent)]), due.begun, silent)
    return Trace(np.array(rows), due.begun)
