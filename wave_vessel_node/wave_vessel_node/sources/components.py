"""The sum of components of a spectrum, answered by the second-order vessel or by a table of RAOs."""

from __future__ import annotations

import numpy as np
from heave_node.interface.waves import Waves
from heave_node.numerics.arrays import Array

from wave_vessel_node.sea.realisation import HarmonicSum, WaveComponents
from wave_vessel_node.sources.motion_source import MotionSource
from wave_vessel_node.sources.rao_components import RaoSource
from wave_vessel_node.sources.scene import Scene
from wave_vessel_node.vessel.motion import HEAVE, PITCH, VesselMotions
from wave_vessel_node.vessel.second_order import SecondOrderVessel, wave_slope_response


def build(scene: Scene) -> MotionSource:
    """Return the source `spectrum` of a scene."""
    if scene.rao is not None:
        course = scene.parameters.course
        return RaoSource(scene.components(), scene.rao, course, scene.boom_tip_arm, scene.tick_period)
    return SecondOrderSource(scene.components(), scene.vessel, scene.parameters.vessel.pitch_gain, scene.tick_period)


class SecondOrderSource(MotionSource):
    """Components through the second-order vessel (thesis Eq. 6.25), each by its exact steady response.

    Parameters
    ----------
    components : of the sea
    vessel : None where the boom tip follows the sea surface
    pitch_gain : pitch per wave slope at low frequency; 0 is no pitch
    tick_period : [s]
    """

    def __init__(
        self, components: WaveComponents, vessel: SecondOrderVessel | None, pitch_gain: float, tick_period: float
    ) -> None:
        self._components = components
        omega = components.frequency
        phasor = components.amplitude * np.exp(1j * components.phase)
        response = np.ones(omega.size, dtype=complex) if vessel is None else vessel.response(omega)
        rows = [phasor, phasor * response]
        self._has_pitch = False
        if pitch_gain > 0.0 and vessel is not None:
            self._has_pitch = True
            shape = vessel.response(omega) / vessel.gain if vessel.gain else 0.0 * response
            # bow-down pitch is positive and the waves meet the bow: the slope along their travel is the pitch
            rows.append(phasor * shape * pitch_gain * wave_slope_response(omega))
        self._sum = HarmonicSum(omega, np.vstack(rows), tick_period)
        self._tick_period = tick_period

    def motions(self, ticks: range) -> VesselMotions:
        """See MotionSource."""
        values = self._sum.at(ticks)
        motions = VesselMotions.still(ticks, self._tick_period)
        motions.elevation = values[:, 0, 0]
        motions.six[:, :, HEAVE] = values[:, :, 1]
        if self._has_pitch:
            motions.six[:, :, PITCH] = values[:, :, 2]
        return motions

    def point_heave(self, lever: Array) -> HarmonicSum:
        """See MotionSource."""
        return self._sum.combined(np.array([[0.0, lever[HEAVE], lever[PITCH]][: 2 + self._has_pitch]]))

    def waves(self) -> Waves:
        """See MotionSource."""
        sea = self._components
        return Waves(sea.frequency, sea.frequency, sea.amplitude, sea.phase, sea.direction)
