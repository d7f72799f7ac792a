"""Proofs by nominal values and raw readings alone: of the MRU and the drum before they move a load, and of harm after.

Nothing here knows an estimate, an identified value or a gain. A nominal unit hangs on the nominal two-state cable

    a z'' + b z' + z = x0,    T = T0 + k (x0 - z)

from a locked drum, and is moved by the raw heave x0 of the boom tip.

- **MRU**: while the drum is braked, the load cell is compared with k (x0 - z) and the depth sensor with z, by least
  squares with an offset, a trend and a free swing of the unit beside the slope. A slope of 1 says that the MRU reads
  what the load does; a negative one that it is reversed. On a long cable tension is not mass times acceleration: the
  waves are quicker than the load, and the sign is the other one.
- **Drum**: in the first seconds after its release the count is compared with a nominal drum driven by what was sent.
- **Count**: it must go by the speed and the clock that the drive states with it.
- **Harm**: while compensating, the load cell must move less than it would under a locked drum.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace
from enum import Enum
from typing import NamedTuple

import numpy as np
from heave_node.interface.alarm import Alarm
from heave_node.interface.codes import MruStatus
from heave_node.interface.sensors import MruReading
from heave_node.numerics.arrays import Array
from heave_node.numerics.newest import Newest

from winch_controller_node.core.supervision.modes import Mode
from winch_controller_node.core.supervision.watch.brake_watch import BrakeWatch
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.interface.readings import Measurements, ScalarReading, WinchOrder, WinchReading
from winch_controller_node.model.blocks import CableModel
from winch_controller_node.model.simulated_unit import SimulatedUnit
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.model import WinchModelParameters

WINDOW = 20.0
"""Record by which a proof is made [s]: two waves of a long sea."""

SHORTEST = 8.0
"""Least record for a proof [s]."""

LOOKED_EVERY = 0.5
"""Time from one look to the next [s]."""

LOW_PASS = 0.25
"""Time constant of the low-pass of both sides of a comparison [s]."""

BLEND = 1.0
"""Time constant with which heave corrects the integral of its rate [s]: the noise of heave would shake a short cable."""

CERTAIN, ALIKE = 5.0, 0.6
"""Slope over its standard error, and correlation, that a proof needs: of 40 windows of a healthy MRU none had the wrong
sign, and all but two of a sea of 0.5 m on 300 m reached both."""

SCALE = (0.6, 1.4)
"""Slopes that prove an MRU: neither reversed nor twice. A load cell on a short cable says no more than that."""

PATIENCE = 60.0
"""Time after which a comparison that has proved nothing counts as no witness [s]: three windows."""

QUIET = 0.03
"""Heave, 1 sigma, in which nothing can be proved and nothing moves [m]."""

UNREAD = 0.5
"""Age of an MRU reading from which on the record breaks [s]."""

HARMFUL = 1.3
"""Spread of the load cell over that under a locked drum which is harm: nominal runs reach 0.7, an industrial law 1.0."""

LEAST_SPREAD = 0.01
"""Spread of the tension that harms nothing, over the static one."""

AT_REST = 2.0
"""Time after the brake was ordered from which on the drum counts as locked [s]."""

FIRST_AUTHORITY = 0.5
"""Authority until the drum has been seen to follow its orders."""

DRUM_SCALE, DRUM_ALIKE = (0.4, 2.0), 0.8
"""Slopes of the count on the nominal drum between which it follows, and correlation that says so."""

DRUM_MOVED = 0.005
"""Motion of the nominal drum, 1 sigma, from which on that is said [m]."""

OFF_COURSE, SHARE_OFF = 0.1, 0.4
"""Difference of the count from its stated speed over COUNT_TIME that is a contradiction [m], beside a share of the way."""

COUNT_TIME = 2.0
"""Memory of that comparison [s]."""


class Fit(NamedTuple):
    """One signal on another.

    Attributes
    ----------
    scale : slope of the least squares
    correlation : of what is left of both without offset, trend and free swing
    certainty : slope over its standard error, which allows for the correlation in time of the residual
    """

    scale: float
    correlation: float
    certainty: float

    @property
    def is_sure(self) -> bool:
        """Tell whether its sign is certain."""
        return abs(self.certainty) > CERTAIN and abs(self.correlation) > ALIKE

    @property
    def proves(self) -> bool:
        """Tell whether both signals are the same motion."""
        return self.is_sure and SCALE[0] < self.scale < SCALE[1]


NO_FIT = Fit(0.0, 0.0, 0.0)
"""Of signals that do not move."""


def fitted(y: Array, x: Array, step: float, frequency: float) -> Fit:
    """Return the fit of `y` on `x`, both of shape (n,), beside an offset, a trend and a swing of a `frequency` [rad/s].

    The standard error is that of n (1 - r)/(1 + r) independent samples, r the residual's correlation from one sample
    to the next (Bayley and Hammersley 1946, for a first-order process).

    Parameters
    ----------
    y, x : samples every `step` [s]
    step : [s]
    frequency : of the free swing; 0: none is taken out
    """
    t = step * np.arange(len(x))
    beside = [np.ones_like(t), t - t.mean()]
    if frequency > 0.0:
        beside += [np.cos(frequency * t), np.sin(frequency * t)]
    q, _ = np.linalg.qr(np.stack(beside, axis=1))
    x, y = x - q @ (q.T @ x), y - q @ (q.T @ y)
    xx, yy = float(x @ x), float(y @ y)
    if xx <= 0.0 or yy <= 0.0:
        return NO_FIT
    scale = float(x @ y) / xx
    rest = y - scale * x
    squares = float(rest @ rest)
    if squares <= 1e-18 * yy:
        return Fit(scale, math.copysign(1.0, scale), math.copysign(math.inf, scale))
    memory = max(float(rest[1:] @ rest[:-1]) / squares, 0.0)
    independent = len(x) * (1.0 - memory) / (1.0 + memory)
    error = math.sqrt(squares / xx / max(independent, 1.0))
    return Fit(scale, float(x @ y) / math.sqrt(xx * yy), scale / error)


class LowPass:
    """First-order low-pass of samples at any times, by LOW_PASS."""

    def __init__(self) -> None:
        self._time, self.value = -math.inf, math.nan

    def add(self, time: float, value: float) -> float:
        """Take in a `value` of a `time` [s]; return the filtered one."""
        passed = math.exp(-max(time - self._time, 0.0) / LOW_PASS)
        self.value = value if math.isnan(self.value) else value + passed * (self.value - value)
        self._time = time
        return self.value


class NominalLoad:
    """The nominal unit under a locked drum, moved by the raw MRU.

    Parameters
    ----------
    cable : nominal, at `length`
    length : of cable [m]
    tick_period : [s]

    Attributes
    ----------
    time : of the newest reading of the MRU [s]
    heave, unit : of boom tip and unit [m]
    is_known : the MRU reads, and has done so long enough for the blend
    """

    def __init__(self, cable: CableModel, length: float, tick_period: float) -> None:
        self._nominal, self._length, self._dt = cable, length, tick_period
        self.cable = cable
        self._unit = SimulatedUnit(cable, tick_period)
        self._at = length
        self.time, self.heave, self.unit = -math.inf, math.nan, 0.0
        self._base = (-math.inf, math.nan)
        self._rate = self._read_time = 0.0

    @property
    def is_known(self) -> bool:
        """Tell whether the MRU reads."""
        return self._read_time > BLEND

    @property
    def stretch(self) -> float:
        """By how much the cable is longer than at rest [m]; no less than slack."""
        return max(self.heave - self.unit, -self.cable.static_tension / self.cable.stiffness)

    @property
    def frequency(self) -> float:
        """Of the unit's free swing [rad/s]."""
        return 1.0 / math.sqrt(self.cable.natural_a)

    def pay_out(self, payout: float) -> None:
        """Hang the unit on the cable that a `payout` leaves [m]: its compliance goes with its length."""
        length = max(self._length + payout, 1.0)
        if abs(length / self._at - 1.0) < 0.05:
            return
        self._at, ratio, nominal = length, length / self._length, self._nominal
        self.cable = replace(
            nominal,
            a=nominal.a * ratio,
            b=nominal.b * ratio,
            drag=nominal.drag * ratio,
            stiffness=nominal.stiffness / ratio,
        )
        self._unit.take_cable(self.cable, self._dt)

    def step(self, now: float, readings: tuple[MruReading, ...], lift: tuple[float, float]) -> None:
        """Advance by a tick.

        Parameters
        ----------
        now : time of the tick [s]
        readings : of the MRU, at the boom tip, in it
        lift : of a crane that no drum has made up for, and its rate [m], [m/s]
        """
        read = [one for one in readings if one.status == MruStatus.OK and math.isfinite(one.heave + one.time)]
        if read:
            self._take(read[-1], lift)
        else:
            self.time += self._dt
            self.heave = self._base[1] + self._rate * (self.time - self._base[0])
        if not self.time - self._base[0] < UNREAD:
            self._read_time = self._rate = 0.0
            self._base = (self.time, self.heave)
        self._read_time += self._dt if read or self._read_time else 0.0
        if math.isfinite(self.heave):
            self.unit = float(self._unit.state[0])
            self._unit.step(np.array([self.heave, self._rate]))

    def _take(self, reading: MruReading, lift: tuple[float, float]) -> None:
        """Blend heave and rate of a `reading` with what its rate has made of the ones before."""
        time, before = self._base
        heave, since = reading.heave + lift[0], reading.time - time
        has_rate = math.isfinite(reading.heave_rate)
        rate = reading.heave_rate + lift[1] if has_rate else 0.0
        if not 0.0 <= since < UNREAD:
            self._read_time = 0.0
            if math.isnan(before):
                self._unit.continue_at(np.array([heave, 0.0]))
        elif has_rate:
            integral = before + 0.5 * since * (rate + self._rate)
            heave = integral + min(since / BLEND, 1.0) * (heave - integral)
        elif since > 0.0:
            rate = (heave - before) / since
        self.time, self.heave, self._rate = reading.time, heave, rate
        self._base = (self.time, self.heave)


