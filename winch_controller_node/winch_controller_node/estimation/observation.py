"""From what was delivered to what the estimator takes: gates, signs, means, and the mean payout's share taken off."""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

from heave_node.interface.alarm import Alarm
from heave_node.interface.codes import SensorLevel, WinchFault
from heave_node.interface.sensors import MruReading
from heave_node.numerics.arrays import Array

from winch_controller_node.beliefs.corrections import AS_READ, Correction
from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.estimation.mru_steps import MruSteps
from winch_controller_node.estimation.sensor_health import (
    CONTRADICTS,
    DepthJumps,
    EncoderGate,
    SensorGate,
    SensorTiming,
    judge_mru,
    judge_scalar,
)
from winch_controller_node.estimation.sensor_noise import SensorNoise
from winch_controller_node.estimation.surprise import Surprise
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.interface.readings import Measurements, ScalarReading, SensorState
from winch_controller_node.interface.sensors import (
    LEVER_ARM_X,
    LEVER_ARM_Y,
    SCALAR_SENSORS,
    SensorModelParameters,
    Zero,
)
from winch_controller_node.model.estimator import KalmanEstimator, Measurement
from winch_controller_node.parameters.laws import HealthParameters

ON_TICK = 1e-4
"""A stamp that is off its tick by a smaller share of the tick period is on it."""

NEGLIGIBLE = 1e-4
"""A noise that is believed to be no larger than this, in the sensor's unit, is never too large."""

HEAVE_ALONE = "heave alone: it measures no rate"
"""How an MRU is seen that has no fault and states no heave rate."""

REMEMBERED = 64
"""Ticks for which the mean payout's share is kept, for readings that come late."""


class Observed(NamedTuple):
    """A reading as the adviser gets it.

    Attributes
    ----------
    reading : gated, with the time and sigma that it has, about its zero and in the sign of the model
    value : as read
    share : of it that the mean payout brings about, were nothing corrected
    is_used : the estimator takes it
    """

    reading: Measurement
    value: float
    share: float
    is_used: bool


