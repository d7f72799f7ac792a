"""The sensors of the plant: which truth each of them sees."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from heave_node.arrays import Array
from heave_node.constants import STANDARD_GRAVITY

from cable_sim_node.sensors.parameters import SensorsParameters
from cable_sim_node.sensors.sensor import Reading, Sensor


@dataclass(frozen=True)
class SensorTruth:
    """What the sensors look at.

    Attributes
    ----------
    position, velocity, acceleration : of the unit, shape (3,), frame `world` [m], [m/s], [m/s^2]
    top_tension : [N]
    height_above_seabed : of the unit [m]; infinite without a seabed
    """

    position: Array
    velocity: Array
    acceleration: Array
    top_tension: float
    height_above_seabed: float


@dataclass(frozen=True)
class SensorReadings:
    """Readings delivered at one tick, oldest delivery first.

    Values: `depth` [m], positive down from still water; `velocity` x, y, z [m/s]; `imu` specific force x, y, z [m/s^2]
    and turn rate x, y, z [rad/s]; `usbl` position x, y, z [m]; `load_cell` tension [N].
    """

    depth: tuple[Reading, ...] = ()
    velocity: tuple[Reading, ...] = ()
    imu: tuple[Reading, ...] = ()
    usbl: tuple[Reading, ...] = ()
    load_cell: tuple[Reading, ...] = ()


class SensorSuite:
    """All sensors on the unit and the cable.

    Parameters
    ----------
    parameters : of each sensor
    static_top_tension : to which the load cell's noise is relative [N]
    boom_tip_height : of the mean boom tip above still water [m]; the USBL transceiver is at still water below it
    seed, tick_period : of the run; tick_period in [s]

    Attributes
    ----------
    by_name : the sensors that are fitted, by name (depth, velocity, imu, usbl, load_cell)
    """

    def __init__(
        self, parameters: SensorsParameters, *, static_top_tension: float, seed: int, tick_period: float
    ) -> None:
        p = parameters
        self._usbl = p.usbl
        self._bottom_range = p.velocity.bottom_range if p.velocity.bottom_range > 0.0 else math.inf
        imu_sigma = np.array([p.imu.noise] * 3 + [p.imu.gyro_noise] * 3)
        imu_bias = np.array([p.imu.bias] * 3 + [0.0] * 3)
        load_sigma = np.array([p.load_cell.relative_noise * static_top_tension])
        self.by_name = {
            name: Sensor(sensor, name=name, sigma=sigma, bias=bias, seed=seed, tick_period=tick_period)
            for name, sensor, sigma, bias in (
                ("depth", p.depth, np.array([p.depth.noise]), np.array([p.depth.bias])),
                ("velocity", p.velocity, np.full(3, p.velocity.noise), np.full(3, p.velocity.bias)),
                ("imu", p.imu, imu_sigma, imu_bias),
                ("usbl", p.usbl, np.full(3, p.usbl.noise), np.full(3, p.usbl.bias)),
                ("load_cell", p.load_cell, load_sigma, np.array([p.load_cell.bias])),
            )
            if sensor.fitted
        }

        self._looks = {
            "depth": self._depth,
            "velocity": self._velocity,
            "imu": self._imu,
            "usbl": self._usbl_position,
            "load_cell": self._load_cell,
        }

    def step(self, tick: int, truth: SensorTruth) -> SensorReadings:
        """Let every sensor look at the `truth` of t_k, and return what is delivered at t_k."""
        looks = self._looks
        return SensorReadings(**{name: looks[name](sensor, tick, truth) for name, sensor in self.by_name.items()})

    def _depth(self, sensor: Sensor, tick: int, truth: SensorTruth) -> tuple[Reading, ...]:
        return sensor.step(tick, -truth.position[2:])

    def _velocity(self, sensor: Sensor, tick: int, truth: SensorTruth) -> tuple[Reading, ...]:
        return sensor.step(tick, truth.velocity, is_available=truth.height_above_seabed <= self._bottom_range)

    def _imu(self, sensor: Sensor, tick: int, truth: SensorTruth) -> tuple[Reading, ...]:
        return sensor.step(tick, _specific_force_and_turn_rate(truth.acceleration))

    def _usbl_position(self, sensor: Sensor, tick: int, truth: SensorTruth) -> tuple[Reading, ...]:
        slant_range = float(np.linalg.norm(truth.position))
        sigma = np.full(3, math.hypot(self._usbl.noise, self._usbl.range_noise * slant_range))
        travel = 2.0 * slant_range / self._usbl.sound_speed
        return sensor.step(tick, truth.position, sigma=sigma, extra_latency=travel)

    def _load_cell(self, sensor: Sensor, tick: int, truth: SensorTruth) -> tuple[Reading, ...]:
        return sensor.step(tick, np.array([truth.top_tension]))


def _specific_force_and_turn_rate(acceleration: Array) -> Array:
    """Return what an IMU without errors measures on a unit that does not turn: acceleration minus gravity, no rate."""
    return np.array([acceleration[0], acceleration[1], acceleration[2] + STANDARD_GRAVITY, 0.0, 0.0, 0.0])