class Standing(Enum):
    """What is known of the MRU."""

    OPEN = "not proved yet"
    QUIET = "too little motion to prove it by, and to do harm"
    PROVED = "proved"
    SCALED = "of another scale"
    REVERSED = "reversed"
    ALONE = "without a witness"


class Record:
    """Samples of one witness beside what the nominal load makes of the MRU.

    Parameters
    ----------
    length : samples that are kept
    """

    def __init__(self, length: int) -> None:
        self._time, self._read = Newest(length), Newest(length)
        self._filter = LowPass()

    def clear(self) -> None:
        """Begin anew."""
        self._time.clear()
        self._read.clear()
        self._filter = LowPass()

    def add(self, time: float, value: float) -> None:
        """Take a reading in; one that is no number or no later than the last one is left out."""
        if math.isfinite(time + value) and (not len(self._time) or time > self._time.last(1)[0]):
            self._time.append(time)
            self._read.append(self._filter.add(time, value))

    def at(self, times: Array) -> Array | None:
        """Return the readings at `times` (n,) [s], interpolated; None: they do not reach over them."""
        known = self._time.last()
        if len(known) < 2 or known[0] > times[0] + UNREAD or known[-1] < times[-1] - UNREAD:
            return None
        return np.interp(times, known, self._read.last())


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
        self._dt, self._kept = tick_period, round(WINDOW / tick_period)
        self._times, self._heave, self._tension, self._unit = (Newest(self._kept) for _ in range(4))
        # of readings that come quicker than ticks the oldest go first
        self._records = {"load cell": Record(2 * self._kept), "depth sensor": Record(2 * self._kept)}
        self._filters = LowPass(), LowPass()
        self.reset()

    def reset(self) -> None:
        """Prove it again: what was said of it holds no more."""
        self.standing, self.witness, self.fit = Standing.OPEN, "", NO_FIT
        self._waited = 0.0
        self.restart()

    def restart(self) -> None:
        """Begin another record; what is known stays."""
        for series in (self._times, self._heave, self._tension, self._unit, *self._records.values()):
            series.clear()
        self._filters = LowPass(), LowPass()
        self._next_look = SHORTEST

    def add(self, load: NominalLoad, tensions: tuple[ScalarReading, ...], depths: tuple[ScalarReading, ...]) -> None:
        """Take in a tick under a locked drum.

        Parameters
        ----------
        load : nominal, moved by the MRU
        tensions, depths : readings of the tick [N], [m]
        """
        for one in tensions:
            self._records["load cell"].add(one.time, one.value)
        for one in depths:
            self._records["depth sensor"].add(one.time, -one.value)
        if len(self._times) and load.time <= self._times.last(1)[0]:
            return
        self._times.append(load.time)
        self._heave.append(load.heave)
        self._tension.append(self._filters[0].add(load.time, load.cable.stiffness * load.stretch))
        self._unit.append(self._filters[1].add(load.time, load.unit))
        self._waited += self._dt
        self._next_look -= self._dt
        if self._next_look <= 0.0:
            self._next_look = LOOKED_EVERY
            self._look(load)

    def _look(self, load: NominalLoad) -> None:
        """Judge the record."""
        times = self._times.last()
        fits = {}
        for witness, expected in (("load cell", self._tension), ("depth sensor", self._unit)):
            read = self._records[witness].at(times)
            if read is not None:
                fits[witness] = fitted(read, expected.last(), self._dt, load.frequency)
        standing, witness = self._judged(fits)
        if standing is Standing.OPEN:
            if self.standing not in (Standing.OPEN, Standing.QUIET):
                return  # what was certain is not forgotten for a record that says nothing
            if not fits or self._waited > PATIENCE:
                standing = Standing.ALONE
            if float(np.std(self._heave.last())) < QUIET:
                standing = Standing.QUIET
        best = max(fits, key=lambda name: abs(fits[name].certainty), default="")
        self.standing, self.witness = standing, witness or best
        self.fit = fits.get(self.witness, NO_FIT)

    @staticmethod
    def _judged(fits: dict[str, Fit]) -> tuple[Standing, str]:
        """Return what the `fits` say, and which: one that proves it outweighs one that is wired the other way."""
        for witness, fit in fits.items():
            if fit.proves:
                return Standing.PROVED, witness
        for witness, fit in fits.items():
            if fit.is_sure:
                return (Standing.REVERSED if fit.scale < 0.0 else Standing.SCALED), witness
        return Standing.OPEN, ""