class Observer:
    """Gates the readings of a tick and puts them into the estimator's terms.

    Parameters
    ----------
    design : its measurements and their rates
    health : tolerances of the gates

    Attributes
    ----------
    gates : by sensor
    payout : encoder reading accepted in this tick, jumps taken off [m]; None: none
    tension : newest accepted top tension [N]; NaN before the first
    mru_rate : newest accepted heave rate of the MRU [m/s]; NaN: it measures none
    depths : stamp [s] and depth, positive down [m], of the depth readings accepted in this tick
    witnessed : readings of this tick that the estimator does not take, in its terms: they tell which sensor is wrong
    doubted : sensor in use whose readings are only witnesses: they contradict all others; empty: none
    stretch_per_payout : how much further than paid out the unit goes down at rest: stretch of the new cable [-]
    corrections : of the readings, by sensor
    observed : readings of this tick as they were read, before corrections, for the adviser
    """

    def __init__(self, design: ControllerDesign, health: HealthParameters) -> None:
        self._dt = design.tick_period
        sensors = design.parameters.sensors
        self._use = sensors.in_use()
        self.corrections: dict[str, Correction] = {}
        self.observed: list[Observed] = []
        self._watched = {
            name: sensor for name, sensor in sensors.by_name().items() if name in self._use or sensor.is_always_watched
        }
        self.gates = {
            name: SensorGate(name, SensorTiming(sensor.period(self._dt), sensor.age()), health)
            for name, sensor in self._watched.items()
            if name != "encoder"
        }
        self.encoder = EncoderGate(SensorTiming(self._dt, self._dt), health, tick_period=self._dt)
        self.gates["encoder"] = self.encoder.gate
        self._depth_jumps = DepthJumps()
        self._mru_steps = MruSteps()
        self._rows_of = {name: sensor.rows() for name, sensor in self._watched.items()}
        rows = [(sensor, row) for name, sensor in self._use.items() for row in self._rows_of[name]]
        self._sensor_of = {row.name: name for name, found in self._rows_of.items() for row in found}
        self._has_offset = {"mru_heave"}
        self._of_boom_tip = {row.name for sensor, row in rows if sensor.sees == "boom_tip"}
        self._heaves_of_unit = {row.name for _, row in rows if row.output == "unit_heave"}
        self._noise = {
            row.name: SensorNoise(row.sigma, sensor.period(self._dt))
            for sensor, row in rows
            if sensor.zero is not Zero.STATIC_TENSION
        }
        self._zeros: dict[str, float] = {}
        self._first_heave = 0.0
        self.payout: float | None = None
        self.tension = math.nan
        self.mru_rate = 0.0
        self.take_design(design)
        self.depths: list[tuple[float, float]] = []
        self.witnessed: list[Measurement] = []
        self.doubted = ""
        self._unit_heave = 0.0
        self._levels: dict[str, SensorLevel] = {}
        self._quiet: list[Alarm] = []
        self._attitude: tuple[float, float, float] | None = None
        self._shares: deque[tuple[int, Array]] = deque(maxlen=REMEMBERED)

    def take_design(self, design: ControllerDesign) -> None:
        """Refer to the cable of a design from now on."""
        cable = design.cable
        self._static_tension = cable.static_tension
        self.stretch_per_payout = cable.static_tension / (cable.stiffness * design.length)

    @property
    def depth_zero(self) -> float | None:
        """Depth that counts as heave zero [m]; None before the first reading."""
        return self._zeros.get("depth")

    def begin_at(self, payout: float) -> None:
        """Take the unit to have hung on a `payout` [m] that is not 0 when its depth was first read."""
        self.forget_shares()
        self._first_heave = -payout * (1.0 + self.stretch_per_payout)
        for name, zero in self._zeros.items():
            self._zeros[name] = self._zero_from(zero, self._watched[name])

    def remember_share(self, tick: int, mean_state: Array) -> None:
        """Note the state of the mean payout's own motion at `tick`, `mean_state`, shape (n,)."""
        self._shares.append((tick, mean_state))

    def forget_shares(self) -> None:
        """Forget the shares noted so far: the states are counted otherwise from now on."""
        self._shares.clear()

    def doubt(self, sensor: str) -> None:
        """Take the readings of a `sensor` as those of a witness only from now on; empty: of none that is in use."""
        self.doubted = sensor

    def correct(self, corrections: dict[str, Correction]) -> None:
        """Take off what is believed to be wrong with readings, `corrections` by sensor, from now on."""
        self.corrections = corrections

    def trust(self) -> None:
        """Try a frozen encoder and a doubted depth sensor again: an operator asks for it, and any harm is found again.

        A motion reference unit that contradicts all others must agree with them first.
        """
        self.encoder.trust()
        if self.doubted == "depth":
            self.doubt("")

    def _doubt_first(self, sensor: str) -> None:
        """Doubt a `sensor` in use that has jumped: it must agree with all others before it is used again."""
        if sensor in self._use and not self.doubted:
            self.doubt(sensor)

    def observe(
        self,
        tick: int,
        delivered: Measurements,
        estimator: KalmanEstimator,
        expected_rate: float,
        *,
        unit_stands: bool = False,
    ) -> list[Measurement]:
        """Return the readings of a tick for the estimator.

        Parameters
        ----------
        tick : k
        delivered : readings of this tick
        estimator : whose measurement rows say what share of a reading is the mean payout's
        expected_rate : of the drum since the last tick [m/s]
        unit_stands : on the seabed: readings of what rides on the unit say nothing of the hanging cable, and are gated
            but not used
        """
        now = tick * self._dt
        self.depths.clear()
        taken: list[Measurement] = []
        witnessed: list[Measurement] = []
        for mru in delivered.mru:
            if "mru" in self._use and judge_mru(self.gates["mru"], now, mru, self._mru_steps, self._mru_noise):
                if self._mru_steps.is_unproved:
                    self._doubt_first("mru")
                (taken if self._is_taken("mru") else witnessed).extend(self._mru(mru))
        taken += self._encoder(now, delivered, expected_rate)
        for name in SCALAR_SENSORS:
            if name in self._watched:
                of_unit = self._scalar(now, name, delivered.of(name))
                if not unit_stands:
                    (taken if self._is_taken(name) else witnessed).extend(of_unit)
        for gate in self.gates.values():
            gate.tick(now)
        self.observed = []
        self.witnessed = [self._in_terms(reading, estimator, is_used=False) for reading in witnessed]
        return [self._in_terms(reading, estimator, is_used=True) for reading in taken]

    def _is_taken(self, sensor: str) -> bool:
        """Tell whether the estimator takes what a `sensor` reads."""
        return sensor in self._use and sensor != self.doubted

    def learn(self, estimator: KalmanEstimator, surprise: Surprise) -> None:
        """Take back the samples of which the estimator refused a reading; an MRU's sample holds two.

        Parameters
        ----------
        estimator : that has taken the readings of this tick in
        surprise : by them and those before: what has been foreseen badly for long is no spike
        """
        self._quiet = [
            self._quiet_alarm(name, estimator.measurements[name].sensor, mean)
            for name, mean in surprise.newly_quiet().items()
            if name in self._noise and self._noise[name].believed > NEGLIGIBLE
        ]
        # one that came too late to be compared says nothing against the sensor; `stale` does, when they all are
        refused = [
            name
            for name, innovation in estimator.innovations.items()
            if not innovation.accepted and math.isfinite(innovation.nis)
        ]
        if not refused:
            return
        of_sensors = {estimator.measurements[name].sensor for name in refused}
        spikes = {estimator.measurements[name].sensor for name in refused if not surprise.is_surprised_by(name)}
        for sensor in sorted(of_sensors - {"encoder"}):
            self.gates[sensor].take_back(is_spike=sensor in spikes)

    def _quiet_alarm(self, name: str, sensor: str, mean: float) -> Alarm:
        """Return that a measurement is quieter than its nominal noise.

        Parameters
        ----------
        name : of the measurement
        sensor : that reads it
        mean : of its normalised innovations squared
        """
        noise = self._noise[name]
        return ALARMS.alarm(
            f"{sensor.upper()}_NOISE_LOW",
            measurement=name,
            ratio=math.sqrt(mean),
            sigma=noise.believed,
            seen="none" if noise.seen is None else f"{noise.seen:.2g}",
        )

    def lost(self) -> dict[str, str]:
        """Return why each lost sensor counts as lost, by name; a doubted MRU does: nothing else tells the boom tip."""
        lost = {name: gate.reason for name, gate in self.gates.items() if gate.level is SensorLevel.LOST}
        return {"mru": CONTRADICTS, **lost} if self.doubted == "mru" else lost

    def new_faults(self) -> list[Alarm]:
        """Return which sensors have become worse since the last call, or have another noise than the nominal one."""
        found = []
        for name, gate in self.gates.items():
            before, self._levels[name] = self._levels.get(name, SensorLevel.OK), gate.level
            if gate.level > before:
                found.append(self._fault(name, gate))
        for name, noise in self._noise.items():
            factor = noise.news()
            if factor > 0.0:
                code = f"{self._sensor_of[name].upper()}_NOISE_HIGH"
                found.append(ALARMS.alarm(code, measurement=name, sigma=noise.sigma, factor=factor))
        return [*found, *self._quiet]

    def _fault(self, name: str, gate: SensorGate) -> Alarm:
        """Return what is wrong with the sensor `name` of a `gate`."""
        if gate.reason == "jump" and name == "depth":
            code = "DEPTH_SCALE_JUMP" if self._depth_jumps.is_like_scale else "DEPTH_JUMP"
            return ALARMS.alarm(code, jump=self._depth_jumps.jump)
        if gate.reason == "jump" and name == "encoder":
            return ALARMS.alarm("ENCODER_JUMP", jump=self.encoder.jump)
        return gate.alarm

    def states(self, tick: int) -> tuple[SensorState, ...]:
        """Return how each sensor is seen at `tick`."""
        now = tick * self._dt
        states = [gate.state(now) for gate in self.gates.values()]
        if math.isnan(self.mru_rate):
            states = [one._replace(reason=one.reason or HEAVE_ALONE) if one.sensor == "mru" else one for one in states]
        return tuple([_as_doubted(state) if state.sensor == self.doubted else state for state in states])

    def unit_heave_reading(self, mean_state: Array, unit: int) -> float:
        """Return the newest depth as heave about that of the mean payout [m].

        Parameters
        ----------
        mean_state : state of the mean payout's own motion, shape (n,)
        unit : index of unit_heave in it
        """
        return self._unit_heave - float(mean_state[unit]) * (1.0 + self.stretch_per_payout)

    def _tick_of(self, time: float) -> tuple[int, float]:
        """Return the tick nearest to a `time` [s], and how much later than it that is, in ticks."""
        tick = round(time / self._dt)
        offset = time / self._dt - tick
        return tick, offset if abs(offset) > ON_TICK else 0.0

    @property
    def _mru_noise(self) -> float:
        """Standard deviation of the MRU's heave [m]."""
        return self._noise["mru_heave"].sigma

    @property
    def depth_noise(self) -> float:
        """Standard deviation of the depth sensor [m]; 0 where the estimator does not take it."""
        return max(
            (self._noise[row.name].sigma for row in self._rows_of["depth"] if row.name in self._noise), default=0.0
        )

    def _mru(self, reading: MruReading) -> list[Measurement]:
        tick, offset = self._tick_of(reading.time)
        attitude, self._attitude = self._attitude, (reading.time, reading.roll, reading.pitch)
        level = {LEVER_ARM_X: -reading.pitch, LEVER_ARM_Y: reading.roll}
        sigma = self._noise["mru_heave"].add(reading.heave, reading.heave_sigma)
        taken = [Measurement("mru_heave", reading.heave, tick, sigma, offset, level)]
        if attitude is None or reading.time <= attitude[0]:
            return taken
        elapsed = reading.time - attitude[0]
        turning = {
            LEVER_ARM_X: -(reading.pitch - attitude[2]) / elapsed,
            LEVER_ARM_Y: (reading.roll - attitude[1]) / elapsed,
        }
        self.mru_rate = reading.heave_rate
        if math.isnan(reading.heave_rate):
            return taken
        sigma = self._noise["mru_heave_rate"].add(reading.heave_rate, reading.heave_rate_sigma)
        taken.append(Measurement("mru_heave_rate", reading.heave_rate, tick, sigma, offset, turning))
        return taken

    def _encoder(self, now: float, delivered: Measurements, expected_rate: float) -> list[Measurement]:
        winch = delivered.winch
        self.payout = None
        self.encoder.pass_tick(now, expected_rate)
        if winch is None:
            return []
        reading = ScalarReading(winch.time, winch.encoder_payout)
        is_driven = not winch.brake and winch.fault == WinchFault.NONE
        payout = self.encoder.judge(now, reading, expected_rate, is_driven=is_driven)
        self.payout = payout
        if payout is None or not self._is_taken("encoder"):
            return []
        tick, offset = self._tick_of(winch.time)
        return [Measurement("payout", payout, tick, offset=offset)]

    def _scalar(self, now: float, name: str, readings: tuple[ScalarReading, ...]) -> list[Measurement]:
        """Gate the readings of a sensor and return them in the estimator's terms: about their zero, in its sign."""
        taken = []
        for reading in readings:
            if not judge_scalar(self.gates[name], now, reading):
                continue
            read: float | None = reading.value
            if name == "depth":
                read = self._depth_jumps.take_off(reading.time, reading.value, self.depth_noise)
            if name == "depth" and self._depth_jumps.is_unproved:
                self._doubt_first("depth")
            if read is None:
                self.gates[name].take_back_jump()
                continue
            if name == "load_cell":
                self.tension = read
            sensor = self._watched[name]
            value = sensor.sign * (read - self._zero(name, sensor, read))
            if name == "depth":
                self._unit_heave = value
                self.depths.append((reading.time, -value))
            when, offset = self._tick_of(reading.time)
            taken += [
                Measurement(row.name, value, when, self._sigma(row.name, value), offset) for row in self._rows_of[name]
            ]
        return taken

    def _sigma(self, measurement: str, value: float) -> float | None:
        """Return the standard deviation of a reading's noise; None: as believed, a static tension is not known."""
        noise = self._noise.get(measurement)
        return None if noise is None else noise.add(value)

    def _zero(self, name: str, sensor: SensorModelParameters, value: float) -> float:
        """Return what a reading of `value` counts from."""
        if sensor.zero is Zero.FIRST_READING:
            return self._zeros.setdefault(name, self._zero_from(value, sensor))
        return self._static_tension if sensor.zero is Zero.STATIC_TENSION else 0.0

    def _zero_from(self, first: float, sensor: SensorModelParameters) -> float:
        """Return what the readings of a `sensor` count from, of which this is the `first`."""
        return first - sensor.sign * self._first_heave

    def _in_terms(self, reading: Measurement, estimator: KalmanEstimator, *, is_used: bool) -> Measurement:
        """Return a reading in the estimator's terms, corrected and without the mean payout's share; note it as read."""
        share = self._share_of(reading, estimator)
        as_read = self.encoder.as_read if reading.name == "payout" else reading.value
        self.observed.append(Observed(reading, as_read, share, is_used))
        return self._corrected(reading, share)

    def as_believed(self, observed: Observed) -> Measurement:
        """Return a reading `observed` in the last seconds in the estimator's terms, as it is believed to be now."""
        reading = observed.reading
        if reading.name == "payout":
            reading = reading._replace(value=self.encoder.payout_at(observed.value))
        return self._corrected(reading, observed.share)

    def is_taken(self, reading: Measurement) -> bool:
        """Tell whether the estimator takes what the sensor of a `reading` reads."""
        return self._is_taken(self._sensor_of[reading.name])

    def _corrected(self, reading: Measurement, share: float) -> Measurement:
        correction = self.corrections.get(self._sensor_of[reading.name], AS_READ)
        offset = correction.offset if reading.name in self._has_offset else 0.0
        value = (reading.value - offset) / correction.scale - share
        if correction.delay == 0.0:
            return reading._replace(value=value)
        tick, ahead = self._tick_of((reading.tick + reading.offset) * self._dt - correction.delay)
        return reading._replace(value=value, tick=tick, offset=ahead)

    def _share_of(self, reading: Measurement, estimator: KalmanEstimator) -> float:
        """Return the mean payout's share in a reading, at its time."""
        if not self._shares or reading.name in self._of_boom_tip:
            return 0.0
        newest, state = self._shares[-1]
        if newest > reading.tick:
            noted = (share for tick, share in reversed(self._shares) if tick <= reading.tick)
            state = next(noted, self._shares[0][1])
        share = float(estimator.row_of(reading) @ state)
        if reading.name in self._heaves_of_unit:
            share -= self.stretch_per_payout * float(estimator.model.row("payout") @ state)
        return share


def _as_doubted(state: SensorState) -> SensorState:
    """Return the `state` of a sensor that is doubted."""
    alarm = state.alarm or ALARMS.alarm(f"{state.sensor.upper()}_EXCLUDED")
    level, reason = max(state.level, SensorLevel.SUSPECT), state.reason or CONTRADICTS
    return state._replace(level=level, reason=reason, alarm=alarm)
