"""The sensors of the plant, all of them."""

from __future__ import annotations

import math

from heave_node.interface.sensors import SENSORS, Reading
from heave_node.sensing.sensor import Sensor

from cable_sim_node.parameters import RopePathParameters
from cable_sim_node.physics.tension_law import jenkin_force
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


class RopePath:
    """The rope's way from the drum to the boom tip.

    Parameters
    ----------
    parameters : friction and stiffness
    tension : at the boom tip where the rope comes to rest at the start, with payout 0 [N]

    Attributes
    ----------
    drum_tension : of the rope on the drum's side of the sheaves [N]
    """

    def __init__(self, parameters: RopePathParameters, tension: float) -> None:
        self._ratio = math.exp(parameters.friction)
        self._stiffness = parameters.stiffness
        self._payout = 0.0
        self.drum_tension = tension

    def advance(self, tension: float, payout: float) -> None:
        """Go on to a `tension` at the boom tip [N], never negative, and a `payout` of the drum [m]."""
        sticking = self.drum_tension - self._stiffness * (payout - self._payout)
        self.drum_tension = jenkin_force(sticking, tension / self._ratio, tension * self._ratio)
        self._payout = payout
