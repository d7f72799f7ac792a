"""The gates in front of the estimator, and what they have found, in words; the gates themselves are in C++.

From what was delivered to what the estimator takes: gates, signs, means, and the mean payout's share taken off, see
sense.cpp.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from heave_core.library import fill, library, new
from heave_core.sense_table import SENSE_DESIGN, SENSE_STATE, News
from heave_node.interface.alarm import Alarm
from heave_node.interface.codes import SensorLevel
from heave_node.numerics.arrays import Array

from winch_controller_node.beliefs.beliefs import Correction
from winch_controller_node.core.estimation.sense_design import (
    INDEX,
    ROWS,
    SENSOR,
    SensorsWatched,
    sense_design,
    tick_of,
)
from winch_controller_node.core.estimation.sensor_health import (
    CONTRADICTS,
    SensorGate,
    doubtful_alarm,
    inconsistency_words,
)
from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.interface.readings import SensorState
from winch_controller_node.interface.sensors import KNOWN_SENSORS, MEASURED_WORDS, MeasurementRow
from winch_controller_node.model.estimator import KalmanEstimator, Measurement

ALONE = ("mru", "load_cell")
"""Sensors that no other stands in for: one that is excluded is lost."""

HEAVE_ALONE = "heave alone: it measures no rate"
"""State of an MRU that has no fault and reports no heave rate, in words."""


class EncoderGate:
    """The drum encoder as its gate in the core has it: the jumps that are taken off it, and its scale.

    `state` : array of one SenseState of the core
    """

    def __init__(self, state: Any) -> None:
        self._record, self._address = state[0]["encoder"], state.ctypes.data

    @property
    def scale(self) -> float:
        """A reading over this, less the offset, is the payout; 1 until it is known to be another."""
        return float(self._record["scale"])

    @property
    def offset(self) -> float:
        """Sum of the jumps found so far [m]."""
        return float(self._record["offset"])

    @property
    def jump(self) -> float:
        """The last one [m]."""
        return float(self._record["jump"])

    @property
    def as_read(self) -> float:
        """Payout as the encoder reads it, jumps taken off, whatever its assumed scale [m]."""
        return float(self._record["as_read"])

    def payout_at(self, as_read: float) -> float:
        """Return the payout at which it has read `as_read`, as its scale is now [m]."""
        return float(self._record["last_payout"]) + (as_read - self.as_read) / self.scale

    def rescale(self, factor: float, payout: float) -> None:
        """Take the encoder to read `factor` times as much as it was taken to until now, and the last to be `payout`."""
        library().heave_core_rescale_encoder(self._address, factor, payout)

    def trust(self) -> None:
        """Take a frozen encoder for good until the drum turns unseen again: an operator asks for it to be tried."""
        library().heave_core_trust_encoder(self._address)


class Observer:
    """How the sensors are seen.

    Parameters
    ----------
    design : its measurements and their rates, and tolerances of the gates
    estimator : that takes the readings

    Attributes
    ----------
    state : structured array of one element, on the memory that C++ reads and writes, as `design` is
    addresses : of the two
    gates : by sensor
    encoder : of the drum
    """

    def __init__(self, design: ControllerDesign, estimator: KalmanEstimator) -> None:
        self._dt = design.tick_period
        parameters = design.parameters
        self._sensors = SensorsWatched.of(parameters.sensors)
        self._corrections: Mapping[str, Correction] = {}
        self.design, self.state = new(SENSE_DESIGN), new(SENSE_STATE)
        self._gates, self._noises = self.state[0]["gates"], self.state[0]["noises"]
        self.take_design(design, estimator)
        self.addresses = self.design.ctypes.data, self.state.ctypes.data
        library().heave_core_sense_begin(*self.addresses)
        names = [*(name for name in self._sensors.watched if name != "encoder"), "encoder"]
        self.gates = {name: self._gate(name, SENSOR[name]) for name in names}
        self.encoder = EncoderGate(self.state)

    def _gate(self, name: str, place: int) -> SensorGate:
        return SensorGate(name, self._gates[place], self.design[0]["sensors"][place], self._design.parameters.health)

    def take_design(self, design: ControllerDesign, estimator: KalmanEstimator) -> None:
        """Refer to the cable, winch and sea of a design, and to an `estimator`, from now on."""
        self._design, self._estimator = design, estimator
        fill(self.design[0], sense_design(design, self._sensors, estimator, self._corrections))

    def correct(self, corrections: Mapping[str, Correction]) -> None:
        """Correct readings by `corrections`, by sensor, from now on."""
        self._corrections = corrections
        self.take_design(self._design, self._estimator)

    # sensors that are not used

    @property
    def excluded(self) -> str:
        """Sensor in use that is excluded: it contradicts all others and is a cross-check only; empty: none."""
        place = int(self.state["excluded"][0])
        return "" if place < 0 else KNOWN_SENSORS[place]

    def exclude(self, sensor: str) -> None:
        """Exclude a `sensor` in use: from now on its readings are a cross-check only; empty: exclude none."""
        self.state["excluded"] = SENSOR.get(sensor, -1)

    def trust(self) -> None:
        """Try again what is rejected, at an operator's request; harm is detected again.

        It is an excluded depth sensor, and a motion reference unit that has stepped: what it reads now is its mean. One
        that contradicts all others must agree with them first.
        """
        library().heave_core_restart_steps(self.state.ctypes.data)
        if self.excluded == "depth":
            self.exclude("")

    def use_encoder(self) -> None:
        """Use an encoder again that is set aside."""
        if self.excluded == "encoder":
            self.exclude("")

    def is_taken(self, measurement: int) -> bool:
        """Tell whether the estimator takes what a sensor gives for a `measurement`, by its index."""
        sensor = KNOWN_SENSORS[int(self.design[0]["measured"][measurement]["sensor"])]
        return sensor in self._sensors.in_use and sensor != self.excluded

    # the mean payout's share

    @property
    def stretch_per_payout(self) -> float:
        """How much further than paid out the unit goes down at rest: stretch of the new cable [-]."""
        return float(self.design["stretch_per_payout"][0])

    @property
    def depth_zero(self) -> float | None:
        """Depth that counts as heave zero [m]; None before the first reading."""
        zero = float(self._gates[SENSOR["depth"]]["zero"])
        return None if math.isnan(zero) else zero

    def begin_at(self, payout: float) -> None:
        """Take the unit to have hung on a `payout` [m] that is not 0 when its depth was first read."""
        self.reset_shares()
        heave = -payout * (1.0 + self.stretch_per_payout)
        self.state["first_heave"] = heave
        self._gates["zero"] -= self.design[0]["sensors"]["sign"] * heave

    def reset_shares(self) -> None:
        """Discard the mean payout's shares noted so far: the states are counted otherwise from now on."""
        self.state["shares"] = 0

    def restart_with(self, tick: int, mean_state: Array) -> None:
        """Count from the mean payout's own motion at a `tick`, `mean_state`, shape (n,), from now on."""
        state = self.state[0]
        state["shares"], state["newest_share"], state["share_ticks"][0] = 1, 0, tick
        state["share_states"][0][: len(mean_state)] = mean_state

    def unit_heave_reading(self, mean_state: Array, unit: int) -> float:
        """Return the newest depth as heave about that of the mean payout [m].

        `mean_state` is the mean payout's own motion, shape (n,); `unit` the index of unit_heave in it.
        """
        return float(self.state["unit_heave"][0]) - float(mean_state[unit]) * (1.0 + self.stretch_per_payout)

    def corrected(self, reading: Measurement, share: float) -> Measurement:
        """Return a `reading` about its zero with what is wrong with it and the mean payout's `share` taken off."""
        assumed = self.design[0]["sensors"][int(self.design[0]["measured"][INDEX[reading.name]]["sensor"])]
        offset = float(assumed["offset"]) if INDEX[reading.name] == assumed["measured"] else 0.0
        value, delay = (reading.value - offset) / float(assumed["scale"]) - share, float(assumed["delay"])
        if delay == 0.0:
            return reading._replace(value=value)
        tick, ahead = tick_of((reading.tick + reading.offset) * self._dt - delay, self._dt)
        return reading._replace(value=value, tick=tick, offset=ahead)

    # in words

    def lost(self) -> dict[str, str]:
        """Return why each lost sensor counts as lost, by name; an excluded one does that no other stands in for."""
        lost = {name: gate.reason for name, gate in self.gates.items() if gate.is_lost}
        return {self.excluded: CONTRADICTS, **lost} if self.is_aside else lost

    @property
    def is_aside(self) -> bool:
        """Tell whether a sensor is excluded that no other stands in for."""
        return self.excluded in ALONE

    @property
    def worst(self) -> tuple[str, float]:
        """Measurement that is predicted worst, and the mean of its normalised innovations squared."""
        place = int(np.argmax(self._noises["mean"][: len(ROWS)]))
        return ROWS[place], float(self._noises["mean"][place])

    @property
    def inconsistency(self) -> str:
        """Why the readings are not consistent yet, in words."""
        return inconsistency_words(*self.worst)

    def alarms(self, news: int) -> tuple[Alarm, ...]:
        """Return what is new of the sensors in a tick whose core says that there are `news`."""
        found = []
        for name, gate in self.gates.items():
            of_gate = int(self._gates[SENSOR[name]]["news"])
            if of_gate & News.SENSOR_WORSE:
                found.append(self._fault(name, gate))
            if of_gate & News.SENSOR_SLOW:
                found.append(gate.slow_alarm)
        named = [(INDEX[row.name], name, row) for name, one in self._sensors.in_use.items() for row in one.rows()]
        found += [self._high(sensor, row, place) for place, sensor, row in named if self._noises["factor"][place] > 0.0]
        for place, sensor, row in named:
            of_noise = int(self._noises["news"][place])
            if of_noise & News.ACCURACY_REFUSED:
                found.append(self._refused(sensor, row, place))
            if of_noise & News.NOISE_LOW:
                found.append(self._quiet(sensor, row, place))
        if news & News.UNEXPLAINED:
            (name, mean), time = self.worst, float(self.state["disagree_time"][0])
            found.append(
                ALARMS.alarm("SENSORS_DISAGREE", measurement=MEASURED_WORDS[name], ratio=math.sqrt(mean), time=time)
            )
        return tuple(found)

    def _fault(self, name: str, gate: SensorGate) -> Alarm:
        """Return what is wrong with the sensor `name` of a `gate`; of a single jump what follows from that."""
        if gate.is_lost or gate.reason != "jump":
            return gate.alarm
        if name == "depth":
            jumps = self.state[0]["jumps"]
            jump = float(jumps["jump"])
            if jumps["is_like_scale"]:
                return ALARMS.alarm("SENSOR_LOST, DEPTH: scale jump", jump=jump)
            return doubtful_alarm(name, "jump", jump=jump)
        return doubtful_alarm(name, "jump", jump=self.encoder.jump) if name == "encoder" else gate.alarm

    def _high(self, sensor: str, row: MeasurementRow, place: int) -> Alarm:
        """Return that a measurement, a `row` of a `sensor` at a `place` in the core, is noisier than nominal."""
        noise = self._noises[place]
        sigma, factor = float(noise["sigma"]), float(noise["factor"])
        of = MEASURED_WORDS[row.name]
        return doubtful_alarm(sensor, "noise", measurement=of, sigma=sigma, unit=row.unit, factor=factor)

    def _refused(self, sensor: str, row: MeasurementRow, place: int) -> Alarm:
        """Return that a `sensor` states an accuracy that cannot be, of a `row` at a `place` in the core."""
        return doubtful_alarm(
            sensor,
            "accuracy",
            measurement=MEASURED_WORDS[row.name],
            sigma=float(self._noises[place]["refused"]),
            unit=row.unit,
            limit=row.largest_stated,
        )

    def _quiet(self, sensor: str, row: MeasurementRow, place: int) -> Alarm:
        """Return that a measurement, a `row` of a `sensor` at a `place` in the core, is quieter than nominal."""
        seen, mean = float(self._noises[place]["seen"]), float(self._noises[place]["mean"])
        return ALARMS.alarm(
            f"NOISE_LOW, {sensor.upper()}",
            measurement=MEASURED_WORDS[row.name],
            ratio=math.sqrt(mean),
            sigma=row.sigma,
            unit=row.unit,
            seen="none" if math.isnan(seen) else f"{seen:.2g}",
        )

    def states(self, tick: int) -> tuple[SensorState, ...]:
        """Return how each sensor is seen at `tick`."""
        now = tick * self._dt
        states = [gate.state(now) for gate in self.gates.values()]
        if math.isnan(self.state["mru_rate"][0]):
            states = [one._replace(reason=one.reason or HEAVE_ALONE) if one.sensor == "mru" else one for one in states]
        return tuple([_as_excluded(state) if state.sensor == self.excluded else state for state in states])


def _as_excluded(state: SensorState) -> SensorState:
    """Return the `state` of a sensor that is excluded."""
    alarm = state.alarm or ALARMS.alarm(f"SENSOR_LOST, {state.sensor.upper()}: excluded")
    level, reason = max(state.level, SensorLevel.SUSPECT), state.reason or CONTRADICTS
    return state._replace(level=level, reason=reason, alarm=alarm)
