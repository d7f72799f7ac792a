"""The vessel as a second-order filter from wave elevation to boom-tip heave (thesis 6.3.2, Eq. 6.25)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from heave_node.constants import STANDARD_GRAVITY
from numpy.typing import ArrayLike, NDArray

from wave_vessel_node.sea.state_space import StateSpace


@dataclass(frozen=True)
class SecondOrderVessel:
    """x0'' + 2 xi_v omega_v x0' + omega_v^2 x0 = K_v omega_v^2 eta.

    Attributes
    ----------
    natural_frequency : omega_v [rad/s]; damping_ratio : xi_v; gain : K_v
    """

    natural_frequency: float
    damping_ratio: float
    gain: float

    def response(self, omega: ArrayLike) -> NDArray[np.complex128]:
        """Return heave per elevation at `omega` [rad/s], convention e^{i omega t}."""
        omega = np.asarray(omega, dtype=float)
        natural = self.natural_frequency
        denominator = natural**2 - omega**2 + 2j * self.damping_ratio * natural * omega
        return np.asarray(self.gain * natural**2 / denominator)

    def state_space(self) -> StateSpace:
        """Return Eq. 6.26: input elevation, outputs heave, heave rate; its states are heave and heave rate divided by
        K_v omega_v^2.
        """
        natural = self.natural_frequency
        A = np.array([[0.0, 1.0], [-(natural**2), -2.0 * self.damping_ratio * natural]])
        B = np.array([[0.0], [1.0]])
        C = self.gain * natural**2 * np.eye(2)
        return StateSpace(A, B, C, ("vessel_heave", "vessel_heave_rate"))


def vessel_filter(natural_frequency: float, damping_ratio: float, gain: float) -> StateSpace:
    """Return the second-order vessel of thesis Eq. 6.26 as state space: elevation [m] to boom-tip heave [m] and heave
    rate [m/s].
    """
    return SecondOrderVessel(natural_frequency, damping_ratio, gain).state_space()


def wave_slope_response(omega: ArrayLike) -> NDArray[np.complex128]:
    """Return the wave slope along its travel per elevation in deep water, -i omega^2 / g (elevation cos(omega t - k
    x)).
    """
    return np.asarray(-1j * np.asarray(omega, dtype=float) ** 2 / STANDARD_GRAVITY)