class DrumProof:
    """Proves that the count follows what was sent, as a nominal drum does, in the first seconds after each release.

    Parameters
    ----------
    winch : nominal
    tick_period : [s]

    Attributes
    ----------
    is_proved : since the release
    fit : of the count on the nominal drum
    """

    def __init__(self, winch: WinchModelParameters, tick_period: float) -> None:
        self._winch, self._dt = winch, tick_period
        self._sent = deque([0.0], maxlen=round(winch.command_delay / tick_period) + 1)
        kept = round(WINDOW / tick_period)
        self._count, self._drum = Newest(kept), Newest(kept)
        self.restart(0.0)

    def restart(self, payout: float) -> None:
        """Begin again, with the drum at rest at a `payout` [m]."""
        self._count.clear()
        self._drum.clear()
        self._sent.clear()
        self._payout, self._rate, self._time = payout, 0.0, 0.0
        self.is_proved, self.fit = False, NO_FIT

    def step(self, sent: WinchOrder, count: float) -> None:
        """Take in a tick of a released drum.

        Parameters
        ----------
        sent : the order of the tick before
        count : reading of the encoder at its end [m]; NaN: none
        """
        self._advance(sent)
        self._time += self._dt
        if self.is_proved or not math.isfinite(count):
            return
        self._count.append(count)
        self._drum.append(self._payout)
        look = round(LOOKED_EVERY / self._dt)
        if len(self._drum) < 4 * look or round(self._time / self._dt) % look:
            return
        drum = self._drum.last()
        if float(np.std(drum)) < DRUM_MOVED:
            return
        self.fit = fitted(self._count.last(), drum, self._dt, 0.0)
        self.is_proved = self.fit.correlation > DRUM_ALIKE and DRUM_SCALE[0] < self.fit.scale < DRUM_SCALE[1]

    @property
    def is_over(self) -> bool:
        """Tell whether the drum is proved, or has hardly been asked to move for a whole record."""
        return self.is_proved or self._time > WINDOW

    @property
    def is_contradicted(self) -> bool:
        """Tell whether the count goes another way than the drum was sent, or far more or less of it."""
        is_inside = DRUM_SCALE[0] < self.fit.scale < DRUM_SCALE[1]
        return not self.is_proved and not is_inside and abs(self.fit.correlation) > DRUM_ALIKE

    def _advance(self, sent: WinchOrder) -> None:
        """Move the nominal drum by a tick."""
        winch = self._winch
        if winch.law == "first_order":
            asked = winch.position_rate * (sent.payout - self._payout)
        else:
            asked = sent.payout_rate + winch.position_gain * (sent.payout - self._payout)
        self._sent.append(asked)
        late = self._sent[0] if len(self._sent) == self._sent.maxlen else 0.0
        lag = self._dt if winch.law == "first_order" else max(winch.time_constant, self._dt)
        pull = (min(max(late, -winch.speed_limit), winch.speed_limit) - self._rate) * self._dt / lag
        largest = winch.acceleration_limit * self._dt
        before, self._rate = self._rate, self._rate + min(max(pull, -largest), largest)
        self._payout += 0.5 * (before + self._rate) * self._dt


