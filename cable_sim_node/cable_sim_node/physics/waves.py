"""The regular wave of the parameters, as the waves of one component."""

from __future__ import annotations

import math

import numpy as np
from heave_node.interface.waves import NO_WAVES, Waves

from cable_sim_node.parameters import WaveKinematicsParameters


def regular_waves(wave: WaveKinematicsParameters) -> Waves:
    """Return the regular wave of the parameters, whose crests pass the origin at time 0; none for another source."""
    if wave.source != "regular" or wave.amplitude == 0.0:
        return NO_WAVES
    omega = np.array([2.0 * math.pi / wave.period])
    return Waves(omega, omega, np.array([wave.amplitude]), np.zeros(1), np.array([wave.direction]))
