"""How the ship responds to what hangs at the boom tip: heave, roll and pitch by hydrostatics (thesis 1.3).

Each of the three is M q'' + B q' + C q = c F, with F the tension's change since the start, downwards at the boom tip,
and c its lever: 1 in heave, y in roll, -x in pitch. C is rho g A_w, D g GM_T, D g GM_L (Newman, Marine Hydrodynamics,
1977, section 6.16); M follows from the natural period. Sea and load add up: both are linear.
"""

from __future__ import annotations

import math

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.constants import SEAWATER_DENSITY, STANDARD_GRAVITY
from scipy.linalg import expm

from wave_vessel_node.parameters import LoadResponseParameters
from wave_vessel_node.vessel.motion import HEAVE, PITCH, ROLL, lever_arm_matrix

MOVED = [HEAVE, ROLL, PITCH]
Q, RATE, FORCE, FORCE_RATE = range(4)


class LoadResponse:
    """The motion that the tension adds to the ship's, from tick to tick.

    Parameters
    ----------
    parameters : of the ship's hydrostatics
    arm : boom tip from the ship's reference point [m], shape (3,)
    tick_period : [s]
    is_tip : the boom tip itself is the reference point of the ship's motion, as of the second-order vessel: heave holds
        the part of roll and pitch there
    """

    def __init__(self, parameters: LoadResponseParameters, arm: Array, tick_period: float, *, is_tip: bool) -> None:
        self._tick_period, self._is_tip = tick_period, is_tip
        omega, damping = 2.0 * math.pi / np.array(parameters.natural_period), np.array(parameters.damping_ratio)
        self._lever = lever_arm_matrix(arm)[2, MOVED]
        self._slopes = np.zeros((3, 4, 4))  # of q, q', F and F' of each motion
        self._slopes[:, Q, RATE] = self._slopes[:, FORCE, FORCE_RATE] = 1.0
        self._slopes[:, RATE, Q], self._slopes[:, RATE, RATE] = -(omega**2), -2.0 * damping * omega
        self._slopes[:, RATE, FORCE] = omega**2 / stiffness_of(parameters)
        self._step = np.array([expm(tick_period * one) for one in self._slopes])
        self._state = np.zeros((3, 4))
        self._static = self._last = math.nan

    def step(self, tension: float) -> Array:
        """Return what the motion and its two derivatives have of the load at the next tick, shape (3, 6).

        The force goes on over the tick as it went over the last one.

        Parameters
        ----------
        tension : of the cable at the boom tip now [N]; NaN: not known, as before
        """
        if math.isfinite(tension):
            last = self._last if math.isfinite(self._last) else tension
            self._static = self._static if math.isfinite(self._static) else tension
            self._state[:, FORCE] = -(tension - self._static) * self._lever
            self._state[:, FORCE_RATE] = -(tension - last) / self._tick_period * self._lever
            self._last = tension
        self._state = np.einsum("kij,kj->ki", self._step, self._state)
        accelerations = np.einsum("kij,kj->ki", self._slopes, self._state)[:, RATE]
        moved, six = np.vstack((self._state[:, :FORCE].T, accelerations)), np.zeros((3, 6))
        if self._is_tip:
            six[:, HEAVE] = moved @ self._lever
        else:
            six[:, MOVED] = moved
        return six


def stiffness_of(parameters: LoadResponseParameters) -> Array:
    """Return the hydrostatic stiffness by the `parameters` in heave [N/m], roll and pitch [N m/rad]."""
    weight = parameters.displacement * STANDARD_GRAVITY
    return np.array(
        [
            SEAWATER_DENSITY * STANDARD_GRAVITY * parameters.waterplane_area,
            *(weight * height for height in parameters.metacentric_height),
        ]
    )
