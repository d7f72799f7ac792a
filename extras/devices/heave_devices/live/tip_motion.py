"""The boom tip's heave from that of a motion sensor elsewhere on the ship: rigid-body motion by roll and pitch.

z_tip = heave - x sin(pitch) + (y sin(roll) + z cos(roll)) cos(pitch), less its value at rest; roll about x forward,
then pitch about y to port (REP-103), arm x, y, z from the sensor. The rate follows by the chain rule from the turn
rates, or, where the sensor has none, from the attitude of the last 0.6 s. A heave is about its mean: of the arm's share
a running mean is taken out, so that trim and list do not lift the tip.
"""

from __future__ import annotations

import math

from heave_node.numerics.kinematics import height_of, height_rate_of
from heave_node.sensing.recent_motion import RecentMotion

FIRST_MEAN_TIME, MEAN_TIME = 20.0, 300.0
"""Time constant of the running mean [s]: it grows from the one to the other with the time since the start."""


class TipMotion:
    """Carries heave to the boom tip.

    Parameters
    ----------
    arm : boom tip from the sensor, x forward, y to port, z up [m]
    """

    def __init__(self, arm: tuple[float, float, float]) -> None:
        self._arm = arm
        self._is_here = not any(arm)
        self._mean = 0.0
        self._first = self._last = math.nan
        self._recent = RecentMotion()

    def carry(
        self, time: float, heave: float, rate: float, attitude: tuple[float, float], turning: tuple[float, float]
    ) -> tuple[float, float]:
        """Return heave and heave rate of the boom tip [m], [m/s]; NaN where they are not known.

        Parameters
        ----------
        time : of the sample [s]
        heave, rate : of the sensor [m], [m/s]; NaN: not measured
        attitude, turning : roll and pitch [rad], and their rates [rad/s]; NaN: not measured
        """
        if self._is_here:
            return heave, rate
        share = height_of(self._arm, *attitude) - self._arm[2]
        if not math.isfinite(share):
            return math.nan, math.nan
        self._recent.add(time, share)
        turned = height_rate_of(self._arm, *attitude, turning)
        if not math.isfinite(turned):
            recent = self._recent.at(time)
            turned = math.nan if recent is None else recent[1]
        self._update_mean(time, share)
        return heave + share - self._mean, rate + turned

    def _update_mean(self, time: float, share: float) -> None:
        if not math.isfinite(self._first):
            self._first = self._last = time
            self._mean = share
            return
        step, self._last = max(time - self._last, 0.0), max(time, self._last)
        span = min(max(time - self._first, FIRST_MEAN_TIME), MEAN_TIME)
        self._mean += (share - self._mean) * min(step / span, 1.0)
