"""The sensors on the unit and the cable: the parameters of each, and its view of the truth.

To add one, write a class here and name it in `SensorsParameters`; its name is that of the table
`heave_node.interface.sensors`.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.parameters import group, parameter
from heave_node.sensing.view import SensorParameters, View


class SensorTruth(NamedTuple):
    """What the sensors look at."""

    position: Array  # of the unit, shape (3,), frame `world` [m]
    velocity: Array  # of the unit [m/s]
    acceleration: Array  # of the unit [m/s^2]
    # of the rope on the drum's side of its sheaves; the top tension where they have no friction [N]
    drum_tension: float
    static_top_tension: float  # at rest at the start [N]
    gravity: float  # [m/s^2]


@dataclass(frozen=True)
class DepthSensorParameters(SensorParameters):
    """Pressure sensor of the unit. The pressure is that of still water above it: waves do not reach the unit."""

    latency: float = parameter(0.1, "s", 0.0, 5.0, "Delay from time stamp to delivery.")
    noise: float = parameter(0.02, "m", 0.0, 100.0, "Standard deviation of white noise, in depth.")
    bias: float = parameter(0.0, "m", -1000.0, 1000.0, "Constant error, in depth.")
    resolution: float = parameter(0.0, "m", 0.0, 10.0, "Resolution, in depth; 0: none.")

    def view(self, truth: SensorTruth) -> View:
        """See the depth, positive down from still water [m]."""
        return View(-truth.position[2:], self.noise, self.bias, resolution=(self.resolution,))


@dataclass(frozen=True)
class VelocitySensorParameters(SensorParameters):
    """Doppler velocity log (DVL): velocity over ground of the unit."""

    rate: float = parameter(5.0, "Hz", 0.01, 1000.0, "Samples per second.")
    latency: float = parameter(0.1, "s", 0.0, 5.0, "Delay from time stamp to delivery.")
    noise: float = parameter(0.01, "m/s", 0.0, 100.0, "Standard deviation of white noise on each axis.")

    def view(self, truth: SensorTruth) -> View:
        """See the velocity over ground x, y, z [m/s]."""
        return View(truth.velocity, self.noise)


@dataclass(frozen=True)
class ImuParameters(SensorParameters):
    """Inertial measurement unit of the unit: specific force, world axes (the unit does not turn)."""

    rate: float = parameter(20.0, "Hz", 0.01, 1000.0, "Samples per second.")
    noise: float = parameter(0.005, "m/s^2", 0.0, 100.0, "Standard deviation of white noise on each axis.")
    gyro_noise: float = 0.0005  # standard deviation of the turn-rate noise [rad/s]

    def view(self, truth: SensorTruth) -> View:
        """See acceleration less gravity x, y, z [m/s^2] and the turn rate of a unit that does not turn [rad/s]."""
        x, y, z = truth.acceleration
        return View(
            np.array([x, y, z + truth.gravity, 0.0, 0.0, 0.0]),
            np.array([self.noise] * 3 + [self.gyro_noise] * 3),
        )


@dataclass(frozen=True)
class UsblParameters(SensorParameters):
    """Acoustic position (USBL) of the unit, from a transceiver below the mean boom tip.

    The noise grows with the slant range, and the reading comes later by the two-way travel of sound.
    """

    rate: float = parameter(0.5, "Hz", 0.01, 1000.0, "Samples per second.")
    latency: float = parameter(0.3, "s", 0.0, 600.0,
        "Processing time, from the arrival of the reply to the delivery of the reading.")  # fmt: skip
    noise: float = parameter(0.1, "m", 0.0, 1000.0, "Standard deviation on each axis at zero range.")
    range_noise: float = 0.003  # standard deviation on each axis per slant range [-]
    sound_speed: float = 1500.0  # speed of sound [m/s]

    def view(self, truth: SensorTruth) -> View:
        """See the position x, y, z [m], later by the way of the sound."""
        slant_range = float(np.linalg.norm(truth.position))
        sigma = math.hypot(self.noise, self.range_noise * slant_range)
        return View(truth.position, sigma, extra_latency=2.0 * slant_range / self.sound_speed)


@dataclass(frozen=True)
class LoadCellParameters(SensorParameters):
    """Load cell between drum and boom tip: top tension, less or more what `rope_path.friction` takes."""

    rate: float = parameter(20.0, "Hz", 0.01, 1000.0, "Samples per second.")
    noise: float = parameter(0.005, "", 0.0, 1.0,
        "Standard deviation of white noise, as a fraction of the static tension at the start.")  # fmt: skip

    def view(self, truth: SensorTruth) -> View:
        """See the tension on the drum's side [N]."""
        return View(np.array([truth.drum_tension]), self.noise * truth.static_top_tension)


@dataclass(frozen=True)
class SensorsParameters:
    """All sensors on the unit and the cable, with the defaults of the benchmark scenarios; those fit the depth sensor
    and the load cell alone.
    """

    depth: DepthSensorParameters = group(DepthSensorParameters)
    velocity: VelocitySensorParameters = group(VelocitySensorParameters)
    imu: ImuParameters = group(ImuParameters)
    usbl: UsblParameters = group(UsblParameters)
    load_cell: LoadCellParameters = group(LoadCellParameters)

    def __post_init__(self) -> None:
        """Refuse faults that a sensor cannot have."""
        for name, parameters in self.by_name().items():
            parameters.faults.check(f"sensors.{name}.faults", "sensor")

    def by_name(self) -> dict[str, SensorParameters]:
        """Return the parameters of each sensor, in the order of the table."""
        return {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}
