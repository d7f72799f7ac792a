"""Motion under the brake, by the raw count and by the raw load cell: the load goes down and nothing was ordered.

The count is watched from the moment at which the drum has come to rest, or has become quicker again under the brake.
A single step of it is a jump of the count, not a motion. The load cell is watched against a nominal unit under a locked
drum: wire that is paid out takes tension off at once, the stiffness of the cable times its length, before the unit has
followed. It counts where the count shows nothing.
"""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np
from heave_node.interface.alarm import Alarm
from heave_node.interface.codes import WinchFault
from heave_node.numerics.newest import Newest

from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.interface.readings import ScalarReading, WinchReading
from winch_controller_node.model.blocks import CableModel

MOVED = 0.03
"""Motion under the brake that is told [m]: with the next reading it is not more than 0.05 m up to 0.5 m/s."""

STANDING, FASTER = 0.02, 0.05
"""A drum slower than the first stands; one that has become so much quicker again is not held [m/s]."""

LONGEST_STOP = 10.0
"""Time after which a drum that is to brake must stand [s]: from 2 m/s with 0.2 m/s2."""

JUMP, SAME = 0.015, 0.2
"""Step of the count in a tick that may be a jump [m]; motion has another step beside it, of at least this share."""

FELT = 0.05
"""Wire paid out that the load cell has to show [m]."""

FALL_TIME, FALL_WINDOW = 0.3, 60.0
"""Time within which the tension falls, and memory of how it falls without a cause [s]."""

SPREADS = 8.0
"""Standard deviations of such falls above which one is a motion."""

SLACK_SHARE, SLACK_TIME = 0.5, 10.0
"""Below this share of the static tension a cable may go slack, and the load cell says nothing for this time [s]."""

STOP_DELAY = 0.5
"""Time for which a drum may still follow the order before the brake [s]: delay and lag of the drive."""

SETTLED = 5.0
"""Time under the brake from which on the load cell counts [s]: the stop itself has shaken the load."""

HELD_TIME = 1.0
"""Time after which it is told whether anything holds the drum [s]."""


class LockedLoad(Protocol):
    """The nominal unit under a locked drum."""

    cable: CableModel

    @property
    def stretch(self) -> float:
        """By how much its cable is longer than at rest [m]."""

    @property
    def is_known(self) -> bool:
        """The motion of the boom tip is measured."""


class HeldCount:
    """The way of a count since its drum was to be held.

    Parameters
    ----------
    tick_period : [s]

    Attributes
    ----------
    moved : since then [m]; rate : in the last tick [m/s]
    """

    def __init__(self, tick_period: float) -> None:
        self._dt = tick_period
        self._last = math.nan
        self.restart()

    def restart(self) -> None:
        """Begin anew, with a drum that is to come to rest."""
        self._slowest = math.inf
        self._pending = self._time = 0.0
        self._is_held = self._runs = False
        self.moved = self.rate = 0.0

    def add(self, count: float, *, is_stopping: bool) -> None:
        """Take in a tick.

        Parameters
        ----------
        count : of the drum [m]; NaN: there is none
        is_stopping : the drum may still follow the last order: the brake has just been ordered
        """
        step, self._last = count - self._last, count if math.isfinite(count) else self._last
        if not math.isfinite(step):
            return
        self._time += self._dt
        self.rate = step / self._dt
        if is_stopping:
            return
        speed, before = abs(self.rate), self._slowest
        self._slowest = min(before, speed)
        self._is_held |= speed < STANDING or speed > before + FASTER or self._time > LONGEST_STOP
        if self._is_held:
            self._take(step)

    def _take(self, step: float) -> None:
        """Count a `step` [m]; a large one only once another stands beside it."""
        pending, self._pending = self._pending, 0.0
        if abs(step) <= JUMP:
            self.moved += step
            self._runs = False
        elif self._runs:
            self.moved += step
        elif pending * step > 0.0 and abs(step) > SAME * abs(pending):
            self.moved += pending + step
            self._runs = True
        else:
            self._pending = step


