"""The sensors as the controller assumes them, and the measurements that the estimator takes of their readings.

To add one, write a class here and name it in `KnownSensors`; its name is that of the table
`heave_node.interface.sensors`, which says what its readings are. Inputs of the node, gates, health, measurements of the
estimator, parameters and predictions follow from here.
"""

from __future__ import annotations

import abc
import dataclasses
import math
from dataclasses import dataclass
from enum import Enum
from typing import ClassVar, NamedTuple

from heave_node.interface.sensors import MRU, SENSORS
from heave_node.parameters import group, parameter

MRU_SCALE = "mru_scale"
MRU_BIAS = "mru_bias"
LEVER_ARM_X, LEVER_ARM_Y = "lever_arm_x", "lever_arm_y"
DEPTH_BIAS = "depth_bias"
LOAD_CELL_BIAS = "load_cell_bias"

CALIBRATION_DRIFT = 1e-5
"""Random walk of the MRU's scale [1/sqrt(s)], 0.1 % in three hours, and of its lever arm [m/sqrt(s)]."""


LARGEST_NOISE = 10.0
"""Largest standard deviation of the noise of a motion, in SI units: as a parameter, and as a sensor may state it."""
LEAST_NOISE = 1e-6
"""Standard deviation that is assumed of a sensor that is stated to have less, in its own unit: a filter needs some."""

MEASURED_WORDS = {
    "mru_heave": "MRU heave",
    "mru_heave_rate": "MRU heave rate",
    "unit_heave": "load depth",
    "payout": "payout",
    "unit_velocity": "load velocity",
    "unit_acceleration": "load acceleration",
    "tension": "hook load",
}
"""What alarms and reasons call the measurements."""


class MeasurementRow(NamedTuple):
    """A scalar that the estimator takes: (1 + scale_state) (output + state), with white noise."""

    name: str  # of the measurement
    output: str  # of the augmented model
    sigma: float  # standard deviation of the noise [unit of the sensor]
    unit: str  # that unit, in words; empty where it is the static tension
    state: str = ""  # slow state of the sensor that adds to the output, where the model has it; empty: none
    scale_state: str = ""  # slow state that is its relative error of scale, where the model has it; empty: none
    is_gated: bool = True  # False: never refused for being far off its prediction
    largest_stated: float = LARGEST_NOISE  # largest standard deviation that the sensor may state, in its unit


@dataclass(frozen=True)
class SlowState:
    """An error of a sensor that the estimator follows."""

    name: str  # of the state
    drift: float  # its random walk [unit of the sensor over sqrt(s)]
    sigma: float  # standard deviation at the start [unit of the sensor]


class Zero(Enum):
    """What a reading counts from."""

    OWN = "own"
    """The unit is the reading's own."""
    FIRST_READING = "first_reading"
    """The first reading is zero, as the mean depth is not known."""
    STATIC_TENSION = "static_tension"
    """The static tension of the assumed cable, which is also the unit of noise and slow states."""


@dataclass(frozen=True)
class SensorModelParameters(abc.ABC):
    """Assumed properties of a sensor: a class of its own for each."""

    sees: ClassVar[str]  # what it measures: boom_tip, unit, cable or drum
    component: ClassVar[int] = 0  # which value of a reading counts
    includes_gravity: ClassVar[bool] = False  # at rest that value is the acceleration of gravity
    zero: ClassVar[Zero] = Zero.OWN  # what it counts from
    sign: ClassVar[float] = 1.0  # of the value in the model over that of the reading
    is_always_watched: ClassVar[bool] = False  # it has a gate also where the estimator does not take it

    def period(self, tick_period: float) -> float:
        """Return the time between readings [s]: one comes in each tick of `tick_period` [s]."""
        return tick_period

    def age(self) -> float:
        """Return the usual age of a reading when it arrives [s]."""
        return 0.0

    def rows(self) -> tuple[MeasurementRow, ...]:
        """Return the measurements that the estimator takes, each with some noise."""
        return tuple(row._replace(sigma=max(row.sigma, LEAST_NOISE)) for row in self.stated_rows())

    @abc.abstractmethod
    def stated_rows(self) -> tuple[MeasurementRow, ...]:
        """Return these measurements with the noise that is stated."""

    def slow_states(self) -> tuple[SlowState, ...]:
        """Return the sensor's errors that the estimator follows."""
        return ()

    def unit(self, static_tension: float) -> float:
        """Return the size of the sensor's unit in that of the model, for a cable of `static_tension` [N]."""
        return static_tension if self.zero is Zero.STATIC_TENSION else 1.0


@dataclass(frozen=True)
class SampledSensorParameters(SensorModelParameters):
    """A sensor with samples and a latency of its own."""

    rate: float = parameter(20.0, unit="Hz", minimum=0.01, maximum=1000.0, description="Readings per second.")
    latency: float = parameter(0.0, "s", 0.0, 5.0, "Typical age on arrival.")

    def period(self, tick_period: float) -> float:
        """Return the time between readings [s], whatever the `tick_period`."""
        return max(1.0 / self.rate, tick_period)

    def age(self) -> float:
        """Return the usual age of a reading when it arrives [s]."""
        return self.latency


