"""Proofs by nominal values and raw readings alone, before the brake opens; no estimate or identified value is used.

- **MRU**: while the drum is braked, the load cell is compared with what a nominal load makes of the raw MRU,
  k (x0 - z), and the depth sensor with its z, by least squares with an offset, a trend and a free swing beside the
  slope. A slope of 1 says that the MRU reads what the load does; a negative one that it is reversed. On a long cable
  tension is not mass times acceleration: the waves are quicker than the load, and the sign is the other one.
- **Count**: it must go by the speed that the drive states with it, and by the drive's clock.

What the drum makes of its orders, and whether the load cell shows harm later, is the envelope's.
"""

from __future__ import annotations

import math
from enum import Enum
from typing import NamedTuple

import numpy as np
from heave_node.interface.alarm import Alarm
from heave_node.numerics.newest import Newest

from winch_controller_node.core.supervision.watch.brake_watch import BrakeWatch
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.interface.readings import Measurements, ScalarReading, WinchOrder, WinchReading
from winch_controller_node.model.blocks import CableModel
from winch_controller_node.model.comparison import NO_FIT, Fit, Series, fitted
from winch_controller_node.model.nominal_load import NominalLoad
from winch_controller_node.node_parameters import WinchControllerParameters

WINDOW, SHORTEST = 20.0, 8.0
"""Record by which a proof is made, two waves of a long sea, and the least one [s]."""

LOOKED_EVERY = 0.5
"""Time from one look to the next [s]."""

PATIENCE = 60.0
"""Time after which a comparison that has proved nothing counts as no cross-check [s]: three windows."""

QUIET = 0.03
"""Heave, 1 sigma, in which nothing can be proved and nothing moves [m]."""

AT_REST = 2.0
"""Time after the brake was ordered from which on the drum counts as locked [s]."""

OFF_COURSE, SHARE_OFF = 0.1, 0.4
"""Difference of the count from its stated speed that is a contradiction [m], beside a share of the way."""

COUNT_TIME = 2.0
"""Memory of that comparison [s]."""


class Standing(Enum):
    """What is known of the MRU."""

    OPEN = "not proved yet"
    QUIET = "too little motion to prove it by, and to do harm"
    PROVED = "proved"
    SCALED = "of another scale"
    REVERSED = "reversed"
    ALONE = "without a witness"


class MotionProof:
    """Proves the MRU by load cell and depth sensor while the drum is braked.

    Parameters
    ----------
    tick_period : [s]

    Attributes
    ----------
    standing : what is known
    witness, fit : by which sensor, and with which numbers; empty and NO_FIT: by none
    """

    def __init__(self, tick_period: float) -> None:
        self._dt, kept = tick_period, round(WINDOW / tick_period)
        self._heave, tension, unit = Newest(kept), Series(kept), Series(kept)
        self._tension, self._unit = tension, unit
        # a sensor may read more often than once a tick
        self._witnesses = {"load cell": (Series(2 * kept), tension), "depth sensor": (Series(2 * kept), unit)}
        self._has_record = True
        self.reset()

    def reset(self) -> None:
        """Prove it again: the last result holds no more."""
        self.standing, self.witness, self.fit = Standing.OPEN, "", NO_FIT
        self._waited = 0.0
        self.restart()

    def restart(self) -> None:
        """Begin another record; what is known stays."""
        if not self._has_record:
            return
        self._has_record = False
        self._heave.clear()
        for read, expected in self._witnesses.values():
            read.clear()
            expected.clear()
        self._next_look = SHORTEST

    def add(self, load: NominalLoad, tensions: tuple[ScalarReading, ...], depths: tuple[ScalarReading, ...]) -> None:
        """Take in a tick under a locked drum.

        Parameters
        ----------
        load : nominal, moved by the MRU
        tensions, depths : readings of the tick [N], [m]
        """
        self._has_record = True
        for one in tensions:
            self._witnesses["load cell"][0].add(one.time, one.value)
        for one in depths:
            self._witnesses["depth sensor"][0].add(one.time, -one.value)
        if not self._tension.add(load.time, load.cable.stiffness * load.stretch):
            return
        self._unit.add(load.time, load.unit)
        self._heave.append(load.heave)
        self._waited += self._dt
        self._next_look -= self._dt
        if self._next_look <= 0.0:
            self._next_look = LOOKED_EVERY
            self._look(load.frequency)

    def _look(self, frequency: float) -> None:
        """Judge the record, beside a free swing of a `frequency` [rad/s]."""
        fits = {}
        for witness, (series, expected) in self._witnesses.items():
            read = series.at(expected.times)
            if read is not None:
                fits[witness] = fitted(read, expected.values, self._dt, frequency)
        standing, witness = _judged(fits)
        if standing is Standing.OPEN:
            if self.standing not in (Standing.OPEN, Standing.QUIET, Standing.ALONE):
                return  # a result is not reset by a record without one
            if not fits or self._waited > PATIENCE:
                standing = Standing.ALONE
            if float(np.std(self._heave.last())) < QUIET:
                standing = Standing.QUIET
        self.standing = standing
        self.witness = witness or max(fits, key=lambda name: abs(fits[name].certainty), default="")
        self.fit = fits.get(self.witness, NO_FIT)


