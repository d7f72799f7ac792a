"""Footprint: the part of the seabed that a thruster-driven unit on a cable can reach (thesis 2.2.4, problem 4).

Followed from the unit upwards a shape needs no iteration: thrust and the vertical pull on the unit give it, and where
it reaches the boom tip's height it gives the length and the place. So the boundary is swept directly: full thrust in
every direction, and the least vertical pull that the limits allow, for that lays the cable flattest.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from cable_sim_node.errors import NoEquilibriumError, StaticsError
from cable_sim_node.physics.current import Current
from heave_node.numerics.arrays import Array
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq

from heave_statics.problems import STILL_WATER
from heave_statics.shape import cut_at_height, shape_from
from heave_statics.system import StaticCable

PULL_LEVELS = 10
THRUST_LEVELS = (1.0, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1, 0.0)


@dataclass(frozen=True)
class FootprintLimits:
    """What bounds the footprint."""

    thrust: float  # largest horizontal thruster force [N]
    tension: float  # largest tension at the boom tip [N]
    # largest vertical pull that the unit can take without lifting off, its weight in water and what its thrusters add
    # [N]; the least is 0, where the cable starts along the bottom
    vertical_pull: float


@dataclass(frozen=True)
class FootprintPoint:
    """A place on the boundary."""

    offset: Array  # from the boom tip's foot, x, y [m]
    thrust: Array  # x, y [N]
    vertical_pull: float  # of the cable on the unit [N]
    length: float  # unstretched length out [m]
    tension: float  # at the boom tip [N]
    strain: float  # largest of the cable that is out [-]


@dataclass(frozen=True)
class Footprint:
    """Boundary of the reachable area."""

    points: tuple[FootprintPoint, ...]  # one for each direction of thrust, in order around the boundary
    headings: Array  # [rad] from x towards y
    # farthest reachable distance from the boom tip's foot along each heading [m], 0 where `is_reachable` is False:
    # strong current can carry the whole area away from under the ship
    radius: Array
    is_reachable: NDArray[np.bool_]  # whether the heading meets the area at all
    largest_strain: float  # of the cable anywhere on the boundary [-]


def footprint(
    cable: StaticCable,
    boom_tip: ArrayLike,
    unit_height: float,
    limits: FootprintLimits,
    current: Current = STILL_WATER,
    *,
    headings: int = 36,
    directions: int = 120,
) -> Footprint:
    """Return the outer boundary of the area that the unit can reach on the plane z = `unit_height`.

    Parameters
    ----------
    cable : the whole cable on board, s = 0 at the unit; the unit's drag is a point load at label 0, its weight is not
    boom_tip : position [m], z up
    unit_height : z of the unit [m]
    limits : thrust, tension and vertical pull; the limit of the length is that of `cable`
    current : steady current
    headings : how many, evenly spaced from 0
    directions : of thrust that are swept

    Raises
    ------
    StaticsError
        for limits that are not positive.
    NoEquilibriumError
        if no place can be reached within the limits.
    """
    if not min(limits.thrust, limits.tension, limits.vertical_pull) > 0.0:
        raise StaticsError(
            f"thrust, tension and vertical pull must be positive; got {limits.thrust:g}, {limits.tension:g} and "
            f"{limits.vertical_pull:g} N"
        )
    tip = np.asarray(boom_tip, dtype=np.float64)
    sweep = _Sweep(cable, tip, unit_height, limits, current)
    angles = np.linspace(0.0, 2.0 * np.pi, directions, endpoint=False, dtype=np.float64)
    outlines: list[list[FootprintPoint]] = []
    for level in THRUST_LEVELS:
        outline = [point for angle in angles if (point := sweep.farthest(level, float(angle))) is not None]
        if outline:
            outlines.append(outline)
        if len(outline) == directions and not any(point.tension > 0.999 * limits.tension for point in outline):
            break  # less thrust helps only where the tension is the limit
    if not outlines:
        raise NoEquilibriumError(
            f"no position {tip[2] - unit_height:g} m below the boom tip can be reached with {cable.length:g} "
            "m of cable,"
            f" {limits.tension:g} N of tension and {limits.vertical_pull:g} N of vertical pull"
        )
    rays = np.linspace(0.0, 2.0 * np.pi, headings, endpoint=False, dtype=np.float64)
    reach = np.array([max(_ray(outline, float(ray)) for outline in outlines) for ray in rays])
    strain = max(point.strain for outline in outlines for point in outline)
    return Footprint(tuple(outlines[0]), rays, np.maximum(reach, 0.0), reach >= 0.0, strain)


@dataclass(frozen=True)
class _Sweep:
    """The search along the boundary.

    `level` is the thrust over its limit, `angle` its direction from x towards y [rad], `pull` the vertical pull of the
    cable on the unit [N].
    """

    cable: StaticCable
    tip: Array
    unit_height: float
    limits: FootprintLimits
    current: Current

    def farthest(self, level: float, angle: float) -> FootprintPoint | None:
        """Return the place where thrust `level` of its limit in direction `angle` holds the flattest legal cable."""
        pulls = self.limits.vertical_pull * np.linspace(0.0, 1.0, PULL_LEVELS + 1) ** 2
        excess = self.excess(level, angle, 0.0)
        if excess > 0.0:
            for low, high in itertools.pairwise(pulls):
                if self.excess(level, angle, float(high)) <= 0.0:
                    pull = float(brentq(lambda p: self.excess(level, angle, p), low, high, xtol=1e-9 * high))
                    return self.place(level, angle, pull)[0]
            return None
        return self.place(level, angle, 0.0)[0]

    def excess(self, level: float, angle: float, pull: float) -> float:
        """Return by how much the worst limit is passed, over that limit; 0 or less is legal."""
        return self.place(level, angle, pull)[1]

    def place(self, level: float, angle: float, pull: float) -> tuple[FootprintPoint | None, float]:
        """Return where the unit is, None out of the cable's reach, and by how much the worst limit is passed."""
        thrust = self.limits.thrust * level * np.array([np.cos(angle), np.sin(angle)])
        origin = np.array([0.0, 0.0, self.unit_height])
        # a trace of vertical pull gives a cable without any tension a direction
        start = np.array([-thrust[0], -thrust[1], pull + 1e-9 * self.limits.vertical_pull])
        shape = shape_from(self.cable, self.current, origin, start)
        if shape is None:
            return None, np.inf
        crossing = cut_at_height(shape, float(self.tip[2]))
        if crossing is None:
            rise = float(shape.positions[-1, 2] - self.unit_height)
            return None, 1.0 - rise / float(self.tip[2] - self.unit_height)
        tension = float(np.linalg.norm(crossing.tension))
        point = FootprintPoint(-crossing.position[:2], thrust, pull, crossing.label, tension, crossing.strain)
        return point, max(crossing.label / self.cable.length, tension / self.limits.tension) - 1.0


def _ray(outline: list[FootprintPoint], heading: float) -> float:
    """Return the farthest crossing of a ray from the origin with the closed outline, -1 if there is none."""
    corners = np.array([point.offset for point in outline])
    along = corners @ np.array([np.cos(heading), np.sin(heading)])
    across = corners @ np.array([-np.sin(heading), np.cos(heading)])
    next_along, next_across = np.roll(along, -1), np.roll(across, -1)
    crosses = (across >= 0.0) != (next_across >= 0.0)
    if not np.any(crosses):
        return -1.0
    share = across[crosses] / (across[crosses] - next_across[crosses])
    reach = along[crosses] + share * (next_along[crosses] - along[crosses])
    return float(reach.max())
