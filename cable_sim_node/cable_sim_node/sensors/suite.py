"""The sensors of the plant, all of them."""

from __future__ import annotations

from heave_node.interface.sensors import SENSORS, Reading
from heave_node.sensing.sensor import Sensor

from cable_sim_node.sensors.instruments import SensorsParameters, SensorTruth

NODE = "cable_sim"
"""Node that these sensors are of."""

SensorReadings = dict[str, tuple[Reading, ...]]
"""Readings delivered at one tick, oldest delivery first, by sensor; values as `heave_node.interface.sensors` says."""


class SensorSuite:
    """All sensors on the unit and the cable.

    Parameters
    ----------
    parameters : of each sensor
    seed, tick_period : of the run; tick_period in [s]

    Attributes
    ----------
    by_name : the sensors that are fitted
    """

    def __init__(self, parameters: SensorsParameters, *, seed: int, tick_period: float) -> None:
        self.by_name = {
            name: Sensor(sensor, name=name, node=NODE, width=SENSORS[name].width, seed=seed, tick_period=tick_period)
            for name, sensor in parameters.by_name().items()
            if sensor.fitted
        }

    def step(self, tick: int, truth: SensorTruth) -> SensorReadings:
        """Let every sensor look at the `truth` of t_k, `tick` k, and return what is delivered at t_k."""
        return {name: sensor.step(tick, truth) for name, sensor in self.by_name.items()}