def _judged(fits: dict[str, Fit]) -> tuple[Standing, str]:
    """Return what the `fits` say, and which: one that proves the MRU outweighs one that is wired the other way."""
    for witness, fit in fits.items():
        if fit.proves:
            return Standing.PROVED, witness
    for witness, fit in fits.items():
        if fit.refutes:
            return (Standing.REVERSED if fit.scale < 0.0 else Standing.SCALED), witness
    return Standing.OPEN, ""


class CountCheck:
    """Compares the count with the speed that the drive states beside it, by the drive's own clock."""

    def __init__(self) -> None:
        self._before: WinchReading | None = None
        self._error = self._way = 0.0
        self._has_rate = False

    def step(self, winch: WinchReading | None) -> Alarm | None:
        """Take in a report of the drive, `winch`; return that count, clock and speed contradict one another.

        A drive that states no speed (0 or NaN for ever) is no cross-check.
        """
        before = self._before
        if winch is None or not math.isfinite(winch.time + winch.encoder_payout):
            return None
        self._before = winch
        rate = winch.encoder_payout_rate
        self._has_rate |= math.isfinite(rate) and rate != 0.0
        if before is None or not self._has_rate or not math.isfinite(rate + before.encoder_payout_rate):
            return None
        since, step = winch.time - before.time, winch.encoder_payout - before.encoder_payout
        if since <= 0.0:
            return None
        left = math.exp(-since / COUNT_TIME)
        # a speed that is the mean of the interval and one that holds at its end are both taken
        by_speed = 0.5 * (rate + before.encoder_payout_rate) * since
        ends = sorted((rate * since, by_speed))
        self._error = left * self._error + step - min(max(step, ends[0]), ends[1])
        self._way = left * self._way + max(abs(step), abs(by_speed))
        if abs(self._error) <= OFF_COURSE + SHARE_OFF * self._way:
            return None
        found = ALARMS.alarm("COUNT_SPEED_DISAGREE", error=self._error, way=self._way, time=COUNT_TIME)
        self._error = 0.0
        return found


class Driven(NamedTuple):
    """What the winch is used for in a tick.

    Attributes
    ----------
    waits : compensation is to begin
    hangs : the unit hangs, as far as is known
    taken_over : code of the alarm for which the envelope has taken over; empty: it has not
    """

    waits: bool
    hangs: bool
    taken_over: str = ""


class Proven(NamedTuple):
    """What follows from the proofs of a tick.

    Attributes
    ----------
    gate : why compensation may not begin, in words; empty where it may
    alarms : what is new
    """

    gate: str = ""
    alarms: tuple[Alarm, ...] = ()


