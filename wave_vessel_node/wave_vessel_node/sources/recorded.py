"""A recording as the source of the boom tip's motion."""

from __future__ import annotations

import math

import numpy as np
import scipy

from wave_vessel_node.sources.motion_source import MotionSource
from wave_vessel_node.sources.recording import Recording, RecordingError, read_recording
from wave_vessel_node.sources.scene import Scene
from wave_vessel_node.vessel.motion import HEAVE, VesselMotions


def build(scene: Scene) -> MotionSource:
    """Return the source `file` of a scene; what was repaired in the file is added to the scene's warnings."""
    parameters = scene.parameters
    recording = read_recording(parameters.recording_file, accept_implausible=parameters.accept_implausible)
    scene.warnings.extend(recording.warnings)
    return RecordedSource(recording, scene.tick_period)


class RecordedSource(MotionSource):
    """Motion of the boom tip as it was recorded; the sea surface follows it.

    Between samples a cubic spline gives position, velocity and acceleration that fit one another.

    Parameters
    ----------
    recording : motion of the boom tip
    tick_period : [s]
    """

    def __init__(self, recording: Recording, tick_period: float) -> None:
        self._recording = recording
        self._spline = scipy.interpolate.CubicSpline(recording.time, recording.position)
        self._tick_period = tick_period

    def motions(self, ticks: range) -> VesselMotions:
        """See MotionSource. Raises RecordingError beyond the end of the recording."""
        last = self._recording.time[-1] + 1e-9
        there = range(ticks.start, next((tick for tick in ticks if tick * self._tick_period > last), ticks.stop))
        if not there:
            end = math.floor(self._recording.time[-1] / self._tick_period) * self._tick_period
            raise RecordingError(f"{self._recording.path}: ends after {end:g} s: give a shorter duration")
        motions = VesselMotions.still(there, self._tick_period)
        motions.six[:, :, :3] = np.stack([self._spline(motions.time, order) for order in range(3)], axis=1)
        motions.elevation = motions.six[:, 0, HEAVE].copy()
        return motions
