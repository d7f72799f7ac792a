"""The vessel's mean course: heading, forward speed and place over time, with a smooth turn and change of speed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.kinematics import PEAK_OF_RAMP, smooth_ramp

from wave_vessel_node.parameters import CourseParameters

_CELL = 0.5  # s, of the table of positions within manoeuvres


@dataclass(frozen=True)
class Leg:
    """A time in which heading and speed are constant: from `start` to `end` [s]."""

    start: float
    end: float


class Course:
    """Heading, speed and place of the vessel's mean position; the place is 0 at time 0.

    Parameters
    ----------
    parameters : heading, speed, and their changes

    Attributes
    ----------
    legs : times of constant heading and speed, in order
    """

    def __init__(self, parameters: CourseParameters) -> None:
        self._parameters = parameters
        self._turn_duration = PEAK_OF_RAMP * abs(parameters.turn_angle) / parameters.turn_rate
        self.legs = self._legs()
        self._knots = np.zeros(1)
        self._places = np.zeros((1, 2))
        if len(self.legs) > 1:
            first, last = self.legs[0].end, self.legs[-1].start
            self._knots = np.linspace(first, last, 2 + math.ceil((last - first) / _CELL))
            self._places = self._integrate(self._knots)

    def heading(self, time: float) -> float:
        """Return the heading at `time` [s] from world x, anticlockwise [rad]."""
        p = self._parameters
        return p.heading + p.turn_angle * smooth_ramp(time - p.turn_start, self._turn_duration)[0]

    def turn_rate(self, time: float) -> float:
        """Return the rate of turn at `time` [s] [rad/s]."""
        p = self._parameters
        return p.turn_angle * smooth_ramp(time - p.turn_start, self._turn_duration)[1]

    def turn_acceleration(self, time: float) -> float:
        """Return the rate of change of the rate of turn at `time` [s] [rad/s^2]."""
        p = self._parameters
        return p.turn_angle * smooth_ramp(time - p.turn_start, self._turn_duration)[2]

    def speed(self, time: float) -> float:
        """Return the forward speed at `time` [s] [m/s], never negative."""
        p = self._parameters
        change = p.speed_change * smooth_ramp(time - p.speed_change_start, p.speed_change_duration)[0]
        return max(0.0, p.speed + change)

    def velocity(self, time: float) -> Array:
        """Return the velocity over ground at `time` [s] in world axes [m/s], shape (2,)."""
        heading = self.heading(time)
        return self.speed(time) * np.array([math.cos(heading), math.sin(heading)])

    def place(self, time: float) -> Array:
        """Return the mean position at `time` [s] in world axes [m], shape (2,)."""
        if time <= self._knots[0] or len(self.legs) == 1:
            return self.velocity(min(time, self._knots[0])) * time
        if time >= self._knots[-1]:
            beyond: Array = self._places[-1] + self.velocity(time) * (time - self._knots[-1])
            return beyond
        cell = int(np.searchsorted(self._knots, time, side="right")) - 1
        start, end = self._knots[cell], self._knots[cell + 1]
        return _hermite(
            (time - start) / (end - start),
            end - start,
            (self._places[cell], self.velocity(start)),
            (self._places[cell + 1], self.velocity(end)),
        )

    def leg_at(self, time: float) -> int | None:
        """Return the index of the leg at `time` [s], None within a manoeuvre."""
        return next((i for i, leg in enumerate(self.legs) if leg.start <= time <= leg.end), None)

    def _legs(self) -> list[Leg]:
        p = self._parameters
        manoeuvres = []
        if p.turn_angle != 0.0:
            manoeuvres.append((p.turn_start, p.turn_start + self._turn_duration))
        if p.speed_change != 0.0:
            manoeuvres.append((p.speed_change_start, p.speed_change_start + p.speed_change_duration))
        legs: list[Leg] = []
        at = 0.0
        for start, end in sorted(manoeuvres):
            if start > at or not legs:
                legs.append(Leg(at, start))
            at = max(at, end)
        legs.append(Leg(at, math.inf))
        return legs

    def _integrate(self, knots: Array) -> Array:
        """Return the places at `knots`, by Simpson's rule in each cell."""
        places = [self.velocity(0.0) * knots[0]]
        for start, end in pairwise(knots):
            middle = 0.5 * (start + end)
            mean = (self.velocity(start) + 4.0 * self.velocity(middle) + self.velocity(end)) / 6.0
            places.append(places[-1] + mean * (end - start))
        return np.array(places)


def _hermite(x: float, h: float, start: tuple[Array, Array], end: tuple[Array, Array]) -> Array:
    x2, x3 = x * x, x * x * x
    value = (2 * x3 - 3 * x2 + 1) * start[0] + (3 * x2 - 2 * x3) * end[0]
    return np.asarray(value + h * ((x3 - 2 * x2 + x) * start[1] + (x3 - x2) * end[1]))