class Proofs:
    """All proofs of a controller.

    Parameters
    ----------
    parameters : nominal ones
    cable : nominal, at their length
    tick_period : [s]

    Attributes
    ----------
    consent : an operator has compensation begin without a cross-check
    """

    def __init__(self, parameters: WinchControllerParameters, cable: CableModel, tick_period: float) -> None:
        self._dt = tick_period
        self.motion, self._count = MotionProof(tick_period), CountCheck()
        self._sent: WinchOrder | None = None
        self._braked_time, self._said, self._told = AT_REST, "", Standing.OPEN
        self.take_nominal(parameters, cable)

    def take_nominal(self, parameters: WinchControllerParameters, cable: CableModel) -> None:
        """Prove by other nominal `parameters` and `cable` from now on."""
        self.consent = parameters.entry.accept_unproved
        self.load = NominalLoad(cable, parameters.length, self._dt)
        self.brake = BrakeWatch(self._dt)
        self.motion.reset()

    def ask(self, *, consent: bool) -> None:
        """Take that an operator asks for a mode, with or without `consent` to begin without a cross-check."""
        self.consent |= consent
        self.brake.acknowledge()
        self._told = Standing.OPEN

    def left_of(self, obstacle: str) -> str:
        """Return what is left of an `obstacle` of the last tick, now that an operator asks: a proof is waited for."""
        is_mine = obstacle and obstacle == self._said
        return ("" if self.motion.standing is Standing.OPEN else self._gate()) if is_mine else obstacle

    def note(self, sent: WinchOrder) -> None:
        """Note the order that was `sent` in this tick."""
        self._sent = sent

    def step(self, measurements: Measurements, driven: Driven) -> Proven:
        """Take in a tick.

        Parameters
        ----------
        measurements : as delivered
        driven : what the winch is used for
        """
        tensions, winch = measurements.of("load_cell"), measurements.winch
        if winch is not None and math.isfinite(winch.encoder_payout):
            self.load.pay_out(winch.encoder_payout)
        self.load.step(measurements.mru)
        is_braked = self._sent is None or self._sent.brake
        self._braked_time = self._braked_time + self._dt if is_braked else 0.0
        runs = driven.taken_over == "DRUM_RUNS_BRAKED"
        felt = tensions if driven.hangs else None
        alarms = self.brake.step(self.load, is_braked=is_braked, runs=runs, winch=winch, tensions=felt)
        if found := self._count.step(winch):
            alarms += (found,)
        if self._braked_time > AT_REST and driven.hangs and self.load.is_known:
            self.motion.add(self.load, tensions, measurements.of("depth"))
        else:
            self.motion.restart()
        if driven.taken_over == "LOAD_SWUNG_HIGHER":
            self.motion.reset()
            self.consent = False
        self._said = self.brake.gate or self._gate()
        if driven.waits and self.motion.standing is not self._told:
            self._told = self.motion.standing
            alarms += (self._alarm,) if self._is_closed else ()
        return Proven(self._said, alarms)

    @property
    def _is_closed(self) -> bool:
        """Tell whether compensation may not begin until somebody has done something."""
        standing = self.motion.standing
        return standing is Standing.REVERSED or (standing in (Standing.SCALED, Standing.ALONE) and not self.consent)

    @property
    def _alarm(self) -> Alarm:
        """What keeps compensation from beginning."""
        proof, fit = self.motion, self.motion.fit
        if proof.standing is Standing.ALONE:
            why = (
                f"the {proof.witness} agrees by {fit.correlation:.2f}"
                if proof.witness
                else "neither load cell nor depth sensor reads"
            )
            return ALARMS.alarm("MRU_UNPROVED", why=why)
        code = "MRU_REVERSED" if proof.standing is Standing.REVERSED else "MRU_SCALE_UNPROVED"
        numbers = {"scale": fit.scale, "correlation": fit.correlation, "certainty": abs(fit.certainty)}
        return ALARMS.alarm(code, witness=proof.witness, **numbers)

    def _gate(self) -> str:
        """Return why compensation may not begin by what is known of the MRU."""
        if self._is_closed:
            return self._alarm.brief
        return "proving the MRU by load cell and depth sensor" if self.motion.standing is Standing.OPEN else ""
