"""The current: a profile over depth, straight between its points and constant beyond them."""

from __future__ import annotations

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inner_kernel, kernel
from numpy.typing import ArrayLike

from cable_sim_node.errors import StaticsError
from cable_sim_node.parameters import CableSimParameters
from cable_sim_node.physics.drag import Vector

# Columns of a profile: depth [m], positive down; velocity [m/s].
DEPTH, FLOW = 0, 1
PROFILE_COLUMNS = 4


class Current:
    """A steady current over depth.

    Parameters
    ----------
    velocities : [m/s], shape (k, 2) or (k, 3) for k depths, or one velocity for all depths
    depths : [m], increasing, positive down from the frame's origin; not needed for one velocity

    Attributes
    ----------
    profile : shape (k, 4), rows of depth and velocity x, y, z, as the compiled functions take it

    Raises
    ------
    StaticsError
        for values that are not finite, depths that do not increase, or another number of velocities than of depths.
    """

    def __init__(self, velocities: ArrayLike = (0.0, 0.0, 0.0), depths: ArrayLike = (0.0,)) -> None:
        given = np.atleast_2d(np.asarray(velocities, dtype=np.float64))
        levels = np.atleast_1d(np.asarray(depths, dtype=np.float64))
        if given.ndim != 2 or given.shape[1] not in {2, 3} or len(given) != len(levels):
            raise StaticsError(f"a current needs one velocity (x, y) for each depth; got shape {given.shape}")
        if not (np.all(np.isfinite(given)) and np.all(np.isfinite(levels))):
            raise StaticsError("depths and velocities of a current must be finite")
        if np.any(np.diff(levels) <= 0.0):
            raise StaticsError("the depths of a current must be strictly increasing")
        self.profile: Array = np.zeros((len(given), PROFILE_COLUMNS))
        self.profile[:, DEPTH] = levels
        self.profile[:, FLOW : FLOW + given.shape[1]] = given

    def at(self, depth: float) -> Array:
        """Return the velocity at a depth [m/s], shape (3,)."""
        return np.array(current_at(depth, self.profile, 1.0)[0])

    def shifted(self, velocity: ArrayLike) -> Current:
        """Return this current as seen from a frame that moves at `velocity` [m/s]."""
        frame = np.zeros(3)
        frame[: len(np.atleast_1d(velocity))] = velocity
        return Current(self.profile[:, FLOW:] - frame, self.profile[:, DEPTH])

    @property
    def is_still(self) -> bool:
        """Whether the water is at rest everywhere."""
        return not bool(np.any(self.profile[:, FLOW:]))


def current_of(parameters: CableSimParameters) -> Current:
    """Return the current of the parameters."""
    profile = parameters.current_profile
    if not profile.depth:
        return Current(parameters.current)
    return Current(np.column_stack((profile.velocity_x, profile.velocity_y)), profile.depth)


@inner_kernel
def locate(at: float, table: Array) -> tuple[int, int, float]:
    """Return the two rows of `table` around `at` in its increasing first column, and the share of the way between them.

    Beyond the ends both rows are the same.
    """
    low, high = 0, table.shape[0] - 1
    if at <= table[low, 0]:
        return low, low, 0.0
    if at >= table[high, 0]:
        return high, high, 0.0
    while high - low > 1:
        middle = (low + high) // 2
        if table[middle, 0] <= at:
            low = middle
        else:
            high = middle
    return low, high, (at - table[low, 0]) / (table[high, 0] - table[low, 0])


@inner_kernel
def between(table: Array, low: int, high: int, share: float, column: int) -> float:
    """Return a column's value in `table` where `locate` found it: between rows `low` and `high`, at `share`."""
    return table[low, column] + share * (table[high, column] - table[low, column])


@kernel
def current_at(depth: float, profile: Array, factor: float) -> tuple[Vector, Vector]:
    """Return the current [m/s] and its derivative by depth [1/s] at `depth` [m]; `factor` multiplies the profile."""
    low, high, share = locate(depth, profile)
    flow = (
        factor * between(profile, low, high, share, FLOW),
        factor * between(profile, low, high, share, FLOW + 1),
        factor * between(profile, low, high, share, FLOW + 2),
    )
    if low == high:
        return flow, (0.0, 0.0, 0.0)
    size = profile[high, DEPTH] - profile[low, DEPTH]
    return flow, (
        factor * (profile[high, FLOW] - profile[low, FLOW]) / size,
        factor * (profile[high, FLOW + 1] - profile[low, FLOW + 1]) / size,
        factor * (profile[high, FLOW + 2] - profile[low, FLOW + 2]) / size,
    )
