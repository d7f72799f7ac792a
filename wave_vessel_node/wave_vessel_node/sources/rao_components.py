"""Components through a table of RAOs, at a heading and speed that hold: each at its encounter frequency."""

from __future__ import annotations

import math

import numpy as np
from heave_node.interface.waves import Waves
from heave_node.numerics.arrays import Array

from wave_vessel_node.parameters import CourseParameters
from wave_vessel_node.sea.realisation import HarmonicSum, WaveComponents
from wave_vessel_node.sources.motion_source import MotionSource
from wave_vessel_node.vessel.motion import VesselMotions
from wave_vessel_node.vessel.rao import ResponseTable


class RaoSource(MotionSource):
    """Motion in six degrees of freedom; each component answers at its encounter frequency, exactly.

    Parameters
    ----------
    components : of the sea, at the place of the vessel at time 0
    table : RAOs of the vessel
    course : of the vessel
    arm : boom tip from the reference point [m], shape (3,): where the elevation is taken
    tick_period : [s]
    """

    def __init__(
        self, components: WaveComponents, table: ResponseTable, course: CourseParameters, arm: Array, tick_period: float
    ) -> None:
        sea, relative = components, components.direction - course.heading
        velocity = course.speed * np.array([math.cos(course.heading), math.sin(course.heading)])
        along = np.column_stack((np.cos(sea.direction), np.sin(sea.direction)))
        # the components reach the boom tip later than the reference point
        arm_lag = sea.wave_number * (arm[0] * np.cos(relative) + arm[1] * np.sin(relative))
        encounter = sea.frequency - sea.wave_number * (along @ velocity)
        phasor = sea.amplitude * np.exp(1j * sea.phase)
        rows = np.vstack((table.at(sea.frequency, relative, course.speed), np.exp(-1j * arm_lag)))
        self._sum = HarmonicSum(encounter, phasor * rows, tick_period)
        self._waves = Waves(sea.frequency, encounter, sea.amplitude, sea.phase - arm_lag, sea.direction)
        self._tick_period = tick_period

    def motions(self, ticks: range) -> VesselMotions:
        """See MotionSource."""
        motions, values = VesselMotions.still(ticks, self._tick_period), self._sum.at(ticks)
        motions.six, motions.elevation = values[:, :, :6], values[:, 0, 6]
        return motions

    def point_heave(self, lever: Array) -> HarmonicSum:
        """See MotionSource."""
        return self._sum.combined(np.append(lever, 0.0)[None])

    def waves(self) -> Waves:
        """See MotionSource: as met at the boom tip."""
        return self._waves
