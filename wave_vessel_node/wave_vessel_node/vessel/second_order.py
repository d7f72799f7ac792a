"""The vessel as a second-order filter from wave elevation to boom-tip heave (thesis 6.3.2, Eq. 6.25)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from heave_node.numerics.constants import STANDARD_GRAVITY
from heave_node.numerics.linear_model import LinearModel, ModelError, interconnect, linear_model
from numpy.typing import ArrayLike, NDArray


@dataclass(frozen=True)
class SecondOrderVessel:
    """x0'' + 2 xi_v omega_v x0' + omega_v^2 x0 = K_v omega_v^2 eta."""

    natural_frequency: float  # omega_v [rad/s]
    damping_ratio: float  # xi_v [-]
    gain: float  # K_v [-]

    def response(self, omega: ArrayLike) -> NDArray[np.complex128]:
        """Return heave per elevation at `omega` [rad/s], convention e^{i omega t}."""
        omega = np.asarray(omega, dtype=float)
        natural = self.natural_frequency
        denominator = natural**2 - omega**2 + 2j * self.damping_ratio * natural * omega
        return np.asarray(self.gain * natural**2 / denominator)

    def model(self) -> LinearModel:
        """Return Eq. 6.26 as state space: input wave_elevation [m], outputs boom_tip_heave [m] and boom_tip_heave_rate.

        Its states are heave and heave rate divided by K_v omega_v^2.
        """
        natural = self.natural_frequency
        scale = self.gain * natural**2
        return linear_model(
            [[0.0, 1.0], [-(natural**2), -2.0 * self.damping_ratio * natural]],
            states=("vessel_heave", "vessel_heave_rate"),
            inputs={"wave_elevation": [0.0, 1.0]},
            outputs={"boom_tip_heave": [scale, 0.0], "boom_tip_heave_rate": [0.0, scale]},
        )


def boom_tip_model(waves: LinearModel, vessel: SecondOrderVessel | None) -> LinearModel:
    """Return white noise to boom tip: a shaping filter and the vessel (thesis Eq. 6.23, 6.26).

    Parameters
    ----------
    waves : shaping filter with the output wave_elevation [m]
    vessel : None where the boom tip follows the surface

    Returns
    -------
    model : outputs wave_elevation [m], boom_tip_heave [m], boom_tip_heave_rate [m/s]; the vessel's states come first

    Raises ModelError where the boom tip follows a surface that has no rate (as many poles as zeros and one more).
    """
    if vessel is not None:
        return interconnect([vessel.model(), waves])
    elevation = waves.row("wave_elevation")
    if np.abs(elevation @ waves.G).max() > 1e-9 * float(np.linalg.norm(elevation) * np.linalg.norm(waves.G)):
        raise ModelError(
            "a boom tip that follows the sea needs a shaping filter with at least two more poles than zeros: the rate "
            "of the elevation is white noise otherwise"
        )
    return waves.with_outputs({"boom_tip_heave": elevation, "boom_tip_heave_rate": elevation @ waves.A})


def wave_slope_response(omega: ArrayLike) -> NDArray[np.complex128]:
    """Return the wave slope along its travel per elevation in deep water, -i omega^2 / g (elevation cos(omega t - k
    x)).
    """
    return np.asarray(-1j * np.asarray(omega, dtype=float) ** 2 / STANDARD_GRAVITY)
