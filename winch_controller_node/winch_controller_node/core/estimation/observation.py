"""From what was delivered to what the estimator takes: gates, signs, means, and the mean payout's share taken off."""

from __future__ import annotations

import math
from typing import NamedTuple

from heave_node.interface.alarm import Alarm
from heave_node.interface.codes import SensorLevel, WinchFault
from heave_node.interface.sensors import MruReading
from heave_node.numerics.arrays import Array

from winch_controller_node.core.estimation.consistency import Consistency
from winch_controller_node.core.estimation.gates.depth_jumps import DepthJumps
from winch_controller_node.core.estimation.gates.encoder_gate import EncoderGate
from winch_controller_node.core.estimation.mru_steps import MruSteps
from winch_controller_node.core.estimation.reading_terms import ReadingTerms, SensorsWatched, tick_of
from winch_controller_node.core.estimation.sensor_health import CONTRADICTS, SensorGate, judge_mru
from winch_controller_node.core.estimation.sensor_noise import SensorNoise, SensorTiming
from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.interface.readings import Measurements, ScalarReading, SensorState
from winch_controller_node.interface.sensors import (
    LEVER_ARM_X,
    LEVER_ARM_Y,
    SCALAR_SENSORS,
    Zero,
)
from winch_controller_node.model.estimator import KalmanEstimator, Measurement
from winch_controller_node.parameters.laws import HealthParameters

NEGLIGIBLE = 1e-4
"""Nominal noise up to which a sensor is never reported as quieter than nominal, in the sensor's unit."""