@dataclass(frozen=True)
class MruModelParameters(SampledSensorParameters):
    """The motion reference unit: heave and heave rate of the boom tip; its readings have a type of their own."""

    sees: ClassVar[str] = "boom_tip"

    noise: float = parameter(0.01, "m", 0.0, 1.0, "White noise of heave: standard deviation of each reading.")
    rate_noise: float = parameter(0.01, "m/s", 0.0, 1.0,
        "White noise of heave rate: standard deviation of each reading.")  # fmt: skip
    high_pass_period: float = parameter(0.0, "s", 0.0, 300.0,
        "Cut-off period of the MRU's high-pass filter; 0: no filter.")  # fmt: skip
    high_pass_damping: float = 0.7071  # damping ratio of the high-pass filter [-]
    scale_sigma: float = parameter(0.0, "", 0.0, 0.5, "Possible scale error, 1 sigma; 0: not estimated.")
    bias_sigma: float = parameter(0.0, "m", 0.0, 100.0,
        "Possible mean of heave, from trim or another reference point, 1 sigma; 0: not estimated.")  # fmt: skip
    bias_drift: float = parameter(1e-4, "m/sqrt(s)", 0.0, 1.0,
        "Random walk of mean heave: default 1 cm in three hours; 0.005 if the mean wanders in turns.")  # fmt: skip
    lever_arm_sigma: float = parameter(0.0, "m", 0.0, 10.0,
        "Possible lever-arm error, 1 sigma along x and y; 0: not estimated.")  # fmt: skip

    def stated_rows(self) -> tuple[MeasurementRow, ...]:
        """Tell heave and heave rate; the high-pass is in the model."""
        return (
            MeasurementRow("mru_heave", "mru_heave", self.noise, "m", state=MRU_BIAS, scale_state=MRU_SCALE),
            MeasurementRow("mru_heave_rate", "mru_heave_rate", self.rate_noise, "m/s", scale_state=MRU_SCALE),
        )

    def slow_states(self) -> tuple[SlowState, ...]:
        """Follow scale, mean and lever arm, where they are uncertain."""
        states: list[SlowState] = []
        if self.scale_sigma > 0.0:
            states.append(SlowState(MRU_SCALE, CALIBRATION_DRIFT, self.scale_sigma))
        if self.bias_sigma > 0.0:
            states.append(SlowState(MRU_BIAS, self.bias_drift, self.bias_sigma))
        if self.lever_arm_sigma > 0.0:
            states += [SlowState(name, CALIBRATION_DRIFT, self.lever_arm_sigma) for name in (LEVER_ARM_X, LEVER_ARM_Y)]
        return tuple(states)


@dataclass(frozen=True)
class DepthModelParameters(SampledSensorParameters):
    """The depth sensor: heave of the unit about its first reading."""

    sees: ClassVar[str] = "unit"
    zero: ClassVar[Zero] = Zero.FIRST_READING
    sign: ClassVar[float] = -1.0

    noise: float = parameter(0.02, "m", 0.0, 100.0, "White noise, 1 sigma.")
    rate: float = parameter(10.0, unit="Hz", minimum=0.01, maximum=1000.0, description="Readings per second.")
    latency: float = parameter(0.1, "s", 0.0, 5.0, "Typical age on arrival.")
    bias_sigma: float = parameter(1.0, "m", 0.0, 100.0, "Uncertainty of the mean depth at the start, 1 sigma.")
    bias_drift: float = 2e-4  # random walk of the mean depth: tide, sensor drift, stretch [m/sqrt(s)]

    def stated_rows(self) -> tuple[MeasurementRow, ...]:
        """Tell the heave of the unit, with an unknown mean."""
        return (MeasurementRow("unit_heave", "unit_heave", self.noise, "m", state=DEPTH_BIAS),)

    def slow_states(self) -> tuple[SlowState, ...]:
        """Follow the mean."""
        return (SlowState(DEPTH_BIAS, self.bias_drift, self.bias_sigma),) if self.bias_sigma > 0.0 else ()


@dataclass(frozen=True)
class EncoderModelParameters(SensorModelParameters):
    """The encoder of the drum, read with every state of the winch."""

    sees: ClassVar[str] = "drum"

    noise: float = parameter(3e-4, "m", 0.0, 1.0, "Noise of the encoder, 1 sigma; steps of 1 mm give 0.29 mm.")

    def stated_rows(self) -> tuple[MeasurementRow, ...]:
        """Tell the payout.

        A servo other than assumed moves the drum otherwise, at the winch's limits by centimetres in a second: refusing
        the encoder would leave the loop blind when it is needed most; jumps are found by a gate of its own.
        """
        return (MeasurementRow("payout", "payout", self.noise, "m", is_gated=False),)


