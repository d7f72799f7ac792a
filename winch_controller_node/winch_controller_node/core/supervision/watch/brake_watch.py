"""Motion under the brake by the raw load cell, and what follows where load cell or envelope have found one.

The load cell is watched against a nominal unit under a locked drum: wire that is paid out takes tension off at once,
the stiffness of the cable times its length, before the unit has followed. By the count the envelope finds it.
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
from winch_controller_node.model.nominal_load import PLAUSIBLE_LOAD

STANDING = 0.02
"""A drum slower than this stands [m/s]."""

FELT = 0.05
"""Wire paid out that the load cell has to show [m]."""

FALL_TIME, FALL_WINDOW = 0.3, 60.0
"""Time within which the tension falls, and memory of how it falls without a cause [s]."""

SPREADS = 8.0
"""Standard deviations of such falls above which one is a motion."""

SLACK_SHARE, SLACK_TIME = 0.5, 10.0
"""Below this share of the static tension a cable may go slack, and the load cell says nothing for this time [s]."""

SETTLED = 5.0
"""Time under the brake from which on the load cell counts [s]: the stop itself has shaken the load."""

HELD_TIME = 1.0
"""Time after which is reported whether anything holds the drum [s]."""


class LockedLoad(Protocol):
    """The nominal unit under a locked drum: its cable, and by how much that is longer than at rest [m]."""

    cable: CableModel

    @property
    def stretch(self) -> float:
        """Of the cable [m]."""


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
        """Restart; how the tension falls without a cause stays known."""
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
        self._tension = FallingTension(tick_period)
        self._time, self._since = 0.0, math.nan
        self._count = self._begin = math.nan
        self.gate = ""

    def acknowledge(self) -> None:
        """Take that an operator knows of it."""
        self.gate, self._since = "", math.nan
        self._tension.restart()

    def step(
        self,
        load: LockedLoad,
        *,
        is_braked: bool,
        runs: bool,
        winch: WinchReading | None,
        tensions: tuple[ScalarReading, ...] | None,
    ) -> tuple[Alarm, ...]:
        """Take in a tick; return what is new.

        Parameters
        ----------
        load : nominal, under a locked drum
        is_braked : the brake is ordered
        runs : the envelope has found by the count that the drum runs all the same
        winch : report of the drive; None: none
        tensions : readings of the load cell [N]; None: the load does not hang, so they fall with the sea
        """
        self._time = self._time + self._dt if is_braked else 0.0
        before, self._count = self._count, math.nan if winch is None else winch.encoder_payout
        if not is_braked:
            self._tension.restart()
            self._since = self._begin = math.nan
            return ()
        if math.isnan(self._begin):
            self._begin = self._count
        has_fallen = False
        if tensions is None:
            self._tension.restart()
        for one in (tensions or ())[-1:]:
            is_plausible = abs(one.value) <= PLAUSIBLE_LOAD * load.cable.static_tension
            has_fallen = self._time > SETTLED and is_plausible and self._tension.add(one.value, load)
        if not math.isnan(self._since):
            return self._follow((self._count - before) / self._dt, winch)
        if runs:
            self._since = 0.0
            return ()
        return self._felt(load) if has_fallen else ()

    def _felt(self, load: LockedLoad) -> tuple[Alarm, ...]:
        """Return the alarm of a load that falls."""
        fall = self._tension.fall
        alarm = ALARMS.alarm("LOAD_FALLS_BRAKED", fall=1e-3 * fall, time=FALL_TIME, way=fall / load.cable.stiffness)
        self._since, self.gate = 0.0, alarm.brief
        return (alarm,)

    def _follow(self, rate: float, winch: WinchReading | None) -> tuple[Alarm, ...]:
        """Return whether something holds the drum, by the `rate` of its count [m/s], once that is known."""
        before, self._since = self._since, self._since + self._dt
        if not before < HELD_TIME <= self._since:
            return ()
        moved = self._count - self._begin
        if abs(rate) < STANDING:
            return (ALARMS.alarm("DRUM_HELD_BY_DRIVE", moved=moved),)
        is_dead = winch is not None and winch.fault == WinchFault.EMERGENCY_STOP
        cause = "the emergency stop has taken the drive's power" if is_dead else "the drive does not hold it"
        return (ALARMS.alarm("DRUM_NOT_HELD", moved=moved, rate=rate, cause=cause),)
