"""A network of cables: held points, free points with loads, cables between them (thesis 2.7; two cables to one load).

Each cable lies between its two ends as `submerged_cable` finds it, with the exact derivatives of its end forces. In
still water the potential energy is convex in the places of the free points, so that Newton with a line search on its
slope reaches the only equilibrium from any start. A current is then raised in steps, as for one cable.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from cable_sim_node.errors import NoEquilibriumError, StaticsError
from cable_sim_node.physics.current import FLOW, Current, current_at
from heave_node.numerics.arrays import Array
from numpy.typing import NDArray

from heave_statics.problems import STILL_WATER, submerged_cable
from heave_statics.shape import StaticShape
from heave_statics.system import PointLoad, StaticCable

ITERATIONS, HALVINGS = 80, 40
TOLERANCE = 1e-9
"""Force that is left on the free points, over the largest force on a cable's end, at which the search ends."""
SMALLEST_STEP = 2.0**-7
"""Smallest step of the current."""


@dataclass(frozen=True)
class NetworkPoint:
    """A point at which cables end; a `load` acts on a free one, its label has no part in it."""

    place: tuple[float, float, float] | None  # held there [m], z up; None: it is free
    load: PointLoad = PointLoad(0.0)  # noqa: RUF009 - frozen


@dataclass(frozen=True)
class NetworkCable:
    """A cable between two points."""

    start: str  # name of the point at s = 0
    end: str  # name of the point at s = L
    cable: StaticCable  # what it is made of


@dataclass(frozen=True)
class NetworkShape:
    """An equilibrium."""

    places: dict[str, Array]  # of all points, by name [m]
    shapes: tuple[StaticShape, ...]  # of the cables, in their order


def solve_network(
    points: Mapping[str, NetworkPoint], cables: Sequence[NetworkCable], current: Current = STILL_WATER
) -> NetworkShape:
    """Return the equilibrium of a network.

    Parameters
    ----------
    points : by name
    cables : between them
    current : steady current

    Raises
    ------
    StaticsError
        for a cable from a point to itself or to one that is not there, a free point that nothing holds, or a cable
        whose shape is not determined (see `submerged_cable`).
    NoEquilibriumError
        if the search does not end: nothing holds a free point up, or the current's answer cannot be reached.
    """
    network = _Network(points, cables)
    answer = network.search(network.begin(), STILL_WATER)
    if answer is None:
        raise NoEquilibriumError("network: no equilibrium was found in still water: is every free point held up?")
    reached, step = 0.0, 1.0
    while not current.is_still and reached < 1.0:
        share = min(1.0, reached + step)
        water = Current(share * current.profile[:, FLOW:], current.profile[:, 0])
        found = network.search(answer, water)
        if found is not None:
            reached, answer = share, found
            continue
        step *= 0.5
        if step < SMALLEST_STEP:
            raise NoEquilibriumError(f"network: no equilibrium was found above {100.0 * reached:.3g} % of the current")
    shapes = network.shapes(answer, current)
    assert shapes is not None, "an answer has shapes"
    return NetworkShape(network.places(answer), tuple(shapes))


