"""Sensors as sampled, noisy, late and faulty views of the truth.

A reading carries the time of its measurement; it is handed out later, at the first tick not before that time plus the
latency. Every sensor has its own random stream and draws as many numbers in every tick, whatever it does with them:
a fault, a rate or a latency changes nothing but itself.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np
from heave_node.arrays import Array
from heave_node.randomness import random_stream

from cable_sim_node.sensors.fault_parameters import SENSOR_FAULT_KINDS
from cable_sim_node.sensors.faults import TIME_TOLERANCE, FaultSchedule
from cable_sim_node.sensors.parameters import SensorParameters


@dataclass(frozen=True)
class Reading:
    """One reading of a sensor.

    Attributes
    ----------
    stamp : simulated time of the measurement [s]
    value : shape (n,), in the sensor's unit; NaN under a nan fault
    sigma : shape (n,), stated standard deviation
    """

    stamp: float
    value: Array
    sigma: Array


class Sensor:
    """A sensor of `n` values.

    Parameters
    ----------
    parameters : rate, latency, scale error and scheduled faults
    name : for messages and for the random stream "cable_sim/NAME"
    sigma : shape (n,), standard deviation of the white noise
    bias : shape (n,), constant error
    seed, tick_period : of the run; tick_period in [s]
    """

    def __init__(
        self,
        parameters: SensorParameters,
        *,
        name: str,
        sigma: Array,
        bias: Array,
        seed: int,
        tick_period: float,
    ) -> None:
        self.name = name
        self.faults = FaultSchedule(parameters.faults, device=name, known=SENSOR_FAULT_KINDS)
        self._parameters = parameters
        self._sigma = sigma
        self._bias = bias
        self._tick_period = tick_period
        self._random = random_stream(seed, f"cable_sim/{name}")
        self._next_sample = 1.0 / parameters.rate
        self._rate = parameters.rate
        self._frozen: Array | None = None
        self._last: Array | None = None
        self._under_way: deque[tuple[float, Reading]] = deque()

    def step(
        self,
        tick: int,
        truth: Array,
        *,
        sigma: Array | None = None,
        extra_latency: float = 0.0,
        is_available: bool = True,
    ) -> tuple[Reading, ...]:
        """Return the readings delivered at `tick`, oldest delivery first.

        Parameters
        ----------
        truth : shape (n,), true values at t_k
        sigma : standard deviation now, where it is not constant
        extra_latency : added to the latency of a sample taken now [s]
        is_available : False: the sensor cannot measure now
        """
        time = tick * self._tick_period
        noise = self._random.standard_normal(self._sigma.shape[0])
        if self._is_due(time) and is_available and not self.faults.is_active("gap", time):
            sigma = self._sigma if sigma is None else sigma
            reading = Reading(time, self._measure(time, truth, sigma * noise), sigma)
            delay = self._parameters.latency + extra_latency + self.faults.total("delay", time)
            self._under_way.append((time + delay, reading))
        return self._deliver(time)

    def _is_due(self, time: float) -> bool:
        """Tell whether a sample is taken at `time`, and note when the next one is."""
        faulty_rate = self.faults.newest("rate", time)
        rate = self._parameters.rate if faulty_rate is None else faulty_rate
        if rate != self._rate:
            self._rate = rate
            self._next_sample = math.ceil(time * rate - TIME_TOLERANCE) / rate
        if time < self._next_sample - TIME_TOLERANCE:
            return False
        self._next_sample = (math.floor(time * rate + 1e-6) + 1) / rate
        return True

    def _measure(self, time: float, truth: Array, noise: Array) -> Array:
        """Return what the sensor says of `truth` at `time`."""
        right = truth * (1.0 + self._parameters.scale_error) + self._bias + noise
        value = right + self.faults.total("jump", time) + self.faults.take_once("spike", time)
        if self.faults.is_active("freeze", time):
            self._frozen = self._last if self._frozen is None else self._frozen
            value = value if self._frozen is None else self._frozen
        else:
            self._frozen = None
            self._last = value
        return np.full_like(value, math.nan) if self.faults.is_active("nan", time) else value

    def _deliver(self, time: float) -> tuple[Reading, ...]:
        """Return the readings due by `time`; those with a smaller delay may overtake."""
        due = [entry for entry in self._under_way if entry[0] <= time + TIME_TOLERANCE]
        if not due:
            return ()
        self._under_way = deque(entry for entry in self._under_way if entry[0] > time + TIME_TOLERANCE)
        return tuple(reading for _, reading in sorted(due, key=lambda entry: entry[0]))
