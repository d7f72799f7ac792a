"""Components through a table of RAOs, on a course: encounter frequency, heading and speed, and manoeuvres."""

from __future__ import annotations

from functools import cached_property
from itertools import takewhile

import numpy as np
from heave_node.interface.waves import NO_WAVES, Waves
from heave_node.numerics.arrays import Array, ComplexArray
from heave_node.numerics.compiled import kernel
from heave_node.numerics.constants import STANDARD_GRAVITY

from wave_vessel_node.sea.realisation import HarmonicSum, WaveComponents
from wave_vessel_node.sources.motion_source import MotionSource
from wave_vessel_node.vessel.course import Course, Leg
from wave_vessel_node.vessel.motion import VesselMotions
from wave_vessel_node.vessel.rao import ResponseTable, SampledResponse, speed_weights

_AT_ONCE = 4
"""Ticks of a manoeuvre that are computed at once: each takes half a millisecond, and a run in real time waits."""
_DIFFERENCE = 0.02  # s, step of the central differences that give rates within manoeuvres


class RaoSource(MotionSource):
    """Motion in six degrees of freedom.

    On a leg (heading and speed hold) each component answers at its encounter frequency, exactly. Within a manoeuvre
    the response is that of the heading and speed of the moment, the phases stay continuous, and rates are differences
    of what was summed.

    Parameters
    ----------
    components : of the sea, at the place of the vessel at time 0
    table : RAOs of the vessel
    course : of the vessel
    arm : boom tip from the reference point [m], shape (3,): where the elevation is taken
    tick_period : [s]
    """

    def __init__(
        self, components: WaveComponents, table: ResponseTable, course: Course, arm: Array, tick_period: float
    ) -> None:
        self._components = components
        self._course = course
        self._arm = arm
        self._table = table
        self._tick_period = tick_period
        self._legs = [self._leg_sum(leg) for leg in course.legs]
        if len(course.legs) > 1:
            self._sum_at(0.0)  # compiles now what a tick should not wait for

    @cached_property
    def _response(self) -> SampledResponse:
        """The table at the frequencies of the sea, for many headings and speeds."""
        return self._table.sampled(self._components.frequency)

    def motions(self, ticks: range) -> VesselMotions:
        """See MotionSource: those of one leg, or a few of a manoeuvre."""
        legs = [self._course.leg_at(tick * self._tick_period) for tick in ticks]
        leg = legs[0]
        count = len(list(takewhile(lambda other: other == leg, legs)))
        ticks = ticks[: min(count, _AT_ONCE) if leg is None else count]
        motions = VesselMotions.still(ticks, self._tick_period)
        if leg is None:
            values = np.array([self._in_manoeuvre(time) for time in motions.time.tolist()])
        else:
            values = self._legs[leg].at(ticks)
        motions.six, motions.elevation = values[:, :, :6], values[:, 0, 6]
        return motions

    def point_heave(self, lever: Array) -> HarmonicSum | None:
        """See MotionSource: while heading and speed hold for the whole run."""
        return self._legs[0].combined(np.append(lever, 0.0)[None]) if len(self._legs) == 1 else None

    def waves(self) -> Waves:
        """See MotionSource: as met at the boom tip, while heading and speed hold for the whole run."""
        if len(self._course.legs) > 1:
            return NO_WAVES
        sea, leg = self._components, self._course.legs[0]
        encounter, phase = self._met_on(leg)
        phase = phase - self._arm_lag(self._course.heading(leg.start))
        return Waves(sea.frequency, encounter, sea.amplitude, phase, sea.direction)

    def _leg_sum(self, leg: Leg) -> HarmonicSum:
        """Return the sum that holds on a leg."""
        sea, at = self._components, _moment_of(leg)
        encounter, phase = self._met_on(leg)
        phasor = sea.amplitude * np.exp(1j * phase)
        heading = self._course.heading(at)
        relative, speed = sea.direction - heading, self._course.speed(at)
        one_leg = len(self._course.legs) == 1
        response = self._table.at(sea.frequency, relative, speed) if one_leg else self._response.at(relative, speed)
        rows = np.vstack((response, np.exp(-1j * self._arm_lag(heading))))
        return HarmonicSum(encounter, phasor * rows, self._tick_period)

    def _met_on(self, leg: Leg) -> tuple[Array, Array]:
        """Return the encounter frequencies [rad/s] and phases [rad] on a leg: omega t - k . X(t), X linear in time."""
        sea, at = self._components, _moment_of(leg)
        velocity = self._course.velocity(at)
        along = np.column_stack((np.cos(sea.direction), np.sin(sea.direction)))
        start = self._course.place(at) - velocity * at
        encounter = sea.frequency - sea.wave_number * (along @ velocity)
        return encounter, sea.phase - sea.wave_number * (along @ start)

    def _arm_lag(self, heading: float) -> Array:
        """Return by how much the components reach the boom tip later than the reference point, on a `heading` [rad]."""
        sea, relative = self._components, self._components.direction - heading
        return np.asarray(sea.wave_number * (self._arm[0] * np.cos(relative) + self._arm[1] * np.sin(relative)))

    def _in_manoeuvre(self, time: float) -> Array:
        before, here, after = (self._sum_at(time + step) for step in (-_DIFFERENCE, 0.0, _DIFFERENCE))
        rate = (after - before) / (2.0 * _DIFFERENCE)
        acceleration = (after - 2.0 * here + before) / _DIFFERENCE**2
        return np.stack((here, rate, acceleration))

    def _sum_at(self, time: float) -> Array:
        sea = self._components
        x, y = self._course.place(time)
        weights = speed_weights(self._response.speed, self._course.speed(time))
        out = np.zeros(7)
        waves = (sea.frequency, sea.amplitude, sea.phase, sea.direction)
        pose = (float(x), float(y), self._course.heading(time))
        response = self._response
        _sum(waves, response.knots, response.coefficients, weights, time, pose, (self._arm[0], self._arm[1]), out)
        return out


def _moment_of(leg: Leg) -> float:
    """Return a time [s] on a `leg` at which its heading and speed hold."""
    return leg.start if np.isinf(leg.end) else 0.5 * (leg.start + leg.end)


@kernel
def _sum(
    waves: tuple[Array, Array, Array, Array],
    knots: Array,
    coefficients: ComplexArray,
    weights: Array,
    time: float,
    pose: tuple[float, float, float],
    arm: tuple[float, float],
    out: Array,
) -> None:
    """Sum six motions and the elevation at one time into out (7,).

    `waves` are frequency, amplitude, phase and direction; `pose` is x, y and heading of the vessel, `arm` x and y.
    """
    frequency, amplitude, phase, direction = waves
    x, y, heading = pose
    cells = knots.size - 1
    for n in range(frequency.size):
        wave_number = frequency[n] * frequency[n] / STANDARD_GRAVITY
        along = x * np.cos(direction[n]) + y * np.sin(direction[n])
        angle = frequency[n] * time - wave_number * along + phase[n]
        relative = (direction[n] - heading) % (2.0 * np.pi)
        cell = min(cells - 1, max(0, np.searchsorted(knots, relative, side="right") - 1))
        step = relative - knots[cell]
        wave = amplitude[n] * np.exp(1j * angle)
        for motion in range(6):
            response = 0.0j
            for power in range(4):
                response *= step
                for s in range(weights.size):
                    response += weights[s] * coefficients[s, n, cell, motion, power]
            out[motion] += (response * wave).real
        lag = wave_number * (arm[0] * np.cos(relative) + arm[1] * np.sin(relative))
        out[6] += (np.exp(-1j * lag) * wave).real
