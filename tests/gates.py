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

from tests.core_parts import COUNT, FLAG, NUMBER, part

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


def gate_at(gates, place):
    """Return tolerances, sensor and gate of the sensor at a `place`."""
    row = slice(place, place + 1)
    return gates.design["health"], gates.design["sensors"][0, row], gates.memory["gates"][0, row]


def take_back(gate, reason, is_news):
    """Take the last reading of a `gate` back for a `reason`."""
    part("take_back")(gate[0], gate[2], reason, is_news)


class SensorGate(Part, GateView):
    """The gate of a `sensor` with its own `timing`."""

    def __init__(self, sensor, timing, health):
        Part.__init__(self, health=health)
        self.place = SENSOR[sensor]
        assumed = self.design[0]["sensors"][self.place]
        assumed["period"], assumed["latency"] = timing.period, timing.latency
        assumed["longest_period"] = max(timing.period, LONGEST_PERIOD)
        self.begin()
        self.gate_at = gate_at(self, self.place)
        GateView.__init__(self, sensor, self.memory[0]["gates"][self.place], assumed, health)

    def judge(self, now, time, values, status=""):
        """Return whether a reading is let through."""
        given = np.array(values, dtype=float)
        return part("judge", result=FLAG)(*self.gate_at, now, time, given, len(given), CODES[status])

    def take_back(self, *, is_spike):
        take_back(self.gate_at, Reason.SPIKE, is_spike)

    def take_back_jump(self):
        take_back(self.gate_at, Reason.JUMP, True)

    def tick(self, now):
        part("tick_gate")(*self.gate_at, now)

    def is_newly_slow(self):
        return part("is_slow", result=FLAG)(self.gate_at[0], self.gate_at[2]["interval"])

    @property
    def interval(self):
        return float(self._record["interval"]["value"])


def delivered(reading):
    """Return an MRU's reading as the core is given it."""
    row = (SENSOR["mru"], reading.time, reading.heave, reading.heave_rate, reading.roll, reading.pitch, reading.status)
    return np.array([*row, math.nan, math.nan])


def judge_mru(gate, now, reading, steps=None, noise=None):
    """Return whether a `gate` of an MRU lets a reading through."""
    return part("admits_mru", result=FLAG)(gate.design, gate.memory, now, delivered(reading))


class MruSteps(Part):
    """Steps in the heave of an MRU."""

    @property
    def is_unproved(self):
        return bool(self.memory[0]["mru"]["is_unproved"])

    def restart(self):
        self.core.heave_core_restart_steps(self.at[1])

    def is_off(self, reading, noise):
        return part("is_off", result=FLAG)(self.design["steps"], self.memory["mru"], delivered(reading), noise)


class DepthJumps(Part):
    """Jumps of a depth sensor."""

    def take_off(self, time, depth, noise=0.0):
        """Return the depth without jumps [m]; None: it has just jumped."""
        found = part("take_off", result=NUMBER)(self.design["steps"], self.memory["jumps"], time, depth, noise)
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
        self.gate_at = gate_at(self, place)
        self.gate.tick = lambda now: part("tick_gate")(*self.gate_at, now)

    def pass_tick(self, now, expected_rate):
        travel = expected_rate * float(self.design["tick_period"][0])
        part("pass_tick")(self.design["steps"], self.memory["encoder"], now, travel)

    def judge(self, now, reading, expected_rate, *, sent_rate=None, is_driven=True):
        """Return the payout without jumps [m]; None: it may not be used."""
        sent_rate = expected_rate if sent_rate is None else sent_rate
        judge, given = part("judge_encoder", result=NUMBER), (now, *reading, expected_rate, sent_rate, is_driven)
        found = judge(self.design, self.gate_at[2], self.memory["encoder"], *given)
        return None if math.isnan(found) else found

    def resume(self, payout):
        part("resume")(self.memory["encoder"], payout)

    @property
    def jumped_at(self):
        return float(self._record["jumped_at"])

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
        row = slice(self.row, self.row + 1)
        self.noise_at = self.design["health"], self.design["measured"][0, row], self.memory["noises"][0, row]

    def add(self, value, stated=math.nan):
        return part("add_noise", result=NUMBER)(*self.noise_at, value, stated)

    def stands_out(self, innovation):
        return part("stands_out", result=FLAG)(*self.noise_at[1:], innovation)

    def news(self):
        """Return the ratio to the nominal noise when it has become much larger; else 0."""
        part("has_worse_noise", result=FLAG)(*self.noise_at)
        return float(self.memory[0]["noises"][self.row]["factor"])


class Consistency(Part):
    """Consistency of the readings with their predictions."""

    def add(self, innovations):
        """Take in the innovations of a tick, by measurement."""
        nis = np.full(len(self.memory[0]["noises"]), math.nan)
        for name, innovation in innovations.items():
            nis[INDEX[name]] = innovation.nis
        watches, dt = self.design["watches"], float(self.design["tick_period"][0])
        for row in np.flatnonzero(self.design["measured"][0]["is_compared"]):
            part("add_innovation")(watches, dt, self.memory["noises"][0, row : row + 1], nis[row])
        self.bits = part("watch_consistency", result=COUNT)(self.design, self.memory)

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
        watches, mean = self.design["watches"], self.memory["mean_tension"]
        part("filter_tension")(watches, mean, tension)
        dt = float(self.design["tick_period"][0])
        part("add_tension")(watches, dt, mean, tension, mean_payout, unit_stands)

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
