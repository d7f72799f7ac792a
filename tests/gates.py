"""Parts of the core's gates by themselves, for their tests: a sensor, a measurement, a mean, on a state of its own."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from heave_core.library import fill, library, new
from heave_core.sense_table import SENSE_DESIGN, SENSE_STATE, News, Reason
from winch_controller_node.core.estimation.loop_tick import TensionMean
from winch_controller_node.core.estimation.observation import EncoderGate as EncoderView
from winch_controller_node.core.estimation.sense_design import (
    FILTER_SHARE,
    INDEX,
    LONGEST_PERIOD,
    ROWS,
    SENSOR,
    WATCHES,
    SensorsWatched,
    sense_design,
)
from winch_controller_node.core.estimation.sensor_health import REASONS, inconsistency_words
from winch_controller_node.core.estimation.sensor_health import SensorGate as GateView
from winch_controller_node.design.design import design_controller
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.laws import HealthParameters

CODES = {words: int(code) for code, words in REASONS.items()}


class SensorTiming(NamedTuple):
    """Period [s] and usual latency [s] of a sensor."""

    period: float
    latency: float = 0.0


_DESIGNED = {}


class Part:
    """A part of what is sensed, at ticks of `tick_period` [s], under `health`."""

    def __init__(self, tick_period=0.05, health=None):
        health = health or HealthParameters()
        key = (tick_period, health)
        if key not in _DESIGNED:
            parameters = WinchControllerParameters(health=health)
            design = design_controller(parameters, tick_period=tick_period)
            sensors = SensorsWatched.of(parameters.sensors)
            _DESIGNED[key] = sense_design(design, sensors, design.make_estimator(), {})
        self.core, self.design, self.memory = library(), new(SENSE_DESIGN), new(SENSE_STATE)
        fill(self.design[0], _DESIGNED[key])
        self.health, self.at = health, (self.design.ctypes.data, self.memory.ctypes.data)
        self.begin()

    def begin(self):
        self.core.heave_core_sense_begin(*self.at)


class SensorGate(Part, GateView):
    """The gate of a `sensor` with its own `timing`."""

    def __init__(self, sensor, timing, health):
        Part.__init__(self, health=health)
        self.place = SENSOR[sensor]
        assumed = self.design[0]["sensors"][self.place]
        assumed["period"], assumed["latency"] = timing.period, timing.latency
        assumed["longest_period"] = max(timing.period, LONGEST_PERIOD)
        self.begin()
        GateView.__init__(self, sensor, self.memory[0]["gates"][self.place], assumed, health)

    def judge(self, now, time, values, status="", part=()):
        """`part` is the first two of `values`, as an MRU has it."""
        given = np.array(values, dtype=float)
        return bool(
            self.core.heave_core_gate(*self.at, self.place, now, time, given.ctypes.data, len(given), CODES[status])
        )

    def take_back(self, *, is_spike):
        self.core.heave_core_gate_take_back(*self.at, self.place, Reason.SPIKE, is_spike)

    def take_back_jump(self):
        self.core.heave_core_gate_take_back(*self.at, self.place, Reason.JUMP, True)

    def tick(self, now):
        self.core.heave_core_gate_tick(*self.at, self.place, now)

    def is_newly_slow(self):
        return bool(self.core.heave_core_gate_is_slow(*self.at, self.place))

    @property
    def interval(self):
        return float(self._record["interval"]["value"])


def delivered(reading):
    """Return an MRU's reading as the core is given it."""
    row = (SENSOR["mru"], reading.time, reading.heave, reading.heave_rate, reading.roll, reading.pitch, reading.status)
    return np.array([*row, math.nan, math.nan])


def judge_mru(gate, now, reading, steps=None, noise=None):
    """Return whether a `gate` of an MRU lets a reading through."""
    return bool(gate.core.heave_core_mru(*gate.at, now, delivered(reading).ctypes.data))


class MruSteps(Part):
    """Steps in the heave of an MRU."""

    @property
    def is_unproved(self):
        return bool(self.memory[0]["mru"]["is_unproved"])

    def restart(self):
        self.core.heave_core_restart_steps(self.at[1])

    def is_off(self, reading, noise):
        return bool(self.core.heave_core_mru_is_off(*self.at, delivered(reading).ctypes.data, noise))


class DepthJumps(Part):
    """Jumps of a depth sensor."""

    def take_off(self, time, depth, noise=0.0):
        """Return the depth without jumps [m]; None: it has just jumped."""
        found = self.core.heave_core_depth(*self.at, time, depth, noise)
        return None if math.isnan(found) else found

    @property
    def offset(self):
        return float(self.memory[0]["jumps"]["offset"])

    @property
    def is_unproved(self):
        return bool(self.memory[0]["jumps"]["is_unproved"])


