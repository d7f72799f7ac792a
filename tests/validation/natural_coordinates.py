"""The cable in natural coordinates: the thesis's appendix 12.5, Eqs. 12.32 to 12.50.

Unit vectors (12.32): z' along the cable, tangent (cos phi cos theta, cos phi sin theta, sin phi); y' across it in the
vertical plane, x' horizontal. A vertical cable has no theta: these coordinates serve inclined cables only. The state
is Y = (strain, phi, theta, V_z', V_y', V_x'), s the unstretched length.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from heave_node.numerics.arrays import Array


def rotation(phi: Array | float, theta: Array | float) -> Array:
    """Return Tr of Eq. 12.32, from world to x', y', z', shape (..., 3, 3)."""
    sp, cp, st, ct = np.sin(phi), np.cos(phi), np.sin(theta), np.cos(theta)
    rows = [[st, -ct, 0.0 * st], [sp * ct, sp * st, -cp], [cp * ct, cp * st, sp]]
    return np.moveaxis(np.array(rows, dtype=float), (0, 1), (-2, -1))


def system_matrices(y: Array, mu: Array, tension: float, slope: float) -> tuple[Array, Array]:
    """Return A and B of Eq. 12.42 as printed.

    Parameters
    ----------
    y : strain, phi, theta, V_z, V_y, V_x
    mu : mass with added mass along x', y', z' [kg/m]
    tension, slope : T [N] and its derivative by the strain [N]
    """
    strain, phi, _, vz, vy, vx = y
    mx, my, mz = mu
    sp, cp = np.sin(phi), np.cos(phi)
    a, b = np.zeros((6, 6)), np.zeros((6, 6))
    a[0, 1:4] = my * vy, mx * vx * cp, mz
    a[1, 1:5] = -mz * vz, mx * vx * sp, 0.0, my
    a[2, 2], a[2, 5] = -my * vy * sp - mz * vz * cp, mx
    a[3, 0], a[4, 1], a[5, 2] = -1.0, 1.0 + strain, (1.0 + strain) * cp
    b[0, 0], b[1, 1], b[2, 2] = -slope, tension, tension * cp
    b[3, 1:4] = vy, vx * cp, 1.0
    b[4, 1:5] = -vz, vx * sp, 0.0, 1.0
    b[5, 2], b[5, 5] = -(vy * sp + vz * cp), 1.0
    return a, b