class FallingTension:
    """How far the tension has fallen within FALL_TIME, over what it does under a locked drum.

    Parameters
    ----------
    tick_period : [s]
    """

    def __init__(self, tick_period: float) -> None:
        self._dt, self._ticks = tick_period, max(round(FALL_TIME / tick_period), 2)
        self._rest = Newest(2 * self._ticks)
        self._square, self._seen, self._slack = 0.0, 0.0, 0.0
        self._falls = 0
        self.fall = 0.0

    def restart(self) -> None:
        """Begin anew; how the tension falls without a cause is known on."""
        self._rest.clear()
        self._falls, self._slack = 0, 0.0

    def add(self, tension: float, load: LockedLoad) -> bool:
        """Take in a `tension` [N] of a tick beside the nominal `load`; return whether wire must have been paid out."""
        cable = load.cable
        self._slack = SLACK_TIME if tension < SLACK_SHARE * cable.static_tension else max(self._slack - self._dt, 0.0)
        self._rest.append(tension - cable.stiffness * load.stretch)
        if len(self._rest) < 2 * self._ticks:
            return False
        rest = self._rest.last()
        self.fall = float(np.mean(rest[: self._ticks]) - np.mean(rest[-2:]))
        largest = cable.stiffness * FELT + SPREADS * math.sqrt(self._square)
        is_falling = self._seen > 0.25 * FALL_WINDOW and self._slack == 0.0 and self.fall > largest
        if not is_falling:
            weight = max(self._dt / FALL_WINDOW, self._dt / (self._seen + self._dt))
            self._square += weight * (self.fall**2 - self._square)
            self._seen += self._dt
        self._falls = self._falls + 1 if is_falling else 0
        return self._falls > 1


class BrakeWatch:
    """Watches a braked drum.

    Parameters
    ----------
    tick_period : [s]

    Attributes
    ----------
    gate : why compensation may not begin, in words, until an operator asks for a mode; empty where it may
    """

    def __init__(self, tick_period: float) -> None:
        self._dt = tick_period
        self._count, self._tension = HeldCount(tick_period), FallingTension(tick_period)
        self._time = 0.0
        self._since = math.nan
        self.gate = ""

    def acknowledge(self) -> None:
        """Take that an operator knows of it."""
        self.gate, self._since = "", math.nan
        self._count.restart()
        self._tension.restart()

    def step(
        self, load: LockedLoad, *, is_braked: bool, winch: WinchReading | None, tensions: tuple[ScalarReading, ...]
    ) -> tuple[Alarm, ...]:
        """Take in a tick; return what is new.

        Parameters
        ----------
        load : nominal, under a locked drum
        is_braked : the brake is ordered
        winch : report of the drive; None: none
        tensions : readings of the load cell [N]
        """
        self._time = self._time + self._dt if is_braked else 0.0
        count = math.nan if winch is None else winch.encoder_payout
        stops_itself = winch is not None and (winch.brake or winch.fault != WinchFault.NONE)
        if not is_braked:
            self._count.restart()
            self._tension.restart()
            self._since = math.nan
        self._count.add(count, is_stopping=not is_braked or (self._time < STOP_DELAY and not stops_itself))
        if not is_braked:
            return ()
        has_fallen = False
        for one in tensions[-1:]:
            has_fallen = self._time > SETTLED and math.isfinite(one.value) and self._tension.add(one.value, load)
        if not math.isnan(self._since):
            return self._follow()
        if abs(self._count.moved) >= MOVED:
            return self._tell(self._count.moved, "count", winch)
        if has_fallen:
            return self._tell(self._tension.fall / load.cable.stiffness, "load cell", winch)
        return ()

    def _tell(self, moved: float, witness: str, winch: WinchReading | None) -> tuple[Alarm, ...]:
        """Return the alarm of a drum that has `moved` [m] by a `witness`."""
        is_dead = winch is not None and winch.fault == WinchFault.EMERGENCY_STOP
        follows = (
            "The emergency stop has taken the drive's power: nothing holds the load"
            if is_dead
            else "A drive that is supervised holds the drum now; where it does not, the load goes on"
        )
        alarm = ALARMS.alarm("BRAKE_DOES_NOT_HOLD", moved=moved, witness=witness, follows=follows)
        self._since = 0.0
        self.gate = alarm.brief
        return (alarm,)

    def _follow(self) -> tuple[Alarm, ...]:
        """Return whether something holds the drum, once that is known."""
        before, self._since = self._since, self._since + self._dt
        if not before < HELD_TIME <= self._since:
            return ()
        moved, rate = self._count.moved, self._count.rate
        if abs(rate) < STANDING:
            return (ALARMS.alarm("DRUM_HELD_BY_DRIVE", moved=moved),)
        return (ALARMS.alarm("DRUM_NOT_HELD", moved=moved, rate=rate),)
