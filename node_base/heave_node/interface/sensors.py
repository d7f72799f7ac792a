"""The sensors of the suite: name and topic of each, and what its readings are on the wire, both ways.

On the wire a reading is a stamp in whole nanoseconds and the numbers in certain fields of a message. `Sensor.to_wire`
makes them of what the sensor says in the actual water; the controller decodes them with the water it assumes
Fields are named by text, so that this table is pure; `messages` puts the numbers into messages and takes
them out again. The loop in one process hands over what is on the wire and leaves only the message out: it reads what
the loop over ROS reads, to the last bit.

>>> reading = Reading(0.05, np.array([300.0]), np.array([0.02]))
>>> on_wire = DEPTH.to_wire(reading, Water(density=1030.0, gravity=9.80665))
>>> depth = DEPTH.decode(on_wire.numbers, Water(density=1025.0, gravity=9.80665))[0]
>>> round(depth, 3)
301.463
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np

from heave_node.interface.codes import MruStatus
from heave_node.interface.topic import Topic
from heave_node.numerics.arrays import Array
from heave_node.numerics.constants import ATMOSPHERIC_PRESSURE, SEAWATER_DENSITY, STANDARD_GRAVITY

UNKNOWN_VARIANCE = 1e6
"""Variance [SI] of what a sensor does not measure, in messages that cannot leave it out."""

LARGEST_PAYOUT = 1e4
"""Largest plausible magnitude of a winch's payout [m]."""

Numbers = tuple[float, ...]


@dataclass(frozen=True)
class Water:
    """The still water that a pressure is a depth in: density [kg/m^3] and gravity [m/s^2]."""

    density: float
    gravity: float

    @property
    def pressure_per_metre(self) -> float:
        """Pressure gained per metre of depth [Pa/m]."""
        return self.density * self.gravity


STANDARD_WATER = Water(SEAWATER_DENSITY, STANDARD_GRAVITY)
"""Water for readings that do not depend on it."""


class Reading(NamedTuple):
    """One reading of a sensor on the unit or the cable."""

    time: float  # of the measurement, simulated [s]
    value: Array  # shape (n,), SI units; NaN under a nan fault
    sigma: Array  # shape (n,), stated standard deviation


class MruReading(NamedTuple):
    """One sample of the motion reference unit: the boom tip's heave about its mean, positive up, and the attitude."""

    time: float  # of the measurement as the unit states it [s]
    heave: float  # [m]
    heave_rate: float  # [m/s]; NaN: the unit does not measure it
    roll: float = 0.0  # of the vessel [rad]
    pitch: float = 0.0  # of the vessel [rad]
    status: int = MruStatus.OK  # what the unit says of the sample
    sequence: int = 0  # counts samples from 1; a gap is a lost sample
    heave_acceleration: float = np.nan  # [m/s^2]; NaN: the unit does not measure it
    heave_sigma: float = np.nan  # accuracy that the unit states, one standard deviation [m]
    heave_rate_sigma: float = np.nan  # accuracy that the unit states, one standard deviation [m/s]


class WireReading(NamedTuple):
    """A reading as it travels: stamp [ns] and the numbers of the message's fields, values first."""

    stamp: int
    numbers: Numbers

    @property
    def time(self) -> float:
        """Time of the measurement as its receiver sees it [s]."""
        return self.stamp * 1e-9


def values_and_variances(reading: Reading, _: Water) -> Numbers:
    """Encode the values of a `reading` as they are, and the squares of their standard deviations."""
    return (*reading.value.tolist(), *(reading.sigma**2).tolist())


def values_alone(numbers: Sequence[float], _: Water) -> Numbers:
    """Decode `numbers` that travel as they are."""
    return tuple(numbers)


