"""What statics is given: sections of cable, point loads on it."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from cable_sim_node.errors import StaticsError
from heave_node.numerics.arrays import Array

from heave_statics.tables import (
    AXIS_DRAG,
    BODY_DRAG,
    FORCE,
    LENGTH,
    NODE_COLUMNS,
    NORMAL,
    SEGMENT_COLUMNS,
    STIFFNESS,
    TANGENTIAL,
    WEIGHT,
)


@dataclass(frozen=True)
class StaticSection:
    """A uniform piece of cable; all properties per unstretched metre."""

    length: float  # unstretched [m]
    axial_stiffness: float  # EA [N]
    weight: float  # in water, positive down [N/m]; negative floats, 0 is neutrally buoyant
    normal_drag: float = 0.0  # (1/2) rho C_N d (thesis Eq. 2.46) [N s2/m3]
    tangential_drag: float = 0.0  # (pi/2) rho C_tau d (thesis Eq. 2.47) [N s2/m3]


@dataclass(frozen=True)
class PointLoad:
    """A load at one point of the cable."""

    label: float  # unstretched length from the end s = 0 [m]; the ends themselves are allowed
    # steady force x, y, z [N]; a body's weight in water is (0, 0, -weight)
    force: tuple[float, float, float] = (0.0, 0.0, 0.0)
    # (1/2) rho C_D S of a unit along x, y, z, each with its own component of the current [N s2/m2]
    axis_drag: tuple[float, float, float] = (0.0, 0.0, 0.0)
    body_drag: float = 0.0  # (1/2) rho C_D S of an isotropic body [N s2/m2]


@dataclass(frozen=True)
class StaticCable:
    """A cable cut into segments, ready to be solved; make it with `static_cable`."""

    labels: Array  # unstretched length from s = 0 to each node, shape (n + 1,) [m]
    segments: Array  # see `tables`
    nodes: Array  # see `tables`
    feed: float = 0.0  # speed at which the cable runs along itself towards s = 0 [m/s]

    @property
    def length(self) -> float:
        """Unstretched length [m]."""
        return float(self.labels[-1])

    @property
    def steady_loads(self) -> Array:
        """Return shape (n, 3): weight of each segment per metre as a force [N/m]."""
        loads = np.zeros((len(self.segments), 3))
        loads[:, 2] = -self.segments[:, WEIGHT]
        return loads


def static_cable(
    sections: Sequence[StaticSection], loads: Sequence[PointLoad] = (), *, segments: int = 100, feed: float = 0.0
) -> StaticCable:
    """Cut a cable into segments of nearly equal length with nodes at every joint and point load.

    Parameters
    ----------
    sections : from the end s = 0 on
    loads : point loads
    segments : about this many in all (without current one for each piece between loads is exact)
    feed : speed at which the cable runs along itself towards s = 0 [m/s], as when it is laid

    Raises
    ------
    StaticsError
        for no cable, a length or stiffness that is not positive, or a load beyond the cable.
    """
    if not sections or segments < 1:
        raise StaticsError("a cable needs at least one section and one segment")
    for number, section in enumerate(sections):
        values = (section.length, section.axial_stiffness, section.weight, section.normal_drag, section.tangential_drag)
        if not np.all(np.isfinite(values)) or min(section.length, section.axial_stiffness) <= 0.0:
            raise StaticsError(f"section {number}: length and axial_stiffness must be positive, all values finite")
        if min(section.normal_drag, section.tangential_drag) < 0.0:
            raise StaticsError(f"section {number}: drag must not be negative")
    ends = np.cumsum([section.length for section in sections])
    length = float(ends[-1])
    for load in loads:
        if not 0.0 <= load.label <= length * (1.0 + 1e-12):
            raise StaticsError(f"a point load at {load.label:g} m is not on the cable, which is {length:g} m long")
    marks = np.unique(np.concatenate(([0.0], ends, np.minimum([load.label for load in loads], length))))
    marks = marks[np.concatenate(([True], np.diff(marks) > 1e-9 * length))]
    marks[-1] = length
    target = length / segments
    pieces = [
        np.linspace(low, high, max(1, round((high - low) / target)) + 1, dtype=np.float64)[1:]
        for low, high in itertools.pairwise(marks)
    ]
    labels = np.concatenate([np.zeros(1), *pieces])
    table = np.zeros((len(labels) - 1, SEGMENT_COLUMNS))
    middles = 0.5 * (labels[:-1] + labels[1:])
    owners = np.minimum(np.searchsorted(ends, middles), len(sections) - 1)
    table[:, LENGTH] = np.diff(labels)
    for index, owner in enumerate(owners):
        section = sections[int(owner)]
        table[index, STIFFNESS] = section.axial_stiffness
        table[index, WEIGHT] = section.weight
        table[index, NORMAL] = section.normal_drag
        table[index, TANGENTIAL] = section.tangential_drag
    return StaticCable(labels, table, _node_table(labels, loads), feed)


def _node_table(labels: Array, loads: Sequence[PointLoad]) -> Array:
    nodes = np.zeros((len(labels), NODE_COLUMNS))
    for load in loads:
        index = int(np.argmin(np.abs(labels - load.label)))
        nodes[index, FORCE : FORCE + 3] += load.force
        nodes[index, AXIS_DRAG : AXIS_DRAG + 3] += load.axis_drag
        nodes[index, BODY_DRAG] += load.body_drag
    return nodes