class NaturalCable:
    """A cable between a fixed lower end and a moving top end, by Eq. 12.41 on a staggered grid: second order in s.

    Strain and angles belong to the middles of the cells, velocities to their ends; Runge-Kutta of fourth order in time.
    All of the mass is the cable's own (mu alike in all directions), there is no weight.

    Parameters
    ----------
    cells : of the grid
    length, stiffness, mass : unstretched [m], EA [N], per metre [kg/m]
    drag : (1/2) rho C_N d and (pi/2) rho C_tau d [kg/m^2]
    tension : at the start [N], along the straight line
    direction : phi and theta of that line [rad]
    """

    def __init__(
        self,
        cells: int,
        *,
        length: float,
        stiffness: float,
        mass: float,
        drag: tuple[float, float],
        tension: float,
        direction: tuple[float, float],
    ) -> None:
        self._h, self._stiffness, self._mass, self._drag = length / cells, stiffness, mass, drag
        self.shape: Array = np.zeros((cells, 3))
        """Strain, phi, theta of each cell."""
        self.shape[:] = tension / stiffness, *direction
        self.velocity: Array = np.zeros((cells + 1, 3))
        """V_x', V_y', V_z' of each end of a cell [m/s]."""

    def advance(self, start: float, end: float, steps: int, top: Callable[[float], Array]) -> None:
        """Integrate over so many equal steps; `top` gives the velocity of the top end in the world at a time [m/s]."""
        dt = (end - start) / steps
        for k in range(steps):
            t, y = start + k * dt, (self.shape, self.velocity)
            k1 = self._rates(*y, top(t))
            k2 = self._rates(*_moved(y, k1, 0.5 * dt), top(t + 0.5 * dt))
            k3 = self._rates(*_moved(y, k2, 0.5 * dt), top(t + 0.5 * dt))
            k4 = self._rates(*_moved(y, k3, dt), top(t + dt))
            mean = [(a + 2.0 * b + 2.0 * c + d) / 6.0 for a, b, c, d in zip(k1, k2, k3, k4, strict=True)]
            self.shape, self.velocity = _moved(y, mean, dt)

    def positions(self) -> Array:
        """Return the ends of the cells [m] from the lower end, by Eq. 12.34."""
        strain, phi, theta = self.shape.T
        tangent = rotation(phi, theta)[:, 2]
        return np.vstack((np.zeros(3), np.cumsum(self._h * (1.0 + strain)[:, None] * tangent, axis=0)))

    def tensions(self) -> Array:
        """Return the tension of each cell [N]."""
        return self._stiffness * self.shape[:, 0]

    def _rates(self, shape: Array, velocity: Array, top: Array) -> tuple[Array, Array]:
        h, ends = self._h, self._at_ends(shape)
        velocity = velocity.copy()
        velocity[0], velocity[-1] = 0.0, rotation(ends[-1, 1], ends[-1, 2]) @ top
        strain, phi, theta = shape.T
        # the last three of Eq. 12.41, in the middle of each cell
        vx, vy, vz = (0.5 * (velocity[1:] + velocity[:-1])).T
        vx_s, vy_s, vz_s = (np.diff(velocity, axis=0) / h).T
        phi_s, theta_s = (np.diff(ends[:, 1:], axis=0) / h).T
        sp, cp = np.sin(phi), np.cos(phi)
        turning = np.empty_like(shape)
        turning[:, 0] = vz_s + vx * cp * theta_s + vy * phi_s
        turning[:, 1] = (-vy_s - vx * sp * theta_s + vz * phi_s) / (1.0 + strain)
        turning[:, 2] = (-vx_s + (vy * sp + vz * cp) * theta_s) / ((1.0 + strain) * cp)
        # the first three, at each end of a cell but the first and the last
        tension = self._stiffness * strain
        tension_s, phi_s, theta_s = (np.diff(np.column_stack((tension, phi, theta)), axis=0) / h).T
        _, phi_t, theta_t = (0.5 * (turning[1:] + turning[:-1])).T
        vx, vy, vz = velocity[1:-1].T
        sp, cp, pull = np.sin(ends[1:-1, 1]), np.cos(ends[1:-1, 1]), 0.5 * (tension[1:] + tension[:-1])
        force = self._water(velocity[1:-1])
        change = np.zeros_like(velocity)
        change[1:-1, 0] = (force[:, 0] - pull * cp * theta_s) / self._mass + (vy * sp + vz * cp) * theta_t
        change[1:-1, 1] = (force[:, 1] - pull * phi_s) / self._mass - vx * sp * theta_t + vz * phi_t
        change[1:-1, 2] = (force[:, 2] + tension_s) / self._mass - vx * cp * theta_t - vy * phi_t
        return turning, change

    def _at_ends(self, shape: Array) -> Array:
        """Return strain and angles at the ends of the cells; straight on beyond the middles of the outer ones."""
        inner = 0.5 * (shape[1:] + shape[:-1])
        return np.vstack((1.5 * shape[0] - 0.5 * shape[1], inner, 1.5 * shape[-1] - 0.5 * shape[-2]))

    def _water(self, velocity: Array) -> Array:
        """Return the drag of still water along x', y', z' [N/m]: what these coordinates are for.

        As in the plant, without the factor sqrt(1 + strain) of Eq. 12.2, which a thinner cable has.
        """
        across = np.hypot(velocity[:, 0], velocity[:, 1])
        along = np.abs(velocity[:, 2])
        normal, tangential = self._drag
        return -velocity * np.column_stack((normal * across, normal * across, tangential * along))


def _moved(state: tuple[Array, Array], rates: tuple[Array, Array] | list[Array], dt: float) -> tuple[Array, Array]:
    return state[0] + dt * rates[0], state[1] + dt * rates[1]