class EncoderGate(Part, EncoderView):
    """The gate of the drum encoder."""

    def __init__(self, timing, health, *, tick_period):
        Part.__init__(self, tick_period, health)
        EncoderView.__init__(self, self.memory)
        place = SENSOR["encoder"]
        assumed = self.design[0]["sensors"][place]
        self.gate = GateView("encoder", self.memory[0]["gates"][place], assumed, health)
        self.gate.tick = lambda now: self.core.heave_core_gate_tick(*self.at, place, now)

    def pass_tick(self, now, expected_rate):
        self.core.heave_core_encoder_pass(*self.at, now, expected_rate)

    def judge(self, now, reading, expected_rate, *, is_driven=True):
        """Return the payout without jumps [m]; None: it may not be used."""
        found = self.core.heave_core_encoder(*self.at, now, *reading, expected_rate, is_driven)
        return None if math.isnan(found) else found

    @property
    def play(self):
        return float(self._record["play"])


class SensorNoise(Part):
    """Noise of a measurement, `nominal` in its unit, of a sensor with a `period` [s]."""

    def __init__(self, nominal, period):
        super().__init__()
        self.row, self.nominal = INDEX["unit_heave"], nominal
        measured = self.design[0]["measured"][self.row]
        measured["nominal"], measured["is_judged"] = nominal, period <= LONGEST_PERIOD
        self.begin()

    def add(self, value, stated=math.nan):
        return self.core.heave_core_noise(*self.at, self.row, value, stated)

    def news(self):
        """Return the ratio to the nominal noise when it has become much larger; else 0."""
        self.core.heave_core_noise_is_worse(*self.at, self.row)
        return float(self.memory[0]["noises"][self.row]["factor"])


class Consistency(Part):
    """Consistency of the readings with their predictions."""

    def add(self, innovations):
        """Take in the innovations of a tick, by measurement."""
        nis = np.full(len(self.memory[0]["noises"]), math.nan)
        for name, innovation in innovations.items():
            nis[INDEX[name]] = innovation.nis
        self.bits = self.core.heave_core_consistency(*self.at, nis.ctypes.data)

    def restart(self):
        self.core.heave_core_restart_consistency(self.at[1])

    def is_inconsistent(self, name):
        return bool(self.memory[0]["noises"]["mean"][INDEX[name]] > WATCHES["inconsistent"])

    def newly_quiet(self):
        """Return the measurements that have been reported as quiet in this tick, with their means."""
        noises = self.memory[0]["noises"]
        return {name: float(noises["mean"][place]) for place, name in enumerate(ROWS) if noises["news"][place]}

    @property
    def time(self):
        return float(self.memory[0]["disagree_time"])

    @property
    def worst(self):
        means = self.memory[0]["noises"]["mean"][: len(ROWS)]
        return ROWS[int(np.argmax(means))], float(np.max(means))

    @property
    def words(self):
        return inconsistency_words(*self.worst) if self.time else ""

    def news(self):
        """Return the alarm of readings that nothing explains, once."""
        (name, mean) = self.worst
        is_new = self.bits & News.UNEXPLAINED
        ratio = math.sqrt(mean)
        return [ALARMS.alarm("SENSORS_DISAGREE", measurement=name, ratio=ratio, time=self.time)] if is_new else []


class MeanTension(Part):
    """Mean tension of one situation."""

    def __init__(self, *, tick_period):
        super().__init__(tick_period)

    def add(self, tension, mean_payout, *, unit_stands):
        self.core.heave_core_tension(*self.at, tension, mean_payout, unit_stands)

    def restart(self):
        self.core.heave_core_restart_tension(self.at[1])

    @property
    def mean(self):
        mean = self.memory[0]["mean_tension"]
        dt = float(self.design["tick_period"][0])
        return TensionMean(float(mean["value"]), math.sqrt(mean["variance"]), float(mean["count"]) * dt)


class TensionFilter(MeanTension):
    """Low-pass of the load cell that serves a loop of a time constant [s]."""

    def __init__(self, loop_time_constant, *, tick_period):
        super().__init__(tick_period=tick_period)
        self.design[0]["watches"]["tension_share"] = tick_period / (FILTER_SHARE * loop_time_constant + tick_period)

    def add(self, tension):
        super().add(tension, 0.0, unit_stands=False)

    @property
    def value(self):
        return float(self.memory[0]["mean_tension"]["filtered"])