@dataclass(frozen=True)
class Sensor:
    """A sensor of the suite."""

    name: str  # in parameters, faults, health and alarms
    topic: Topic  # of its readings; the type is that of the message
    frame: str  # of the message's header
    meaning: str  # what a message says, for who writes or reads one: fields, units, frame, sign
    # fields that must be finite, each with the largest magnitude that is plausible in its unit
    largest: tuple[tuple[str, float], ...]
    values: tuple[str, ...]  # fields of the message that hold the values, in order
    may_be_missing: tuple[str, ...] = ()  # those of them that are NaN where the sensor does not measure them
    accuracies: tuple[str, ...] = ()  # fields that hold their variance or standard deviation
    constants: tuple[tuple[str, float], ...] = ()  # fields that always hold the same, with what they hold
    # (reading, water) to the numbers of `values` and `accuracies`
    encode: Callable[[Any, Water], Numbers] = values_and_variances
    # (numbers of `values`, assumed water) to the values of the reading
    decode: Callable[[Sequence[float], Water], Numbers] = values_alone

    @property
    def width(self) -> int:
        """Number of values of a reading."""
        return len(self.values)

    def largest_values(self, water: Water) -> tuple[float, ...]:
        """Return the largest plausible magnitude of each value, as a reader that assumes `water` has it; inf: none."""
        largest = dict(self.largest)
        return self.decode([largest.get(name, np.inf) for name in self.values], water)

    def to_wire(self, reading: Reading | MruReading, water: Water) -> WireReading:
        """Return a reading taken in `water` as it travels."""
        return WireReading(round(reading.time * 1e9), self.encode(reading, water))

    def from_wire(self, reading: WireReading, water: Water) -> Numbers:
        """Return the values of a reading as a reader that assumes `water` sees them."""
        return self.decode(reading.numbers[: self.width], water)


def _vector(field: str) -> tuple[str, ...]:
    return tuple(f"{field}.{axis}" for axis in "xyz")


def _diagonal(field: str, size: int, entries: Iterable[int]) -> tuple[str, ...]:
    """Return the names of diagonal entries of a row-major size x size matrix."""
    return tuple(f"{field}[{entry * (size + 1)}]" for entry in entries)


def _unknown(field: str) -> tuple[tuple[str, float], ...]:
    """Return the variances of the three turns in a 6x6 covariance, where a sensor does not measure them."""
    return tuple((name, UNKNOWN_VARIANCE) for name in _diagonal(field, 6, range(3, 6)))


def _encode_depth(reading: Reading, water: Water) -> Numbers:
    """Absolute pressure [Pa] of the atmosphere and the still water above, and its variance."""
    depth, sigma = float(reading.value[0]), float(reading.sigma[0])
    return ATMOSPHERIC_PRESSURE + water.pressure_per_metre * depth, (water.pressure_per_metre * sigma) ** 2


def _decode_depth(numbers: Sequence[float], water: Water) -> Numbers:
    # without an assumed water no depth can be read
    per_metre = water.pressure_per_metre or np.nan
    return ((numbers[0] - ATMOSPHERIC_PRESSURE) / per_metre,)


_MRU_FIELDS = (
    *("heave", "heave_rate", "roll", "pitch", "status", "sequence"),
    *("heave_acceleration", "heave_sigma", "heave_rate_sigma"),
)
"""Fields of the message, in the order of `MruReading` after its time."""

_numbers_of_mru = attrgetter(*_MRU_FIELDS)


def mru_reading(reading: WireReading) -> MruReading:
    """Return the sample of the motion reference unit that a `reading` carried."""
    return MruReading(reading.time, *reading.numbers)  # type: ignore[arg-type]  # status and sequence are whole numbers


MRU = Sensor(
    name="mru",
    topic=Topic("mru", "heave_msgs/msg/MruSample", "wave_vessel", is_needed=True),
    frame="world",
    meaning="heave, heave rate and acceleration of the boom tip, roll, pitch, status, sequence number",
    largest=(("heave", 30.0), ("heave_rate", 30.0), ("roll", 1.6), ("pitch", 1.6)),
    may_be_missing=("heave_rate",),
    values=_MRU_FIELDS,
    encode=lambda reading, _: _numbers_of_mru(reading),
)
"""Motion reference unit: the boom tip; its readings are `MruReading`."""

