"""Parameters of the sensors on the unit and the cable."""

from __future__ import annotations

from dataclasses import dataclass

from heave_node.parameters import group, parameter

from cable_sim_node.sensors.fault_parameters import SENSOR_FAULT_KINDS, FaultParameters


@dataclass(frozen=True)
class SensorParameters:
    """What every sensor has: when it measures, when its readings arrive, and its scheduled faults.

    Samples are taken at ticks: the first one at or after each whole multiple of 1/rate. A rate above the tick rate
    gives one sample a tick.
    """

    fitted: bool = parameter(
        True, unit="", description="Whether the unit has this sensor; of others nothing is published."
    )
    rate: float = parameter(10.0, unit="Hz", minimum=1e-3, maximum=10_000.0, description="Samples per second.")
    latency: float = parameter(
        0.0, unit="s", minimum=0.0, maximum=600.0, description="From the measurement (its stamp) to its delivery."
    )
    scale_error: float = parameter(
        0.0, unit="", minimum=-1.0, maximum=1.0, description="Relative error of the scale: 0.05 reads 5 % too much."
    )
    faults: FaultParameters = group(FaultParameters)

    def __post_init__(self) -> None:
        """Refuse faults a sensor cannot have."""
        self.faults.require_kinds(SENSOR_FAULT_KINDS, "sensor")


@dataclass(frozen=True)
class DepthSensorParameters(SensorParameters):
    """Pressure sensor of the unit. The pressure is that of still water above it: waves do not reach the unit."""

    latency: float = parameter(
        0.1, unit="s", minimum=0.0, maximum=600.0, description="From the measurement (its stamp) to its delivery."
    )
    noise: float = parameter(
        0.02, unit="m", minimum=0.0, maximum=100.0, description="Standard deviation of white noise, in depth."
    )
    bias: float = parameter(0.0, unit="m", minimum=-1000.0, maximum=1000.0, description="Constant error, in depth.")


@dataclass(frozen=True)
class VelocitySensorParameters(SensorParameters):
    """Doppler velocity log (DVL): velocity over ground of the unit."""

    rate: float = parameter(5.0, unit="Hz", minimum=1e-3, maximum=10_000.0, description="Samples per second.")
    latency: float = parameter(
        0.1, unit="s", minimum=0.0, maximum=600.0, description="From the measurement (its stamp) to its delivery."
    )
    noise: float = parameter(
        0.01, unit="m/s", minimum=0.0, maximum=100.0, description="Standard deviation of white noise on each axis."
    )
    bias: float = parameter(0.0, unit="m/s", minimum=-100.0, maximum=100.0, description="Constant error on each axis.")
    bottom_range: float = parameter(
        0.0,
        unit="m",
        minimum=0.0,
        maximum=20_000.0,
        description="Largest height above the seabed at which there is bottom lock; 0 means lock everywhere.",
    )


@dataclass(frozen=True)
class ImuParameters(SensorParameters):
    """Inertial measurement unit of the unit: specific force, world axes (the unit does not turn)."""

    rate: float = parameter(20.0, unit="Hz", minimum=1e-3, maximum=10_000.0, description="Samples per second.")
    noise: float = parameter(
        0.005, unit="m/s^2", minimum=0.0, maximum=100.0, description="Standard deviation of white noise on each axis."
    )
    bias: float = parameter(
        0.0, unit="m/s^2", minimum=-100.0, maximum=100.0, description="Constant error on each axis."
    )
    gyro_noise: float = parameter(
        0.0005, unit="rad/s", minimum=0.0, maximum=10.0, description="Standard deviation of the turn-rate noise."
    )


@dataclass(frozen=True)
class UsblParameters(SensorParameters):
    """Acoustic position (USBL) of the unit, from a transceiver below the mean boom tip.

    The noise grows with the slant range, and the reading comes later by the two-way travel of sound.
    """

    rate: float = parameter(0.5, unit="Hz", minimum=1e-3, maximum=10_000.0, description="Samples per second.")
    latency: float = parameter(
        0.3,
        unit="s",
        minimum=0.0,
        maximum=600.0,
        description="Processing, from the arrival of the answer to the delivery of the reading.",
    )
    noise: float = parameter(
        0.1, unit="m", minimum=0.0, maximum=1000.0, description="Standard deviation on each axis at zero range."
    )
    range_noise: float = parameter(
        0.003, unit="", minimum=0.0, maximum=1.0, description="Standard deviation on each axis per slant range."
    )
    bias: float = parameter(0.0, unit="m", minimum=-1000.0, maximum=1000.0, description="Constant error on each axis.")
    sound_speed: float = parameter(1500.0, unit="m/s", minimum=100.0, maximum=10_000.0, description="Speed of sound.")


@dataclass(frozen=True)
class LoadCellParameters(SensorParameters):
    """Load cell at the boom tip: top tension."""

    rate: float = parameter(20.0, unit="Hz", minimum=1e-3, maximum=10_000.0, description="Samples per second.")
    relative_noise: float = parameter(
        0.005,
        unit="",
        minimum=0.0,
        maximum=1.0,
        description="Standard deviation of white noise, of the static tension at the start.",
    )
    bias: float = parameter(0.0, unit="N", minimum=-1e9, maximum=1e9, description="Constant error.")


@dataclass(frozen=True)
class SensorsParameters:
    """All sensors on the unit and the cable; their defaults are those of the benchmark scenarios, which have depth
    sensor and load cell alone.
    """

    depth: DepthSensorParameters = group(DepthSensorParameters)
    velocity: VelocitySensorParameters = group(VelocitySensorParameters)
    imu: ImuParameters = group(ImuParameters)
    usbl: UsblParameters = group(UsblParameters)
    load_cell: LoadCellParameters = group(LoadCellParameters)