HEAVE_ALONE = "heave alone: it measures no rate"
"""State of an MRU that has no fault and reports no heave rate, in words."""


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
    cross_checked : readings of this tick that the estimator does not take, in its terms: a cross-check for the adviser
    excluded : sensor in use that is excluded: it contradicts all others and is a cross-check only; empty: none
    terms : in which the estimator takes readings
    observed : readings of this tick as they were read, before corrections, for the adviser
    count : payout as the encoder counts it in this tick, whether it is used or not; None: none came
    """

    def __init__(self, design: ControllerDesign, health: HealthParameters) -> None:
        self._dt = design.tick_period
        sensors = SensorsWatched.of(design.parameters.sensors)
        self._sensors = sensors
        self.gates = {
            name: SensorGate(name, SensorTiming(sensor.period(self._dt), sensor.age()), health)
            for name, sensor in sensors.watched.items()
            if name != "encoder"
        }
        self.encoder = EncoderGate(SensorTiming(self._dt, self._dt), health, tick_period=self._dt)
        self.gates["encoder"] = self.encoder.gate
        self._depth_jumps = DepthJumps()
        self._mru_steps = MruSteps()
        self._noise = {
            row.name: SensorNoise(row.sigma, sensor.period(self._dt))
            for name, sensor in sensors.in_use.items()
            for row in sensors.rows_of[name]
            if sensor.zero is not Zero.STATIC_TENSION
        }
        self.terms = ReadingTerms(design, sensors)
        self.payout: float | None = None
        self.tension = math.nan
        self.mru_rate = 0.0
        self.depths: list[tuple[float, float]] = []
        self.cross_checked: list[Measurement] = []
        self.observed: list[Observed] = []
        self.count: Measurement | None = None
        self.excluded = ""
        self._unit_heave = 0.0
        self._levels: dict[str, SensorLevel] = {}
        self._quiet: list[Alarm] = []
        self._attitude: tuple[float, float, float] | None = None

    def exclude(self, sensor: str) -> None:
        """Exclude a `sensor` in use: from now on its readings are a cross-check only; empty: exclude none."""
        self.excluded = sensor

    def trust(self) -> None:
        """Try again what is rejected, at an operator's request; harm is detected again.

        It is a frozen encoder, an excluded depth sensor, and a motion reference unit that has stepped: what it reads
        now is its mean. One that contradicts all others must agree with them first.
        """
        self.encoder.trust()
        self._mru_steps.restart()
        if self.excluded == "depth":
            self.exclude("")

    def _exclude_first(self, sensor: str) -> None:
        """Exclude a `sensor` in use that has jumped: it must agree with all others before it is used again."""
        if sensor in self._sensors.in_use and not self.excluded:
            self.exclude(sensor)

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
        cross_checked: list[Measurement] = []
        for mru in delivered.mru:
            if self._admits(mru, now):
                if self._mru_steps.is_unproved:
                    self._exclude_first("mru")
                (taken if self._is_taken("mru") else cross_checked).extend(self._mru(mru))
        taken += self._encoder(now, delivered, expected_rate)
        for name in SCALAR_SENSORS:
            if name in self._sensors.watched:
                of_unit = self._scalar(now, name, delivered.of(name))
                if not unit_stands:
                    (taken if self._is_taken(name) else cross_checked).extend(of_unit)
        for gate in self.gates.values():
            gate.tick(now)
        self.observed = []
        self.cross_checked = [self._in_terms(reading, estimator, is_used=False) for reading in cross_checked]
        return [self._in_terms(reading, estimator, is_used=True) for reading in taken]

    def _admits(self, mru: MruReading, now: float) -> bool:
        """Tell whether the gate of the MRU lets a reading through that is there `now` [s]."""
        return "mru" in self._sensors.in_use and judge_mru(
            self.gates["mru"], now, mru, self._mru_steps, self._noise["mru_heave"].sigma
        )

    def _is_taken(self, sensor: str) -> bool:
        """Tell whether the estimator takes what a `sensor` reads."""
        return sensor in self._sensors.in_use and sensor != self.excluded

    def learn(self, estimator: KalmanEstimator, consistency: Consistency) -> None:
        """Take back the samples of which the estimator refused a reading; an MRU's sample holds two.

        Parameters
        ----------
        estimator : that has taken the readings of this tick in
        consistency : with them and those before: readings that have been inconsistent for long are no spikes
        """
        self._quiet = [
            self._quiet_alarm(name, estimator.measurements[name].sensor, mean)
            for name, mean in consistency.newly_quiet().items()
            if name in self._noise and self._noise[name].nominal > NEGLIGIBLE
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
        spikes = {estimator.measurements[name].sensor for name in refused if not consistency.is_inconsistent(name)}
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
            sigma=noise.nominal,
            unit=self._sensors.row[name].unit,
            seen="none" if noise.seen is None else f"{noise.seen:.2g}",
        )

    def lost(self) -> dict[str, str]:
        """Return why each lost sensor counts as lost, by name; an excluded MRU does: no other measures the boom tip."""
        lost = {name: gate.reason for name, gate in self.gates.items() if gate.level is SensorLevel.LOST}
        return {"mru": CONTRADICTS, **lost} if self.excluded == "mru" else lost

    def new_faults(self) -> list[Alarm]:
        """Return which sensors have become worse since the last call, or have another noise than the nominal one."""
        found = []
        for name, gate in self.gates.items():
            before, self._levels[name] = self._levels.get(name, SensorLevel.OK), gate.level
            if gate.level > before:
                found.append(self._fault(name, gate))
            if gate.interval.news():
                found.append(gate.slow_alarm)
        for name, noise in self._noise.items():
            factor = noise.news()
            if factor > 0.0:
                code = f"{self._sensors.sensor_of[name].upper()}_NOISE_HIGH"
                unit = self._sensors.row[name].unit
                found.append(ALARMS.alarm(code, measurement=name, sigma=noise.sigma, unit=unit, factor=factor))
        return [*found, *self._quiet]

    def _fault(self, name: str, gate: SensorGate) -> Alarm:
        """Return what is wrong with the sensor `name` of a `gate`; of a single jump what follows from that."""
        if gate.is_lost or gate.reason != "jump":
            return gate.alarm
        if name == "depth":
            code = "DEPTH_SCALE_JUMP" if self._depth_jumps.is_like_scale else "DEPTH_JUMP"
            return ALARMS.alarm(code, jump=self._depth_jumps.jump)
        if name == "encoder":
            return ALARMS.alarm("ENCODER_JUMP", jump=self.encoder.jump)
        return gate.alarm

    def states(self, tick: int) -> tuple[SensorState, ...]:
        """Return how each sensor is seen at `tick`."""
        now = tick * self._dt
        states = [gate.state(now) for gate in self.gates.values()]
        if math.isnan(self.mru_rate):
            states = [one._replace(reason=one.reason or HEAVE_ALONE) if one.sensor == "mru" else one for one in states]
        return tuple([_as_excluded(state) if state.sensor == self.excluded else state for state in states])

    def unit_heave_reading(self, mean_state: Array, unit: int) -> float:
        """Return the newest depth as heave about that of the mean payout [m].

        Parameters
        ----------
        mean_state : state of the mean payout's own motion, shape (n,)
        unit : index of unit_heave in it
        """
        return self._unit_heave - float(mean_state[unit]) * (1.0 + self.terms.stretch_per_payout)

    @property
    def depth_noise(self) -> float:
        """Standard deviation of the depth sensor [m]; 0 where the estimator does not take it."""
        return max(
            (self._noise[row.name].sigma for row in self._sensors.rows_of.get("depth", ()) if row.name in self._noise),
            default=0.0,
        )

    def _mru(self, reading: MruReading) -> list[Measurement]:
        tick, offset = tick_of(reading.time, self._dt)
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
        self.payout = self.count = None
        self.encoder.pass_tick(now, expected_rate)
        if winch is None:
            return []
        reading = ScalarReading(winch.time, winch.encoder_payout)
        is_driven = not winch.brake and winch.fault == WinchFault.NONE
        payout = self.encoder.judge(now, reading, expected_rate, is_driven=is_driven)
        self.payout = payout
        if not math.isfinite(winch.time):
            return []
        tick, offset = tick_of(winch.time, self._dt)
        self.count = Measurement("payout", self.encoder.counted(winch.encoder_payout), tick, offset=offset)
        if payout is None or not self._is_taken("encoder"):
            return []
        return [self.count._replace(value=payout)]

    def _scalar(self, now: float, name: str, readings: tuple[ScalarReading, ...]) -> list[Measurement]:
        """Gate the readings of a sensor and return them in the estimator's terms: about their zero, in its sign."""
        taken = []
        for reading in readings:
            if not self.gates[name].judge(now, reading.time, (reading.value,)):
                continue
            read: float | None = reading.value
            if name == "depth":
                read = self._depth_jumps.take_off(reading.time, reading.value, self.depth_noise)
            if name == "depth" and self._depth_jumps.is_unproved:
                self._exclude_first("depth")
            if read is None:
                self.gates[name].take_back_jump()
                continue
            if name == "load_cell":
                self.tension = read
            sensor = self._sensors.watched[name]
            value = sensor.sign * (read - self.terms.zero(name, read))
            if name == "depth":
                self._unit_heave = value
                self.depths.append((reading.time, read))
            when, offset = tick_of(reading.time, self._dt)
            taken += [
                Measurement(row.name, value, when, self._sigma(row.name, value), offset)
                for row in self._sensors.rows_of[name]
            ]
        return taken

    def _sigma(self, measurement: str, value: float) -> float | None:
        """Return the standard deviation of a reading's noise; None: as assumed, a static tension is not known."""
        noise = self._noise.get(measurement)
        return None if noise is None else noise.add(value)

    def _in_terms(self, reading: Measurement, estimator: KalmanEstimator, *, is_used: bool) -> Measurement:
        """Return a reading in the estimator's terms, corrected and without the mean payout's share; note it as read."""
        share = self.terms.share_of(reading, estimator)
        as_read = self.encoder.as_read if reading.name == "payout" else reading.value
        self.observed.append(Observed(reading, as_read, share, is_used))
        return self.terms.corrected(reading, share)

    def as_assumed(self, observed: Observed) -> Measurement:
        """Return a reading `observed` in the last seconds in the estimator's terms, by the corrections assumed now."""
        reading = observed.reading
        if reading.name == "payout":
            reading = reading._replace(value=self.encoder.payout_at(observed.value))
        return self.terms.corrected(reading, observed.share)

    def is_taken(self, reading: Measurement) -> bool:
        """Tell whether the estimator takes what the sensor of a `reading` reads."""
        return self._is_taken(self._sensors.sensor_of[reading.name])


def _as_excluded(state: SensorState) -> SensorState:
    """Return the `state` of a sensor that is excluded."""
    alarm = state.alarm or ALARMS.alarm(f"{state.sensor.upper()}_EXCLUDED")
    level, reason = max(state.level, SensorLevel.SUSPECT), state.reason or CONTRADICTS
    return state._replace(level=level, reason=reason, alarm=alarm)