DEPTH = Sensor(
    name="depth",
    topic=Topic("unit/pressure", "sensor_msgs/msg/FluidPressure", "cable_sim"),
    frame="unit",
    meaning="`fluid_pressure`: absolute pressure, atmosphere plus water above the unit [Pa]; `variance`",
    largest=(("fluid_pressure", 2e8),),
    values=("fluid_pressure",),
    accuracies=("variance",),
    encode=_encode_depth,
    decode=_decode_depth,
)
"""Pressure sensor: depth of the unit, positive down [m]."""

VELOCITY = Sensor(
    name="velocity",
    topic=Topic("unit/velocity", "geometry_msgs/msg/TwistWithCovarianceStamped", "cable_sim"),
    frame="unit",
    meaning="`twist.twist.linear`: velocity of the unit over ground [m/s], world axes, z up; covariance",
    largest=(("twist.twist.linear.z", 30.0),),
    values=_vector("twist.twist.linear"),
    accuracies=_diagonal("twist.covariance", 6, range(3)),
    constants=_unknown("twist.covariance"),
)
"""Doppler velocity log (DVL): velocity of the unit over ground, x, y, z [m/s]."""

IMU = Sensor(
    name="imu",
    topic=Topic("unit/imu", "sensor_msgs/msg/Imu", "cable_sim"),
    frame="unit",
    meaning="`linear_acceleration`: specific force of the unit [m/s^2], upwards at rest; `angular_velocity` [rad/s]",
    largest=(("linear_acceleration.z", 300.0),),
    values=_vector("linear_acceleration") + _vector("angular_velocity"),
    accuracies=_diagonal("linear_acceleration_covariance", 3, range(3))
    + _diagonal("angular_velocity_covariance", 3, range(3)),
    # orientation is not measured: covariance -1, REP-145
    constants=(("orientation.w", 1.0), ("orientation_covariance[0]", -1.0)),
)
"""Inertial measurement unit: specific force x, y, z [m/s^2] (gravity upwards at rest), turn rate x, y, z [rad/s]."""

USBL = Sensor(
    name="usbl",
    topic=Topic("unit/usbl", "geometry_msgs/msg/PoseWithCovarianceStamped", "cable_sim"),
    frame="world",
    meaning="`pose.pose.position`: position of the unit [m], frame world, z up; covariance",
    largest=(("pose.pose.position.z", 2e4),),
    values=_vector("pose.pose.position"),
    accuracies=_diagonal("pose.covariance", 6, range(3)),
    constants=(("pose.pose.orientation.w", 1.0), *_unknown("pose.covariance")),
)
"""Acoustic position of the unit, x, y, z [m]."""

LOAD_CELL = Sensor(
    name="load_cell",
    topic=Topic("winch/load_cell", "heave_msgs/msg/LoadCell", "cable_sim"),
    frame="",
    meaning="`tension` at the top of the cable [N]; `tension_sigma`",
    largest=(("tension", 1e8),),
    values=("tension",),
    accuracies=("tension_sigma",),
    encode=lambda reading, _: (float(reading.value[0]), float(reading.sigma[0])),
)
"""Load cell at the boom tip: top tension [N]."""

SENSORS: dict[str, Sensor] = {sensor.name: sensor for sensor in (MRU, DEPTH, VELOCITY, IMU, USBL, LOAD_CELL)}
"""Every sensor with a topic of its own, by name; the drum's encoder travels in `winch/state`."""


def all_to_wire(readings: Mapping[str, Iterable[Reading]], water: Water) -> dict[str, list[WireReading]]:
    """Return the readings of each sensor, by its name, taken in `water`, as they travel."""
    return {name: [SENSORS[name].to_wire(reading, water) for reading in taken] for name, taken in readings.items()}