class _Network:
    """The equations; `x` are the places of the free points in a row, shape (3 n,) [m]."""

    def __init__(self, points: Mapping[str, NetworkPoint], cables: Sequence[NetworkCable]) -> None:
        self._points, self._cables = points, cables
        self._free = [name for name, point in points.items() if point.place is None]
        for one in cables:
            for name in (one.start, one.end):
                if name not in points:
                    raise StaticsError(f"network: a cable ends at {name}, which is none of {', '.join(points)}")
            if one.start == one.end:
                raise StaticsError(f"network: a cable goes from {one.start} to itself")
        held = {name for name, point in points.items() if point.place is not None}
        for _ in self._free:
            held |= {end for one in cables for end in (one.start, one.end) if {one.start, one.end} & held}
        if loose := [name for name in self._free if name not in held]:
            raise StaticsError(f"network: no cable leads from {loose[0]} to a held point")
        if not cables:
            raise StaticsError("a network needs cables")

    def places(self, x: Array) -> dict[str, Array]:
        """Return the places of all points."""
        free = dict(zip(self._free, x.reshape(-1, 3), strict=True))
        return {name: free[name] if one.place is None else np.array(one.place) for name, one in self._points.items()}

    def begin(self) -> Array:
        """Return where the search begins: each free point in the middle of its neighbours, and a little off them."""
        x, shortest = np.zeros((len(self._free), 3)), min(one.cable.length for one in self._cables)
        for _ in range(4 * len(self._free) + 1):
            places = self.places(x.ravel())
            for row, name in zip(x, self._free, strict=True):
                ends = [{one.start: one.end, one.end: one.start} for one in self._cables]
                row[:] = np.mean([places[pair[name]] for pair in ends if name in pair], axis=0)
        x += 0.1 * shortest * np.arange(1, len(x) + 1)[:, None] / len(x) * np.array([0.1, 0.1, -1.0])
        return x.ravel()

    def shapes(self, x: Array, water: Current) -> list[StaticShape] | None:
        """Return the shapes of the cables; None where one of them is not found."""
        places = self.places(x)
        try:
            return [submerged_cable(one.cable, places[one.start], places[one.end], water) for one in self._cables]
        except NoEquilibriumError:
            return None

    def _loads(self, x: Array, water: Current) -> tuple[Array, Array]:
        """Return the loads on the free points, and minus their derivative by x, both of them as forces."""
        forces, slopes = np.zeros_like(x), np.zeros((len(x), len(x)))
        for index, name in enumerate(self._free):
            load, at = self._points[name].load, slice(3 * index, 3 * index + 3)
            flow, gradient = map(np.array, current_at(-float(x[at][2]), water.profile, 1.0))
            speed, axis = float(np.linalg.norm(flow)), np.array(load.axis_drag)
            forces[at] = np.array(load.force) + axis * np.abs(flow) * flow + load.body_drag * speed * flow
            by_depth = 2.0 * axis * np.abs(flow) * gradient + load.body_drag * speed * gradient
            by_depth += load.body_drag * (flow @ gradient) * flow / speed if speed > 0.0 else 0.0
            slopes[at, 3 * index + 2] = by_depth  # depth = -z
        return forces, slopes

    def forces(self, x: Array, water: Current) -> tuple[Array, Array, float] | None:
        """Return the pull at the free points [N], minus its derivative by x [N/m], the largest force on an end [N]."""
        shapes = self.shapes(x, water)
        if shapes is None:
            return None
        pull, stiffness = self._loads(x, water)
        largest = 0.0
        for one, shape in zip(self._cables, shapes, strict=True):
            ends = np.concatenate((shape.start_force, shape.end_force))
            largest = max(largest, float(np.abs(ends).max()))
            rows = np.concatenate([self._rows(one.start), self._rows(one.end)])
            is_free = rows >= 0
            pull[rows[is_free]] -= ends[is_free]
            stiffness[np.ix_(rows[is_free], rows[is_free])] += end_stiffness(shape)[np.ix_(is_free, is_free)]
        return pull, stiffness, largest

    def _rows(self, name: str) -> NDArray[np.int64]:
        """Return the rows of a point in x; -1 where it is held."""
        return np.arange(3) + 3 * self._free.index(name) if name in self._free else np.full(3, -1)

    def search(self, start: Array, water: Current) -> Array | None:
        """Return the equilibrium found from a `start` in this `water`; None if the search does not end."""
        x, here = start.copy(), self.forces(start, water)
        longest = sum(one.cable.length for one in self._cables)
        for _ in range(ITERATIONS):
            if here is None:
                return None
            pull, stiffness, largest = here
            if not x.size or float(np.abs(pull).max()) < TOLERANCE * largest:
                return x
            try:
                step = np.asarray(np.linalg.solve(stiffness, pull), dtype=np.float64)
            except np.linalg.LinAlgError:
                return None
            step *= min(1.0, longest / float(np.abs(step).max()))
            x, here = self._along(x, step, pull, water)
        return None

    def _along(
        self, x: Array, step: Array, pull: Array, water: Current
    ) -> tuple[Array, tuple[Array, Array, float] | None]:
        """Return the point along a `step` at which the slope of the energy has halved in size, and the forces there."""
        slope, low, high, share = abs(float(pull @ step)), 0.0, 1.0, 1.0
        for _ in range(HALVINGS):
            there = self.forces(x + share * step, water)
            left = -np.inf if there is None else float(there[0] @ step)
            if abs(left) <= 0.5 * slope or (share == 1.0 and 0.0 < left <= slope):
                break
            low, high = (low, share) if left < 0.0 else (share, high)
            share = 0.5 * (low + high)
        return x + share * step, there


def end_stiffness(shape: StaticShape) -> Array:
    """Return the derivative of the forces that hold both ends of a cable by the places of both ends [N/m], (6, 6).

    With the partials A, B, C, D of the `shape`, of place and force at s = L by place and tension at s = 0, it follows
    from dt0 = B^-1 (dxL - A dx0).
    """
    (A, B), (C, D) = np.split(shape.partials[:3], 2, axis=1), np.split(shape.partials[3:], 2, axis=1)
    inverse = np.linalg.inv(B)
    by_start, by_end = inverse @ A, inverse
    return np.block([[by_start, -by_end], [C - D @ by_start, D @ by_end]])
