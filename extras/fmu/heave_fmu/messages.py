"""The messages of the parts: which fields of them are variables, and how many may come in one tick."""

from __future__ import annotations

import math
from collections.abc import Iterable

from cable_sim_node.conversions import CABLE_SCALARS
from heave_bringup.closed_loop import LoopParameters
from heave_node.interface import topics
from heave_node.interface.faults import FaultParameters
from heave_node.interface.sensors import SENSORS, USBL, Sensor
from heave_node.interface.topic import Topic

AXES = "xyz"
SHADOW = Topic("unit_uncompensated/cable", topics.CABLE_STATE.type, "cable_sim")
"""The cable of the plant with the winch locked: no topic of a run, and needed by its figures of merit."""
TENSIONS = ("top_tension", "largest_top_tension")
CABLE_FIELDS = (*CABLE_SCALARS, "bottom_tension")
CONTROLLER_FIELDS = ("mode", "authority", "depth_set_point")


def point_fields(names: Iterable[str]) -> tuple[str, ...]:
    """Return the fields of the vectors of these `names`, axis by axis."""
    return tuple(f"{name}.{axis}" for name in names for axis in AXES)


ODOMETRY_FIELDS = point_fields(("pose.pose.position", "twist.twist.linear"))


def _late_slots(faults: FaultParameters, tick_period: float) -> int:
    """Return how many messages may come in one tick besides its own: one per delay, those that jitter has held back."""
    jitters = (size for kind, size in zip(faults.kind, faults.magnitude, strict=True) if kind == "jitter")
    return faults.kind.count("delay") + sum(math.ceil(size / tick_period) for size in jitters)


def sensor_slots(sensor: Sensor, parameters: LoopParameters) -> int:
    """Return how many readings of a `sensor` of the plant may come in one tick, by the `parameters` of the loop.

    The way to a unit that moves makes the delay of USBL change.
    """
    faults = parameters.plant.sensors.by_name()[sensor.name].faults
    return 1 + _late_slots(faults, parameters.tick_period) + (sensor is USBL)


def fitted_sensors(parameters: LoopParameters) -> list[Sensor]:
    """Return the sensors of the plant that are fitted, by the `parameters` of the loop."""
    return [SENSORS[name] for name, sensor in parameters.plant.sensors.by_name().items() if sensor.fitted]
