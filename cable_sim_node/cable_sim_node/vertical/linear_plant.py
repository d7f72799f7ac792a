"""The two-state plant of thesis Eq. 6.2 with the interface of `CableDynamics`: what the theory of chapter 6 is about.

Unit heave x about its rest obeys a x'' + b x' + x = x_0 - u, x_0 the heave of the boom tip about its start and u the
payout. It is solved exactly for boom tip and payout that run as cubics. The unit stays below the boom tip; there is no
seabed, no current and no slack. The tension is the static one plus EA/L times the stretch beyond rest, reported as 0
where that is negative.
"""

from __future__ import annotations

import numpy as np
import scipy
from heave_node.numerics.arrays import Array
from heave_node.numerics.kinematics import PointMotion
from numpy.typing import ArrayLike

from cable_sim_node.errors import BadMotionError, refuse_jump
from cable_sim_node.parameters import CableSimParameters


class LinearPlant:
    """Unit on a cable as a linear oscillator, frame `world` (z up), SI units.

    Parameters
    ----------
    parameters : length, axial stiffness and weights, for rest position and tension
    inertia, damping : a [s^2] and b [s] of thesis Eq. 6.2
    """

    touchdown = False
    touchdown_force = 0.0
    compensator_stroke = 0.0

    def __init__(self, parameters: CableSimParameters, *, inertia: float, damping: float) -> None:
        self._inertia = inertia
        self._damping = damping
        self._length = parameters.length
        self._stiffness = parameters.cable.axial_stiffness / parameters.length
        density, gravity = parameters.water_density, parameters.gravity
        cable_weight = parameters.cable.weight_in_fluid(density, gravity) * parameters.length
        unit_weight = parameters.unit.weight_in_fluid(density, gravity)
        self._static_tension = unit_weight + cable_weight
        self._rest_stretch = (unit_weight + 0.5 * cable_weight) / self._stiffness
        self._system = np.array([[0.0, 1.0], [-1.0 / inertia, -damping / inertia]])
        self._transition = np.eye(2)
        self._duration = 0.0
        self.start_at_equilibrium(np.zeros(3), 0.0)

    def start_at_equilibrium(self, boom_tip_position: ArrayLike, payout: float, *, time: float = 0.0) -> None:
        """Hang the unit at rest below `boom_tip_position` [m], shape (3,), with `payout` [m] let out, at any `time`."""
        del time  # nothing changes with it
        self._tip = np.array(boom_tip_position, dtype=float)
        self._tip_velocity = np.zeros(3)
        self._tip_acceleration = np.zeros(3)
        self._start_height = float(self._tip[2])
        self._payout = payout
        self._state = np.array([-payout, 0.0])
        self._acceleration = 0.0

    def advance(
        self,
        duration: float,
        tip_start: PointMotion,
        tip_end: PointMotion,
        payout_start: float,
        payout_rate_start: float,
        payout_end: float,
        payout_rate_end: float,
    ) -> None:
        """See `CableDynamics.advance`; the line always follows."""
        numbers = [duration, payout_start, payout_rate_start, payout_end, payout_rate_end]
        motions = [tip_start.position, tip_start.velocity, tip_end.position, tip_end.velocity]
        if duration <= 0.0 or not np.isfinite(numbers).all() or not np.isfinite(motions).all():
            raise BadMotionError("boom tip and payout must be finite numbers and the duration positive")
        refuse_jump(self._payout, payout_start)
        forcing = _cubic(
            duration,
            tip_start.position[2] - self._start_height - payout_start,
            tip_start.velocity[2] - payout_rate_start,
            tip_end.position[2] - self._start_height - payout_end,
            tip_end.velocity[2] - payout_rate_end,
        )
        particular = self._particular(forcing)
        slope = particular[1:] * np.array([1.0, 2.0, 3.0])
        start = np.array([particular[0], slope[0]])
        end = np.array([_value(particular, duration), _value(slope, duration)])
        self._state = end + self._transition_over(duration) @ (self._state - start)
        self._acceleration = float(
            (_value(forcing, duration) - self._state[0] - self._damping * self._state[1]) / self._inertia
        )
        self._tip, self._tip_velocity = tip_end.position.copy(), tip_end.velocity.copy()
        self._tip_acceleration = tip_end.acceleration.copy()
        self._payout = payout_end

    def unit_motion(self) -> tuple[Array, Array, Array]:
        """Return position [m], velocity [m/s] and acceleration [m/s^2] of the unit, shape (3,) each."""
        rest = self._start_height - self._length - self._rest_stretch
        position, velocity, acceleration = self._tip.copy(), self._tip_velocity.copy(), self._tip_acceleration.copy()
        position[2], velocity[2], acceleration[2] = rest + self._state[0], self._state[1], self._acceleration
        return position, velocity, acceleration

    @property
    def top_tension(self) -> float:
        """Tension at the boom tip [N], never negative."""
        stretch = self._tip[2] - self._start_height - self._payout - self._state[0]
        return float(max(self._static_tension + self._stiffness * stretch, 0.0))

    @property
    def largest_top_tension(self) -> float:
        """The same: between two ticks nothing snaps [N]."""
        return self.top_tension

    @property
    def largest_strain(self) -> float:
        """Strain of a cable without weight under the top tension [-]."""
        return self.top_tension / (self._stiffness * self._length)

    def nodes_and_tensions(self) -> tuple[Array, Array]:
        """Return the positions of unit and boom tip [m], shape (2, 3), and the tension between them [N], shape (1,)."""
        return np.array([self.unit_motion()[0], self._tip]), np.array([self.top_tension])

    @property
    def slack_segments(self) -> int:
        """Number of segments that carry no tension."""
        return int(self.top_tension == 0.0)

    @property
    def unstretched_length(self) -> float:
        """Unstretched length between unit and boom tip [m]."""
        return self._length + self._payout

    def _particular(self, forcing: Array) -> Array:
        """Return the polynomial p with a p'' + b p' + p = forcing, coefficients of powers 0 to 3."""
        a, b = self._inertia, self._damping
        p = forcing.copy()
        p[2] -= 3.0 * b * p[3]
        p[1] -= 2.0 * b * p[2] + 6.0 * a * p[3]
        p[0] -= b * p[1] + 2.0 * a * p[2]
        return p

    def _transition_over(self, duration: float) -> Array:
        if duration != self._duration:
            self._duration = duration
            self._transition = np.asarray(scipy.linalg.expm(self._system * duration))
        return self._transition


def _cubic(duration: float, start: float, start_rate: float, end: float, end_rate: float) -> Array:
    """Return the coefficients (powers 0 to 3) of the cubic with these values and rates at 0 and `duration`."""
    rise = (end - start) / duration
    return np.array(
        [
            start,
            start_rate,
            (3.0 * rise - 2.0 * start_rate - end_rate) / duration,
            (start_rate + end_rate - 2.0 * rise) / duration**2,
        ]
    )


def _value(coefficients: Array, at: float) -> float:
    return float(np.polynomial.polynomial.polyval(at, coefficients))
