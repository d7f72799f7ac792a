"""The linear answer of unit and cable to a Gaussian sea: quadratic drag by stochastic linearisation.

The linear damping that minimises the mean square error for a Gaussian speed of standard deviation s about a mean v is
the mean slope of v|v| (Roberts and Spanos, Random Vibration and Statistical Linearization, 1990, section 5.3):

    c = drag E[2 |v + x|] = drag (2 sqrt(2/pi) s exp(-v^2/(2 s^2)) + 2 v erf(v/(s sqrt(2))))

Without a mean it is sqrt(8/pi) drag s (Borgman 1967). s is that of each place of the cable, found by iteration.
"""

from __future__ import annotations

import numpy as np
from heave_node.numerics.arrays import Array
from scipy.special import erf

from cable_sim_node.physics.drag import HARMONIC_DRAG
from cable_sim_node.vertical.axial_line import AxialLine
from cable_sim_node.vertical.linear import DRAG_ITERATIONS, DRAG_PIECES, HeaveTransfer, divide, march


def sea_transfer_function(
    line: AxialLine, length: float, omegas: Array, density: Array, *, speed: float = 0.0
) -> HeaveTransfer:
    """Return the transfer functions boom tip to unit heave and to top tension in a Gaussian sea.

    Parameters
    ----------
    line : cable and unit
    length : unstretched length out [m]
    omegas : evenly spaced, positive [rad/s], shape (k,)
    density : one-sided spectrum of the boom tip's heave [m^2 s/rad], shape (k,)
    speed : mean speed of the unit through the water, either way [m/s]
    """
    pieces = [part for piece in line.pieces(length) for part in divide(piece, length / DRAG_PIECES)]
    weight = omegas**2 * density * (omegas[1] - omegas[0])
    sigma = np.full(len(pieces) + 1, np.sqrt(float(weight.sum())))
    for _ in range(DRAG_ITERATIONS):
        moved = march(line, pieces, omegas, _amplitudes(sigma, abs(speed), omegas.size))
        ratio = np.abs(moved.heave / moved.boom_tip) ** 2
        local = np.sqrt(ratio @ weight)
        found = np.concatenate((local[:1], 0.5 * (local[1:] + local[:-1])))
        if float(np.max(np.abs(found - sigma))) < 1e-4 * float(found.max()):
            break
        sigma = np.sqrt(sigma * found)
    return HeaveTransfer(omegas, 1.0 / moved.boom_tip, moved.top_tension / moved.boom_tip)


def gaussian_drag(sigma: Array, speed: float) -> Array:
    """Return the linear damping over the quadratic drag, E[2 |v + x|] [m/s].

    Parameters
    ----------
    sigma : standard deviation of the speed [m/s], any shape
    speed : its mean, not negative [m/s]
    """
    spread = np.maximum(sigma, 1e-12)
    share = speed / spread
    return np.asarray(
        2.0 * np.sqrt(2.0 / np.pi) * spread * np.exp(-0.5 * share**2) + 2.0 * speed * erf(share / np.sqrt(2.0))
    )


def _amplitudes(sigma: Array, speed: float, count: int) -> Array:
    """Return the harmonic speed amplitudes of equal damping, shape (places, count)."""
    return np.repeat(gaussian_drag(sigma, speed)[:, None] / HARMONIC_DRAG, count, axis=1)
