"""Sensors as sampled, noisy, late and faulty views of the truth.

A reading carries the time of its measurement; it is handed out later, at the first tick not before that time plus the
latency. Every sensor has its own random stream and draws as many numbers in every tick, whatever it does with them:
a fault, a rate or a latency changes nothing but itself. They are drawn for many ticks at once, in the same order.
"""

from __future__ import annotations

import math
from operator import itemgetter
from typing import Any

import numpy as np

from heave_node.interface.faults import TIME_TOLERANCE, FaultSchedule, FaultyValues
from heave_node.interface.sensors import Reading
from heave_node.numerics.arrays import Array
from heave_node.numerics.randomness import random_stream
from heave_node.sensing.view import SensorParameters, View, quantised

_DRAWN_AT_ONCE = 256
"""Ticks for which a sensor draws its noise in one go: a call costs as much as a hundred numbers."""


class Sensor:
    """A sensor, tick by tick.

    Parameters
    ----------
    parameters : rate, latency, scale error, scheduled faults, and its view of the truth
    name : for messages
    node : that it is of; its random stream is "NODE/NAME"
    width : number of values of a reading
    seed, tick_period : of the run; tick_period in [s]
    axes : what share of a spike or jump each value gets, shape (n,) or a number

    Attributes
    ----------
    faults : faults may be injected during the run
    """

    def __init__(
        self,
        parameters: SensorParameters,
        *,
        name: str,
        node: str,
        width: int,
        seed: int,
        tick_period: float,
        axes: Array | float = 1.0,
    ) -> None:
        self.name = name
        self.faults = FaultSchedule(parameters.faults, name=name, device="sensor", seed=seed)
        self._parameters = parameters
        self._ones = np.ones(width)
        self._tick_period = tick_period
        self._random = random_stream(seed, f"{node}/{name}")
        self._noise: list[Array] = []
        self._gain = 1.0 + parameters.scale_error
        self._next_sample = 1.0 / parameters.rate
        self._rate = parameters.rate
        self._faulty_values = FaultyValues(self.faults, axes)
        self._under_way: list[tuple[float, Reading]] = []

    def step(self, tick: int, truth: Any) -> tuple[Reading, ...]:
        """Look at the `truth` of t_k and return the readings delivered at `tick`, oldest delivery first."""
        time = tick * self._tick_period
        if not self._noise:  # of the next ticks, of standard deviation 1
            self._noise = list(self._random.standard_normal((_DRAWN_AT_ONCE, self._ones.size))[::-1])
        noise = self._noise.pop()
        if self._is_due(time) and not self.faults.is_active("gap", time):
            self._measure(time, self._parameters.view(truth), noise)
        return self._deliver(time)

    def _is_due(self, time: float) -> bool:
        """Return whether a sample is taken at `time`, and note when the next one is."""
        faulty_rate = self.faults.newest("rate", time)
        rate = self._parameters.rate if faulty_rate is None else faulty_rate
        if rate != self._rate:
            self._rate = rate
            self._next_sample = math.ceil(time * rate - TIME_TOLERANCE) / rate
        if time < self._next_sample - TIME_TOLERANCE:
            return False
        self._next_sample = (math.floor(time * rate + 1e-6) + 1) / rate
        return True

    def _measure(self, time: float, view: View, noise: Array) -> None:
        """Put what the sensor says at `time` on its way."""
        sigma = view.sigma * self._ones
        right = view.value * self._gain + view.bias + sigma * noise
        read = self._faulty_values.apply(time, right)
        if any(view.resolution):
            read = np.array([*map(quantised, read.tolist(), view.resolution)])
        reading = Reading(time, read, sigma)
        delay = self._parameters.latency + view.extra_latency + self.faults.lateness(time)
        self._under_way.append((time + delay, reading))

    def _deliver(self, time: float) -> tuple[Reading, ...]:
        """Return the readings due by `time`; those with a smaller delay may overtake."""
        if not self._under_way:
            return ()
        now = time + TIME_TOLERANCE
        if len(self._under_way) == 1:
            ((due_at, reading),) = self._under_way
            if due_at > now:
                return ()
            self._under_way = []
            return (reading,)
        due = [entry for entry in self._under_way if entry[0] <= now]
        if not due:
            return ()
        self._under_way = [entry for entry in self._under_way if entry[0] > now]
        due.sort(key=itemgetter(0))
        return tuple([reading for _, reading in due])
