"""A problem without a cable model: boom tip, winch, a load on a rope that does not stretch, and the sensors."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from cable_sim_node.sensors.instruments import DepthSensorParameters, SensorTruth
from heave_bags.signals import RunSignals, Signal
from heave_node.numerics.arrays import Array
from heave_node.numerics.constants import STANDARD_GRAVITY
from heave_node.numerics.randomness import random_stream
from heave_node.sensing.sensor import Sensor
from heave_node.sensing.view import SensorParameters, View

from heave_bringup.benchmark.interface import Controller, Measurement, MruReading, Reading, SensorFacts
from heave_bringup.benchmark.outcome import Outcome
from heave_bringup.benchmark.target import TargetProgramme
from heave_bringup.benchmark.worlds.loads import Kinematics, Load
from heave_bringup.benchmark.worlds.motions import Motion
from heave_bringup.benchmark.worlds.winches import Winch

DEPTH_RATE = 10.0
"""Readings of the depth sensor per second, where it is not perfect."""
MEAN_DEPTH = 100.0
"""Depth of the unit about which it moves [m]: only its changes mean anything here."""

COLUMNS = ("unit", "target", "payout", "rate", "acceleration", "tension", "unit_rate", "bottom_force", "limits")


@dataclass(frozen=True)
class RigidProblem:
    """A problem.

    Attributes
    ----------
    sample_time, duration : [s]
    motion : of the boom tip
    make_winch : makes a new winch
    make_load : makes a new load, at the rope's lower end
    sensors : their noise; MRU and load cell are read at every sample time
    make_target : the operator's wish
    speed_limit, acceleration_limit : of the winch, at which time is counted; infinite: none
    seed : of all noise
    """

    sample_time: float
    duration: float
    motion: Motion
    make_winch: Callable[[], Winch]
    make_load: Callable[[Kinematics], Load]
    sensors: SensorFacts
    make_target: Callable[[], TargetProgramme]
    speed_limit: float
    acceleration_limit: float
    seed: int


class RigidWorld:
    """The problem, ready to run once.

    Parameters
    ----------
    problem : its parts
    """

    def __init__(self, problem: RigidProblem) -> None:
        self._p = problem
        self._dt = problem.sample_time
        self._ticks = math.floor(problem.duration / self._dt + 1e-9)
        self._time: Array = self._dt * np.arange(self._ticks + 1, dtype=float)
        self._tip = problem.motion.at(self._time, 2)
        self._sensors = _Sensors(problem.sensors, problem.seed, self._dt)

    def run(self, controller: Controller) -> Outcome:
        """Run to the end under a controller."""
        p, dt = self._p, self._dt
        winch, target = p.make_winch(), p.make_target()
        load = p.make_load(self._rope_end(0, winch))
        rows = np.empty((self._ticks, len(COLUMNS)))
        for tick in range(self._ticks):
            wanted, state, moved = target.at(tick * dt), load.state, winch.motion
            measurement = self._sensors.measure(tick, self._tip[:, tick], state.heave, state.tension)
            command = controller.step(Measurement(tick * dt, *measurement, winch.reading(), wanted))
            rows[tick] = (
                state.heave,
                wanted.payout,
                moved.payout,
                moved.rate,
                moved.acceleration,
                state.tension,
                state.rate,
                state.bottom_force,
                float(moved.limits),
            )
            winch.step(tick, command, state.tension)
            load.step(self._rope_end(tick + 1, winch), dt)
        return self._outcome(rows)

    def _rope_end(self, tick: int, winch: Winch) -> Kinematics:
        tip, rope = self._tip[:, tick], winch.motion
        return Kinematics(float(tip[0]) - rope.payout, float(tip[1]) - rope.rate, float(tip[2]) - rope.acceleration)

    def _outcome(self, rows: Array) -> Outcome:
        column = {name: rows[:, i] for i, name in enumerate(COLUMNS)}
        time = self._time[: self._ticks]

        def signal(values: Array) -> Signal:
            return Signal(time, values)

        tip = self._tip[0, : self._ticks]
        error = column["unit"] + column["target"]
        has_tension = bool(np.any(column["tension"] != 0.0))
        signals = RunSignals(
            unit_heave=signal(error),
            uncompensated_heave=signal(tip),
            boom_tip_heave=signal(tip),
            payout=signal(column["payout"] - column["target"]),
            payout_rate=signal(column["rate"]),
            payout_acceleration=signal(column["acceleration"]),
            tension=signal(column["tension"]) if has_tension else Signal(),
            static_tension=Signal(time[:1], column["tension"][:1]) if has_tension else Signal(),
            limits_hit=signal(column["limits"]),
            speed_limit=self._p.speed_limit,
            acceleration_limit=self._p.acceleration_limit,
        )
        return Outcome(time, signals, error, column["bottom_force"], column["unit_rate"])


Readings = tuple[tuple[MruReading, ...], tuple[Reading, ...], tuple[Reading, ...]]


@dataclass(frozen=True)
class _TipSensor(SensorParameters):
    """Motion reference unit on the boom tip: heave, rate and acceleration with white noise of these sigmas."""

    sigma: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def view(self, truth: SensorTruth) -> View:
        """See the boom tip."""
        return View(np.array([truth.position[2], truth.velocity[2], truth.acceleration[2]]), np.array(self.sigma))


class _Sensors:
    """MRU, depth sensor and load cell; perfect ones read the truth at every sample time."""

    def __init__(self, facts: SensorFacts, seed: int, sample_time: float) -> None:
        self._dt = sample_time
        rate = 1.0 / sample_time
        noise = facts.mru_noise, facts.mru_rate_noise, facts.mru_acceleration_noise
        self._load_cell_noise = facts.load_cell_noise
        self._random = random_stream(seed, "benchmark/load_cell")
        self._mru = self._depth = None
        if any(noise):
            unit = _TipSensor(rate=rate, latency=0.0, sigma=noise)
            self._mru = Sensor(unit, name="mru", node="cable_sim", width=3, seed=seed, tick_period=sample_time)
        if facts.depth_noise or facts.depth_latency:
            gauge = DepthSensorParameters(rate=DEPTH_RATE, latency=facts.depth_latency, noise=facts.depth_noise)
            self._depth = Sensor(gauge, name="depth", node="cable_sim", width=1, seed=seed, tick_period=sample_time)

    def measure(self, tick: int, tip: Array, unit: float, tension: float) -> Readings:
        """Return what MRU, depth sensor and load cell deliver at `tick`."""
        time = tick * self._dt
        if self._mru is None:
            mru: tuple[MruReading, ...] = (_mru_reading(time, tip, tick),)
        else:
            mru = tuple(_mru_reading(r.time, r.value, tick) for r in self._mru.step(tick, _truth(*tip.tolist())))
        depth = MEAN_DEPTH - unit
        if self._depth is None:
            depths: tuple[Reading, ...] = (Reading(time, depth),)
        else:
            depths = tuple(Reading(r.time, float(r.value[0])) for r in self._depth.step(tick, _truth(-depth)))
        if self._load_cell_noise:
            tension += self._load_cell_noise * self._random.standard_normal()
        return mru, depths, (Reading(time, tension),)


def _truth(position: float, speed: float = 0.0, acceleration: float = 0.0) -> SensorTruth:
    """Return what a sensor of vertical motion looks at, positive up."""
    return SensorTruth(
        position=np.array([0.0, 0.0, position]),
        velocity=np.array([0.0, 0.0, speed]),
        acceleration=np.array([0.0, 0.0, acceleration]),
        drum_tension=0.0,
        static_top_tension=0.0,
        height_above_seabed=math.inf,
        gravity=STANDARD_GRAVITY,
    )


def _mru_reading(time: float, values: Array, sequence: int) -> MruReading:
    return MruReading(time, float(values[0]), float(values[1]), float(values[2]), sequence=sequence)
