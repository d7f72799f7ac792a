"""The shape of the seabed: an inclined plane, and on it heights along one horizontal direction.

Between the points of the profile the height is a monotone cubic (Fritsch & Carlson 1980): its slope is continuous, and
it rises and falls only where the points do. Beyond the ends it goes on level with them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import scipy
from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inner_kernel

from cable_sim_node.errors import StaticsError
from cable_sim_node.parameters import CableSimParameters, SeabedParameters

DISTANCE, HEIGHT, SLOPE = range(3)
PROFILE_COLUMNS = 3


class Seabed:
    """The bottom as the parameters shape it.

    Parameters
    ----------
    parameters : with a depth; without one there is no bottom, and nobody may ask

    Attributes
    ----------
    profile : shape (k, 3), rows of distance along its direction [m], height above the plane [m] and slope; no row
        where the bottom is a plane
    direction : unit vector of the profile, x and y
    """

    def __init__(self, parameters: SeabedParameters) -> None:
        points = parameters.profile
        self._depth, self._slope, self._is_deck = parameters.depth, parameters.slope, parameters.deck
        self.direction = (math.cos(points.direction), math.sin(points.direction))
        self.profile: Array = np.zeros((len(points.distance), PROFILE_COLUMNS))
        if points.distance:
            self.profile[:, DISTANCE], self.profile[:, HEIGHT] = points.distance, points.height
            slopes = scipy.interpolate.PchipInterpolator(points.distance, points.height).derivative()(points.distance)
            self.profile[1:-1, SLOPE] = slopes[1:-1]  # 0 at the ends, beyond which it is level
            self._curve = scipy.interpolate.CubicHermiteSpline(*self.profile.T)

    def height(self, position: Sequence[float] | Array, boom_tip: float = 0.0) -> float:
        """Return z of the bottom [m] below or above a `position`, of which x and y count [m].

        A deck is below z of the `boom_tip` [m].
        """
        x, y = float(position[0]), float(position[1])
        plane = self._slope[0] * x + self._slope[1] * y - self._depth + self._is_deck * boom_tip
        if not len(self.profile):
            return plane
        s = self.direction[0] * x + self.direction[1] * y
        first, last = self.profile[0, DISTANCE], self.profile[-1, DISTANCE]
        return plane + float(self._curve(min(max(s, first), last)))

    def clearance(self, position: Sequence[float] | Array, boom_tip: float = 0.0) -> float:
        """Return how high a `position` [m] is above the bottom [m], along z; negative below it.

        A deck is below z of the `boom_tip` [m].
        """
        return float(position[2]) - self.height(position, boom_tip)


@inner_kernel
def height_and_slope(at: float, table: Array, first: int, rows: int) -> tuple[float, float]:
    """Return height [m] and slope of a profile `at` a distance [m].

    `table` holds its rows, distance, height and slope, one after the other from index `first` on.
    """
    if rows == 0:
        return 0.0, 0.0
    low, high = 0, rows - 1
    if at <= table[first + 3 * low]:
        return table[first + 3 * low + 1], 0.0
    if at >= table[first + 3 * high]:
        return table[first + 3 * high + 1], 0.0
    while high - low > 1:
        middle = (low + high) // 2
        if table[first + 3 * middle] <= at:
            low = middle
        else:
            high = middle
    i, j = first + 3 * low, first + 3 * high
    size = table[j] - table[i]
    t = (at - table[i]) / size
    rise, a, b = table[j + 1] - table[i + 1], size * table[i + 2], size * table[j + 2]
    height = table[i + 1] + t * (a + t * (3.0 * rise - 2.0 * a - b + t * (a + b - 2.0 * rise)))
    slope = (a + t * (6.0 * rise - 4.0 * a - 2.0 * b + 3.0 * t * (a + b - 2.0 * rise))) / size
    return height, slope


def clearance_of(parameters: CableSimParameters, unit: Array) -> float | None:
    """Return the height [m] of a `unit` at x, y, z [m] above the seabed of the `parameters`, None where there is none.

    Raises StaticsError for a unit below the seabed.
    """
    seabed = parameters.seabed
    if not seabed.depth > 0.0:
        return None
    clearance = Seabed(seabed).clearance(unit)
    if clearance < 0.0:
        raise StaticsError(
            f"the unit would hang {-clearance:.3g} m below the seabed: reduce length ({parameters.length:g} m) "
            f"or increase seabed.depth ({seabed.depth:g} m)"
        )
    return clearance