class CountCheck:
    """Compares the count with the speed that the drive states beside it, by the drive's own clock."""

    def __init__(self) -> None:
        self._before: WinchReading | None = None
        self._error = self._way = 0.0
        self._has_rate = False

    def step(self, winch: WinchReading | None) -> Alarm | None:
        """Take in a report of the drive; return that count, clock and speed contradict one another.

        A drive that states no speed (0 or NaN for ever) is no witness.
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


class LoadHarm:
    """Compares how the load cell moves with how it would under a locked drum.

    Parameters
    ----------
    tick_period : [s]
    """

    def __init__(self, tick_period: float) -> None:
        self._dt = tick_period
        kept = round(WINDOW / tick_period)
        self._read, self._locked = Newest(kept), Newest(kept)
        self._trend = np.linspace(-1.0, 1.0, kept)
        self._tension, self._ticks = math.nan, 0
        self.ratio = 0.0

    def restart(self) -> None:
        """Begin another record."""
        self._read.clear()
        self._locked.clear()

    def step(self, load: NominalLoad, tensions: tuple[ScalarReading, ...]) -> Alarm | None:
        """Take in a tick; return that the load moves more than under a locked drum.

        Parameters
        ----------
        load : nominal, moved by the MRU
        tensions : readings of the load cell in it [N]
        """
        if tensions:
            self._tension = tensions[-1].value
        if not math.isfinite(self._tension):
            return None
        self._read.append(self._tension)
        self._locked.append(load.cable.stiffness * load.stretch)
        self._ticks += 1
        if len(self._read) < self._trend.size or self._ticks % round(1.0 / self._dt):
            return None
        read, locked = self._spread(self._read.last()), self._spread(self._locked.last())
        self.ratio = read / (locked + LEAST_SPREAD * load.cable.static_tension)
        if self.ratio <= HARMFUL:
            return None
        return ALARMS.alarm("LOAD_CELL_HARM", spread=1e-3 * read, locked=1e-3 * locked, ratio=self.ratio, limit=HARMFUL)

    def _spread(self, values: Array) -> float:
        """Return the standard deviation of `values` (n,) about their trend."""
        about = values - values.mean()
        slope = float(self._trend @ about) / float(self._trend @ self._trend)
        return float(np.std(about - slope * self._trend))


class Driven(NamedTuple):
    """What the winch is used for in a tick.

    Attributes
    ----------
    mode : of the tick before
    is_wanted : compensation is to begin, or goes on
    hangs : the unit hangs, as far as is known
    is_moving : the mean payout is on its way
    """

    mode: Mode
    is_wanted: bool
    hangs: bool
    is_moving: bool


class Proven(NamedTuple):
    """What follows from the proofs of a tick.

    Attributes
    ----------
    gate : why compensation may not begin, in words; empty where it may
    authority_limit : largest authority
    harm : what compensation does; None: no harm
    alarms : what is new
    """

    gate: str = ""
    authority_limit: float = 1.0
    harm: Alarm | None = None
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
    consent : an operator has compensation begin without a witness
    """

    def __init__(self, parameters: WinchControllerParameters, cable: CableModel, tick_period: float) -> None:
        self._dt = tick_period
        self.motion, self.harm = MotionProof(tick_period), LoadHarm(tick_period)
        self.count = CountCheck()
        self.take_nominal(parameters, cable)
        self._sent: WinchOrder | None = None
        self._braked_time, self._compensating_time = AT_REST, 0.0
        self._told = Standing.OPEN
        self._said = ""

    def take_nominal(self, parameters: WinchControllerParameters, cable: CableModel) -> None:
        """Prove by other nominal `parameters` and `cable` from now on."""
        self.consent = parameters.entry.accept_unproved
        self.load = NominalLoad(cable, parameters.length, self._dt)
        self.drum = DrumProof(parameters.winch, self._dt)
        self.brake = BrakeWatch(self._dt)
        self.motion.reset()
        self.harm.restart()

    def ask(self, *, consent: bool) -> None:
        """Take that an operator asks for a mode, with or without `consent` to begin without a witness."""
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

    def step(
        self, now: float, raw: Measurements, at_tip: Measurements, lift: tuple[float, float], driven: Driven
    ) -> Proven:
        """Take in a tick.

        Parameters
        ----------
        now : time of the tick [s]
        raw : as they were delivered
        at_tip : with the MRU's readings carried to the boom tip
        lift : of a crane that no drum has made up for, and its rate [m], [m/s]
        driven : what the winch is used for
        """
        tensions, depths, winch = raw.of("load_cell"), raw.of("depth"), raw.winch
        count = math.nan if winch is None else winch.encoder_payout
        if math.isfinite(count):
            self.load.pay_out(count)
        self.load.step(now, at_tip.mru, lift)
        is_braked = self._sent is None or self._sent.brake
        self._braked_time = self._braked_time + self._dt if is_braked else 0.0
        alarms = self.brake.step(self.load, is_braked=is_braked, winch=winch, tensions=tensions)
        if found := self.count.step(winch):
            alarms += (found,)
        self._follow_drum(count, is_braked=is_braked)
        if self._braked_time > AT_REST and driven.hangs and self.load.is_known:
            self.motion.add(self.load, tensions, depths)
        else:
            self.motion.restart()
        harm = self._harm(tensions, driven)
        gate = self._said = self.brake.gate or self._gate()
        if driven.mode is Mode.STANDBY and driven.is_wanted and self.motion.standing is not self._told:
            self._told = self.motion.standing
            alarms += (self._alarm,) if self._is_closed else ()
        is_first = driven.mode is Mode.COMPENSATING and not self.drum.is_over
        return Proven(gate, FIRST_AUTHORITY if is_first else 1.0, harm, alarms)

    def _follow_drum(self, count: float, *, is_braked: bool) -> None:
        """Compare the `count` [m] with the nominal drum while that is released."""
        if is_braked or self._sent is None:
            if math.isfinite(count):
                self.drum.restart(count)
        else:
            self.drum.step(self._sent, count)

    def _harm(self, tensions: tuple[ScalarReading, ...], driven: Driven) -> Alarm | None:
        """Return the harm that compensation does."""
        is_compensating = driven.mode is Mode.COMPENSATING
        self._compensating_time = self._compensating_time + self._dt if is_compensating else 0.0
        if not (self.load.is_known and driven.hangs) or driven.is_moving:
            self.harm.restart()
            return None
        harm = self.harm.step(self.load, tensions)
        if not is_compensating:
            return None
        if self.drum.is_contradicted:
            fit, self.drum.fit = self.drum.fit, NO_FIT
            return ALARMS.alarm("DRUM_CONTRADICTED", scale=fit.scale, correlation=fit.correlation)
        if harm is None or self._compensating_time < SHORTEST:
            return None
        self.motion.reset()
        self.consent = False
        return harm

    @property
    def _is_closed(self) -> bool:
        """Tell whether compensation may not begin until somebody has done something."""
        standing = self.motion.standing
        return standing is Standing.REVERSED or (standing in (Standing.SCALED, Standing.ALONE) and not self.consent)

    @property
    def _alarm(self) -> Alarm:
        """What keeps compensation from beginning."""
        proof = self.motion
        if proof.standing is Standing.ALONE:
            why = f"{proof.witness} agrees by {proof.fit.correlation:.2f}" if proof.witness else "no witness reads"
            return ALARMS.alarm("MRU_UNPROVED", why=why, time=PATIENCE)
        code = "MRU_REVERSED" if proof.standing is Standing.REVERSED else "MRU_SCALE_UNPROVED"
        fit = proof.fit
        return ALARMS.alarm(
            code, witness=proof.witness, scale=fit.scale, correlation=fit.correlation, certainty=abs(fit.certainty)
        )

    def _gate(self) -> str:
        """Return why compensation may not begin by what is known of the MRU."""
        if self._is_closed:
            return self._alarm.brief
        if self.motion.standing is Standing.OPEN and not self.consent:
            return "proving the MRU by load cell and depth sensor"
        return ""