@dataclass(frozen=True)
class VelocityModelParameters(SampledSensorParameters):
    """The Doppler velocity log: vertical velocity of the unit."""

    sees: ClassVar[str] = "unit"
    component: ClassVar[int] = 2

    latency: float = parameter(0.1, "s", 0.0, 5.0, "Typical age on arrival.")
    noise: float = parameter(0.01, "m/s", 0.0, 100.0, "White noise, 1 sigma.")
    rate: float = parameter(5.0, unit="Hz", minimum=0.01, maximum=1000.0, description="Readings per second.")

    def stated_rows(self) -> tuple[MeasurementRow, ...]:
        """Tell the unit's heave rate."""
        return (MeasurementRow("unit_velocity", "unit_heave_rate", self.noise, "m/s"),)


@dataclass(frozen=True)
class ImuModelParameters(SampledSensorParameters):
    """The inertial measurement unit: vertical acceleration of the unit."""

    sees: ClassVar[str] = "unit"
    component: ClassVar[int] = 2
    includes_gravity: ClassVar[bool] = True

    noise: float = parameter(0.02, "m/s^2", 0.0, 100.0, "White noise, 1 sigma.")

    def stated_rows(self) -> tuple[MeasurementRow, ...]:
        """Tell the unit's acceleration."""
        return (MeasurementRow("unit_acceleration", "unit_heave_acceleration", self.noise, "m/s^2"),)


@dataclass(frozen=True)
class LoadCellModelParameters(SampledSensorParameters):
    """The load cell: top tension about the static one. Constant tension, landing and lift-off need it always."""

    sees: ClassVar[str] = "cable"
    zero: ClassVar[Zero] = Zero.STATIC_TENSION
    is_always_watched: ClassVar[bool] = True

    noise: float = parameter(0.005, "", 0.0, 1.0, "White noise, as a fraction of the static tension, 1 sigma.")
    model_error: float = parameter(0.01, "", 0.0, 1.0,
        "Error of the tension from the two-state cable, as a fraction of the static tension, 1 sigma.")  # fmt: skip
    bias_sigma: float = parameter(0.05, "", 0.0, 1.0, "Uncertainty of the static tension at the start, 1 sigma.")
    bias_drift: float = 2e-4  # random walk of the static tension: cable paid out, drift of the load cell [1/sqrt(s)]

    def stated_rows(self) -> tuple[MeasurementRow, ...]:
        """Tell the tension less the static one."""
        sigma = math.hypot(self.noise, self.model_error)
        return (MeasurementRow("tension", "tension", sigma, "", state=LOAD_CELL_BIAS),)

    def slow_states(self) -> tuple[SlowState, ...]:
        """Follow the static tension."""
        return (SlowState(LOAD_CELL_BIAS, self.bias_drift, self.bias_sigma),) if self.bias_sigma > 0.0 else ()


@dataclass(frozen=True)
class KnownSensors:
    """Every sensor that the controller knows, with its assumed properties."""

    mru: MruModelParameters = group(MruModelParameters)
    depth: DepthModelParameters = group(DepthModelParameters)
    encoder: EncoderModelParameters = group(EncoderModelParameters)
    velocity: VelocityModelParameters = group(VelocityModelParameters)
    imu: ImuModelParameters = group(ImuModelParameters)
    load_cell: LoadCellModelParameters = group(LoadCellModelParameters)

    def by_name(self) -> dict[str, SensorModelParameters]:
        """Return the assumed properties of each sensor, in the order of this table."""
        return {name: getattr(self, name) for name in KNOWN_SENSORS}


KNOWN_SENSORS = tuple(field.name for field in dataclasses.fields(KnownSensors))

INPUTS = tuple(name for name in KNOWN_SENSORS if name in SENSORS)
"""Sensors that the controller listens to; the encoder comes with the state of the winch."""

SCALAR_SENSORS = tuple(name for name in INPUTS if name != MRU.name)
"""Sensors that deliver one value."""


def sensors_that_see(*seen: str) -> list[str]:
    """Return the names of the sensors that tell of one of `seen`: boom_tip, unit, cable, drum."""
    return [name for name, sensor in KnownSensors().by_name().items() if sensor.sees in seen]


@dataclass(frozen=True)
class SensorsModelParameters(KnownSensors):
    """Which sensors the estimator uses, and their assumed properties."""

    use: tuple[str, ...] = parameter(("mru", "depth", "encoder"),
        description="Sensors that the estimator uses.", choices=KNOWN_SENSORS)  # fmt: skip

    def in_use(self) -> dict[str, SensorModelParameters]:
        """Return the assumed properties of the sensors that the estimator takes."""
        return {name: sensor for name, sensor in self.by_name().items() if name in self.use}
