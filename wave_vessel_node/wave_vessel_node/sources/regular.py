"""The boom tip moved as a sine, to compare the plant with theory and with others."""

from __future__ import annotations

import math

import numpy as np
from heave_node.interface.waves import Waves

from wave_vessel_node.sources.motion_source import MotionSource
from wave_vessel_node.sources.scene import Scene
from wave_vessel_node.vessel.motion import HEAVE, VesselMotions


def build(scene: Scene) -> MotionSource:
    """Return the source `regular` of a scene."""
    return RegularSource(
        scene.parameters.amplitude, scene.parameters.period, scene.parameters.direction, scene.tick_period
    )


class RegularSource(MotionSource):
    """Boom tip moved as a_i sin(omega t) along world x, y, z; the sea surface follows z.

    Parameters
    ----------
    amplitude : a [m], three numbers
    period : of the sine [s]
    direction : that the wave on the surface travels to, from world x towards y [rad]
    tick_period : [s]
    """

    def __init__(self, amplitude: tuple[float, ...], period: float, direction: float, tick_period: float) -> None:
        self._amplitude = np.array(amplitude)
        self._period = period
        self._direction = direction
        self._omega = 2.0 * math.pi / period
        self._tick_period = tick_period

    def motions(self, ticks: range) -> VesselMotions:
        """See MotionSource."""
        motions, omega = VesselMotions.still(ticks, self._tick_period), self._omega
        angles = [omega * time for time in motions.time.tolist()]
        sine = np.array([math.sin(angle) for angle in angles])[:, None]
        cosine = np.array([math.cos(angle) for angle in angles])[:, None]
        motions.six[:, 0, :3] = self._amplitude * sine
        motions.six[:, 1, :3] = self._amplitude * (omega * cosine)
        motions.six[:, 2, :3] = self._amplitude * (-omega * omega * sine)
        motions.elevation = motions.six[:, 0, HEAVE].copy()
        return motions

    def nominal_sea(self) -> tuple[float, float]:
        """See MotionSource: the height of a sea with the variance of the sine, and its period."""
        return 2.0 * math.sqrt(2.0) * abs(float(self._amplitude[2])), self._period

    def waves(self) -> Waves:
        """See MotionSource: the one whose surface follows z, a sin(omega t) = a cos(omega t - pi/2)."""
        omega, height = np.array([self._omega]), self._amplitude[HEAVE : HEAVE + 1]
        return Waves(omega, omega, height, np.array([-0.5 * math.pi]), np.array([self._direction]))
