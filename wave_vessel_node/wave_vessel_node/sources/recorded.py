"""A recording as the source of the vessel's motion."""

from __future__ import annotations

import math

import numpy as np
import scipy

from wave_vessel_node.mru.oscillator import DrivenOscillator
from wave_vessel_node.sources.motion_source import MotionSource
from wave_vessel_node.sources.recording import Recording, RecordingError, read_recording
from wave_vessel_node.sources.scene import Scene
from wave_vessel_node.vessel.motion import HEAVE, VesselMotions
from wave_vessel_node.vessel.second_order import SecondOrderVessel


def build(scene: Scene) -> MotionSource:
    """Return the source `file` of a scene; what was repaired in the file is added to the scene's warnings."""
    parameters = scene.parameters
    recording = read_recording(
        parameters.recording_file, parameters.recording_topic, accept_implausible=parameters.accept_implausible
    )
    scene.warnings.extend(recording.warnings)
    vessel = scene.vessel if scene.parameters.recording_kind == "elevation" else None
    return RecordedSource(recording, vessel, scene.tick_period)


class RecordedSource(MotionSource):
    """Motion of the boom tip as it was recorded, or recorded elevation through the vessel.

    Between samples a cubic spline gives position, velocity and acceleration that fit one another.

    Parameters
    ----------
    recording : motion of the boom tip, or elevation
    vessel : second-order vessel that elevation goes through; None where the recording is the motion, or the boom tip
        follows the surface
    tick_period : [s]
    """

    def __init__(self, recording: Recording, vessel: SecondOrderVessel | None, tick_period: float) -> None:
        self._recording = recording
        self._spline = scipy.interpolate.CubicSpline(recording.time, recording.position)
        self._tick_period = tick_period
        self._oscillator: DrivenOscillator | None = None
        if vessel is not None:
            gain = vessel.gain * vessel.natural_frequency**2
            self._oscillator = DrivenOscillator(
                vessel.natural_frequency, vessel.damping_ratio, value_gain=gain, rate_gain=0.0, period=tick_period
            )
        self._begun = False

    def motions(self, ticks: range) -> VesselMotions:
        """See MotionSource. Raises RecordingError beyond the end of the recording."""
        last = self._recording.time[-1] + 1e-9
        there = range(ticks.start, next((tick for tick in ticks if tick * self._tick_period > last), ticks.stop))
        if not there:
            end = math.floor(self._recording.time[-1] / self._tick_period) * self._tick_period
            raise RecordingError(f"{self._recording.path}: ends after {end:g} s: give a shorter duration")
        motions = VesselMotions.still(there, self._tick_period)
        values = np.stack([self._spline(motions.time, order) for order in range(3)], axis=1)
        motions.elevation = values[:, 0, HEAVE]
        if self._oscillator is None:
            motions.six[:, :, :3] = values
            return motions
        position, velocity = values[:, 0, HEAVE], values[:, 1, HEAVE]
        if not self._begun:
            self._oscillator.start(position[0], velocity[0])
            self._begun = True
        motions.six[:, :, HEAVE] = self._oscillator.run(position, velocity, np.zeros(len(there)))[:, :3]
        return motions
